#include "io/file_descriptor.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "io/error.h"

namespace orbweave {

std::string system_reason(int error) { return std::system_category().message(error); }

std::optional<std::uint64_t> checked_size(int descriptor, const std::string& name) {
  struct stat facts {};
  if (::fstat(descriptor, &facts) != 0)
    throw_bad_input("cannot read the file: " + system_reason(errno), {.file = name});
  if (S_ISDIR(facts.st_mode))
    throw_bad_input("this is a directory",
                    {.file = name, .expected = "a file", .advice = "Name the files inside it."});
  if (!S_ISREG(facts.st_mode)) return std::nullopt;
  if (facts.st_size == 0) throw_bad_input("the file is empty", {.file = name});
  return static_cast<std::uint64_t>(facts.st_size);
}

int open_or_throw(const std::string& name) {
  const int descriptor = ::open(name.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor >= 0) return descriptor;
  if (errno == ENOENT) throw_bad_input("no such file", {.file = name});
  throw_bad_input("cannot open the file: " + system_reason(errno), {.file = name});
}

bool starts_like_gzip(int descriptor) {
  std::array<unsigned char, 2> magic{};
  return ::pread(descriptor, magic.data(), magic.size(), 0) == 2 && magic[0] == 0x1f &&
         magic[1] == 0x8b;
}

}  // namespace orbweave
