#include "tests/support/snapshot.h"

#include <sys/stat.h>

#include "tests/support/program.h"

namespace orbweave::test {

namespace fs = std::filesystem;

std::map<std::string, std::string> snapshot(const fs::path& directory) {
  std::map<std::string, std::string> entries;
  const auto add = [&](const fs::path& path) {
    struct stat facts {};
    if (::lstat(path.c_str(), &facts) != 0) return;
    std::string text = std::to_string(facts.st_ino) + " " + std::to_string(facts.st_mode) + " " +
                       std::to_string(facts.st_nlink) + " " + std::to_string(facts.st_size) + " " +
                       std::to_string(facts.st_mtim.tv_sec) + "." +
                       std::to_string(facts.st_mtim.tv_nsec);
    if (S_ISREG(facts.st_mode)) text += " " + file_text(path);
    if (S_ISLNK(facts.st_mode)) text += " -> " + fs::read_symlink(path).string();
    entries[fs::relative(path.parent_path(), directory).string() + "/" + path.filename().string()] =
        text;
  };
  add(directory);
  for (const auto& entry : fs::recursive_directory_iterator(directory)) add(entry.path());
  return entries;
}

}  // namespace orbweave::test
