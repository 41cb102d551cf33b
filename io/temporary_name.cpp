#include "io/temporary_name.h"

#include <sys/file.h>
#include <sys/stat.h>

#include <cerrno>
#include <random>

namespace orbweave {
namespace {

constexpr std::size_t kRandomDigits = 16;
constexpr std::string_view kDigits = "0123456789abcdef";
constexpr std::string_view kSuffix = ".part";

}  // namespace

std::filesystem::path directory_of(const std::filesystem::path& target) {
  return target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
}

std::filesystem::path temporary_beside(const std::filesystem::path& target) {
  std::random_device device;
  std::string name = "." + target.filename().string() + ".";
  for (std::size_t i = 0; i < kRandomDigits; ++i) name += kDigits[device() % kDigits.size()];
  name += kSuffix;
  return directory_of(target) / name;
}

bool is_temporary_of(std::string_view name, const std::string& stem) {
  const std::string prefix = "." + stem + ".";
  if (!name.starts_with(prefix) || !name.ends_with(kSuffix)) return false;
  name.remove_suffix(kSuffix.size());
  if (name.size() < prefix.size() + kRandomDigits) return false;
  const std::string_view random = name.substr(name.size() - kRandomDigits);
  return name[name.size() - kRandomDigits - 1] == '.' &&
         random.find_first_not_of(kDigits) == std::string_view::npos;
}

bool keep_temporary(int descriptor) {
  // Where locks do not work nobody can take it for abandoned. Who does holds the lock for a moment.
  while (::flock(descriptor, LOCK_EX) != 0)
    if (errno != EINTR) return true;
  struct stat facts {};
  return ::fstat(descriptor, &facts) != 0 || facts.st_nlink > 0;
}

}  // namespace orbweave
