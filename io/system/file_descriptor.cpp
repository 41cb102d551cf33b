#include "io/system/file_descriptor.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/system/file_calls.h"
#include "io/system/system_advice.h"

namespace orbweave {
namespace {

[[noreturn]] void throw_unopened(const std::string& name, int error) {
  if (error == ENOENT) throw_bad_input("no such file", {.file = name});
  throw_unread("cannot open the file", {.file = name}, error);
}

void check_kind(const struct stat& facts, const std::string& name) {
  if (S_ISDIR(facts.st_mode))
    throw_bad_input("this is a directory",
                    {.file = name, .expected = "a file", .advice = "Name the files inside it."});
  if (S_ISREG(facts.st_mode) && facts.st_size == 0)
    throw_bad_input("the file is empty", {.file = name});
}

/// What the file is, where it gives its bytes once; null for any other.
const char* kind_read_once(const std::string& name) {
  if (name == "-") return "standard input";
  struct stat facts {};
  if (::stat(name.c_str(), &facts) != 0) return nullptr;
  if (S_ISFIFO(facts.st_mode)) return "a pipe";
  if (S_ISCHR(facts.st_mode)) return "a device";
  return S_ISSOCK(facts.st_mode) ? "a socket" : nullptr;
}

}  // namespace

FileDescriptor::~FileDescriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

std::optional<std::size_t> read_at(int descriptor, std::uint64_t offset, std::span<std::byte> out) {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t got = ::pread(descriptor, out.data() + done, out.size() - done,
                                static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

bool write_at(int descriptor, std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t wrote =
        file_calls.pwrite(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote == 0) errno = ENOSPC;
    if (wrote <= 0) return false;
    offset += static_cast<std::uint64_t>(wrote);
    bytes = bytes.subspan(static_cast<std::size_t>(wrote));
  }
  return true;
}

std::string system_reason(int error) { return std::system_category().message(error); }

void throw_unread(const std::string& problem, ErrorParts parts, int error) {
  const std::string with_reason = problem + ": " + system_reason(error);
  if (is_lack(error) || is_failure(error)) {
    if (parts.advice.empty()) parts.advice = advice_on(error, "see that the file can be read");
    throw_resource(with_reason, std::move(parts));
  }
  throw_bad_input(with_reason, std::move(parts));
}

std::optional<std::uint64_t> checked_size(int descriptor, const std::string& name) {
  struct stat facts {};
  if (::fstat(descriptor, &facts) != 0) throw_unread("cannot read the file", {.file = name}, errno);
  check_kind(facts, name);
  if (!S_ISREG(facts.st_mode)) return std::nullopt;
  return static_cast<std::uint64_t>(facts.st_size);
}

bool is_read_once(const std::string& name) { return kind_read_once(name) != nullptr; }

void require_rereadable(const std::string& name) {
  const char* const kind = kind_read_once(name);
  if (kind == nullptr) return;
  const bool has_name = name != "-";
  throw Error(
      has_name ? ErrorKind::kBadInput : ErrorKind::kUsage,
      std::string("the file is read more than once, which ") + kind + " does not allow",
      {.file = has_name ? name : "",
       .expected = "the name of a file on disk",
       .advice = "Save it first, such as by: cat " + (has_name ? name + " " : "") + "> FILE"});
}

void require_once_each(std::span<const std::string> names) {
  for (auto name = names.begin(); name != names.end(); ++name)
    if (std::find(names.begin(), name, *name) != name) require_rereadable(*name);
}

void check_readable(const std::string& name) {
  struct stat facts {};
  if (::stat(name.c_str(), &facts) != 0) throw_unopened(name, errno);
  check_kind(facts, name);
  if (::access(name.c_str(), R_OK) != 0) throw_unopened(name, errno);
}

int open_or_throw(const std::string& name) {
  const int descriptor = ::open(name.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw_unopened(name, errno);
  return descriptor;
}

bool starts_like_gzip(int descriptor) {
  std::array<unsigned char, 2> magic{};
  return ::pread(descriptor, magic.data(), magic.size(), 0) == 2 && magic[0] == 0x1f &&
         magic[1] == 0x8b;
}

}  // namespace orbweave
