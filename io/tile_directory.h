// A directory of mesh files and their index that appears whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "io/chunk_store_file.h"

namespace orbweave {

inline constexpr const char* kTileIndex = "tiles.json";

/// "bunny.tiles" of "bunny.ply" and "bunny.ply.gz".
std::filesystem::path tile_directory_of(const std::filesystem::path& mesh);
/// "000012.ply" of "bunny.ply" and 12; ".ply.gz" likewise.
std::string tile_name(const std::filesystem::path& mesh, std::uint32_t number);

/// Throws Error where `directory` is there: usage where it holds anything but tiles and their
/// index, for it would be replaced; resource where it cannot be read.
void check_tile_directory(const std::filesystem::path& directory);

/// Files are made in a directory beside the target, which takes its place in commit(). Destroyed
/// without commit, it removes what was made; so it does with what a killed process left. Failures
/// are an Error (resource) with the system's reason.
class TileDirectory {
 public:
  explicit TileDirectory(std::filesystem::path target);
  ~TileDirectory();
  TileDirectory(const TileDirectory&) = delete;
  TileDirectory& operator=(const TileDirectory&) = delete;

  /// Where the files are until commit.
  const std::filesystem::path& temporary() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  FileDescriptor lock_;  // tells that somebody is at work
};

}  // namespace orbweave
