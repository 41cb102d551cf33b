#include "tests/support/data.h"

#include <stdlib.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <stdexcept>
#include <thread>

namespace orbweave::test {

std::filesystem::path data_path(const std::string& relative) {
  const char* set = std::getenv("ORBWEAVE_DATA_DIR");
  return std::filesystem::path(set != nullptr ? set : ORBWEAVE_DATA_DIR) / relative;
}

std::filesystem::path source_path(const std::string& relative) {
  return std::filesystem::path(ORBWEAVE_SOURCE_DIR) / relative;
}

std::filesystem::path program_path() { return ORBWEAVE_PROGRAM; }

bool skipped_without(const std::filesystem::path& file) {
  if (std::filesystem::exists(file)) return false;
  std::cout << "SKIPPED: " << file.string() << " is not here\n";
  return true;
}

bool scratch_in_memory() {
  constexpr const char* kMemory = "/dev/shm";
  // As many tests as there are cores may write there at once, some of them 200 MB.
  constexpr std::uintmax_t kLeast = std::uintmax_t{1} << 30, kPerCore = std::uintmax_t{128} << 20;
  const auto room = kLeast + kPerCore * std::thread::hardware_concurrency();
  std::error_code failed;
  if (access(kMemory, W_OK) != 0) return false;
  if (std::filesystem::space(kMemory, failed).available < room || failed) return false;
  return setenv("TMPDIR", kMemory, 0) == 0;
}

ScratchDirectory::ScratchDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "orbweave-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create " + name);
  path_ = name;
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace orbweave::test
