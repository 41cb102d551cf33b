#include "engine/cli/failure.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <limits>
#include <new>
#include <string_view>
#include <system_error>

#include "engine/cli/exit_status.h"
#include "engine/cli/signals.h"
#include "io/stop_token.h"
#include "io/system/system_advice.h"
#include "io/system/temporary_name.h"

namespace orbweave {
namespace {

Failure defect(const std::string& what) {
  return {ErrorKind::kDefect, "a defect in orbweave: " + what +
                                  "; please report it with the command line and the version "
                                  "(orbweave --version)"};
}

constexpr std::string_view kNoMemory =
    "out of memory; give a smaller --memory or fewer --threads, if the command has these options";
constexpr std::string_view kNoThread =
    "the system starts no more threads: memory (ulimit -v) or processes (ulimit -u) are limited; "
    "give fewer --threads";
constexpr std::string_view kResumes = ". What is done is kept, the same command resumes";

std::atomic<bool> resumes{false};

/// What to say of a lack: with the promise where there is one.
std::string with_promise(std::string_view lack) {
  return std::string(lack) + (resumes ? std::string(kResumes) : "");
}

/// No memory may be left: writes what is there already.
[[noreturn]] void leave(ErrorKind kind, std::string_view what, bool promises = false) {
  const std::string_view promise = promises && resumes ? kResumes : "";
  for (const std::string_view text :
       {std::string_view("orbweave: error: "), what, promise, std::string_view("\n")}) {
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
    leave(ErrorKind::kResource, kNoMemory, true);
  } catch (const std::system_error& error) {
    leave(ErrorKind::kResource, is_lack_of_threads(error) ? kNoThread : error.what(), true);
  } catch (const std::exception& error) {
    if (is_lack_of_threads(error)) leave(ErrorKind::kResource, kNoThread, true);
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
  if (address_space_left() < kShort) leave(ErrorKind::kResource, kNoMemory, true);
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

void promise_to_resume() { resumes = true; }

void end_plainly_when_nothing_catches() {
  std::set_terminate(on_terminate);
  catch_crashes_for_want_of_memory();
}

Failure current_failure() {
  try {
    throw;
  } catch (const Error& error) {
    const bool is_bare = error.kind() == ErrorKind::kInterrupted &&
                         std::string_view(error.what()) == kInterruptedText;
    if (!is_bare) return {error.kind(), error.what()};
    return {error.kind(), resumes ? with_promise(kInterruptedText) : interruption()};
  } catch (const std::bad_alloc&) {
    return {ErrorKind::kResource, with_promise(kNoMemory)};
  } catch (const std::system_error& error) {
    return {ErrorKind::kResource,
            with_promise(is_lack_of_threads(error)
                             ? std::string(kNoThread)
                             : std::string("the system refused: ") + error.what())};
  } catch (const std::exception& error) {
    if (is_lack_of_threads(error)) return {ErrorKind::kResource, with_promise(kNoThread)};
    return defect(error.what());
  } catch (...) {
    return defect("an unknown exception");
  }
}

}  // namespace orbweave
