// The files of a folder, to compare what two runs wrote.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "tests/io/reading.h"

namespace orbweave::test {

/// The bytes of the files of a folder, by name; the folder has no folders.
inline std::map<std::string, std::string> files_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files[entry.path().filename().string()] = read_file(entry.path());
  return files;
}

}  // namespace orbweave::test
