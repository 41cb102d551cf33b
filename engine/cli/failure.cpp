#include "engine/cli/failure.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <limits>
#include <new>
#include <string_view>
#include <system_error>

#include "engine/cli/exit_status.h"
#include "io/system/temporary_name.h"

namespace orbweave {
namespace {

Failure defect(const std::string& what) {
  return {ErrorKind::kDefect, "a defect in orbweave: " + what +
                                  "; please report it with the command line and the version "
                                  "(orbweave --version)"};
}

constexpr std::string_view kNoMemory =
    "out of memory; give a smaller --memory or --chunk-points, or fewer --threads. "
    "What is done is kept, the same command resumes";
constexpr std::string_view kNoThread =
    "the system starts no more threads: memory (ulimit -v) or processes (ulimit -u) are limited; "
    "give fewer --threads. What is done is kept, the same command resumes";

/// As the standard library or the scheduler says it.
bool is_lack_of_threads(const std::exception& error) {
  const auto* const refusal = dynamic_cast<const std::system_error*>(&error);
  const bool is_of_files =
      dynamic_cast<const std::filesystem::filesystem_error*>(&error) != nullptr;
  if (refusal != nullptr && !is_of_files)
    return refusal->code() == std::errc::resource_unavailable_try_again;
  return std::string_view(error.what()).find("pthread_create") != std::string_view::npos;
}

/// No memory may be left: writes what is there already.
[[noreturn]] void leave(ErrorKind kind, std::string_view what) {
  for (const std::string_view text :
       {std::string_view("orbweave: error: "), what, std::string_view("\n")}) {
    const ssize_t ignored = write(STDERR_FILENO, text.data(), text.size());
    static_cast<void>(ignored);
  }
  remove_temporaries_at_risk();
  _exit(static_cast<int>(exit_status(kind)));
}

[[noreturn]] void on_terminate() {
  try {
    if (std::current_exception() == nullptr)
      leave(ErrorKind::kDefect, "a defect in orbweave: it ended in the middle of its work");
    throw;
  } catch (const Error& error) {
    leave(error.kind(), error.what());
  } catch (const std::bad_alloc&) {
    leave(ErrorKind::kResource, kNoMemory);
  } catch (const std::system_error& error) {
    leave(ErrorKind::kResource, is_lack_of_threads(error) ? kNoThread : error.what());
  } catch (const std::exception& error) {
    if (is_lack_of_threads(error)) leave(ErrorKind::kResource, kNoThread);
    leave(ErrorKind::kDefect, error.what());
  } catch (...) {
    leave(ErrorKind::kDefect, "a defect in orbweave: an unknown exception");
  }
}

/// Opened before memory and descriptors are short.
int statm = -1;

/// Bytes of address space that the process may still get; all that there are where what is used
/// cannot be told. For a handler of signals.
std::uint64_t address_space_left() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
    return std::numeric_limits<std::uint64_t>::max();
  char text[64] = {};
  const ssize_t got = statm < 0 ? 0 : pread(statm, text, sizeof text - 1, 0);
  std::uint64_t pages = 0;
  for (ssize_t i = 0; i < got && text[i] >= '0' && text[i] <= '9'; ++i)
    pages = 10 * pages + static_cast<std::uint64_t>(text[i] - '0');
  const std::uint64_t used = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, used);
}

/// Libraries, HDF5 among them, crash where an allocation of theirs fails. Only where the address
/// space is limited and used up; any other crash stays one.
void on_crash(int signal) {
  constexpr std::uint64_t kShort = std::uint64_t{16} << 20;
  if (address_space_left() < kShort) leave(ErrorKind::kResource, kNoMemory);
  ::signal(signal, SIG_DFL);
  raise(signal);
}

void catch_crashes_for_want_of_memory() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT}) ::signal(signal, on_crash);
}

}  // namespace

void end_plainly_when_nothing_catches() {
  std::set_terminate(on_terminate);
  catch_crashes_for_want_of_memory();
}

Failure current_failure() {
  try {
    throw;
  } catch (const Error& error) {
    return {error.kind(), error.what()};
  } catch (const std::bad_alloc&) {
    return {ErrorKind::kResource, std::string(kNoMemory)};
  } catch (const std::system_error& error) {
    return {ErrorKind::kResource, std::string("the system refused: ") + error.what() +
                                      ". What is done is kept, the same command resumes"};
  } catch (const std::exception& error) {
    if (is_lack_of_threads(error)) return {ErrorKind::kResource, std::string(kNoThread)};
    return defect(error.what());
  } catch (...) {
    return defect("an unknown exception");
  }
}

}  // namespace orbweave
