// Where tests find real scans and a place to write.
#pragma once

#include <filesystem>
#include <string>

namespace orbweave::test {

/// Path of a file below the data directory (CMake variable ORBWEAVE_DATA_DIR); the environment
/// variable of the same name wins.
std::filesystem::path data_path(const std::string& relative);
/// Path of a file in the repository.
std::filesystem::path source_path(const std::string& relative);
/// The orbweave program of this build.
std::filesystem::path program_path();

/// True, after printing "SKIPPED: <file>", when the file is absent; the test then returns.
bool skipped_without(const std::filesystem::path& file);

/// Scratch directories lie in memory from here on, where there is such a place and TMPDIR names no
/// other: for tests that flush thousands of files. Returns whether they do.
bool scratch_in_memory();

/// A fresh directory that is removed with the object.
class ScratchDirectory {
 public:
  ScratchDirectory();
  ~ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace orbweave::test
