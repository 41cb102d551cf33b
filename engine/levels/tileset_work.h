// The directory in which a command keeps the record of the tiles that it makes.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"

namespace orbweave {

/// Makes the directory where it is absent, removes what an earlier run of the command was killed
/// over, and puts what this process writes on record. Its end removes the record, and the directory
/// where nothing else is in it. Throws Error (resource) where another process has such a record
/// there: what that one is writing would be taken for what a kill left.
class TilesetWork {
 public:
  explicit TilesetWork(std::filesystem::path directory);
  ~TilesetWork();
  TilesetWork(const TilesetWork&) = delete;
  TilesetWork& operator=(const TilesetWork&) = delete;

 private:
  std::filesystem::path directory_;
  FileDescriptor held_;  ///< the directory, locked
  std::shared_ptr<OwnedFiles> record_;
  std::optional<RecordScope> scope_;
};

}  // namespace orbweave
