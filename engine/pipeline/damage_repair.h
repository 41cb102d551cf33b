// Repair of a work directory in which a stored result is damaged: what is removed is computed anew.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "io/store/chunk_store.h"

namespace orbweave {

/// Removes a damaged file and what has to be made anew with it, by the table of stages. Throws
/// Error (usage) where the file is not the program's.
void drop_damaged(ChunkStore& store, const std::filesystem::path& file);

/// How often damage was repaired. A device that damages whatever is written to it ends the job.
class Repairs {
 public:
  /// Whether the damage of one more file is repaired.
  bool allow(const std::filesystem::path& file);

 private:
  std::map<std::string, int> of_file_;
  int beginnings_ = 0;  ///< of stages that are made anew as a whole
};

}  // namespace orbweave
