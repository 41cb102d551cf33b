// A directory of mesh files and their index that appears whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/text/tile_names.h"

namespace orbweave {

class OwnedFiles;

/// What an index says that it is, as its `format`.
inline constexpr const char* kTileFormat = "orbweave tiles";

/// "bunny.tiles" of "bunny.ply" and "bunny.ply.gz".
std::filesystem::path tile_directory_of(const std::filesystem::path& mesh);
/// "000012.ply" of "bunny.ply" and 12; ".ply.gz" likewise.
std::string tile_name(const std::filesystem::path& mesh, std::uint32_t number);
/// "448000_4511000.ply" of "city.ply" and "448000_4511000"; ".ply.gz" likewise.
std::string map_tile_name(const std::filesystem::path& mesh, const std::string& cell);
/// XXH3-64 of a file's bytes, which the index has of every tile as hex_digits(). Throws Error
/// (resource).
std::uint64_t file_checksum(const std::filesystem::path& file);

/// What an index says.
struct ListedTile {
  std::uint64_t bytes = 0;
  std::string checksum;
};
struct TileIndex {
  std::uint64_t vertices = 0;   ///< of the mesh
  std::uint64_t triangles = 0;  ///< of the mesh
  std::map<std::string, ListedTile> files;
};

/// Empty: there is no index, or it is damaged.
std::optional<TileIndex> read_tile_index(const std::filesystem::path& directory);
/// Whether a regular file is there with these bytes. Throws Error (resource) where it cannot be
/// read.
bool is_as_listed(const std::filesystem::path& file, const ListedTile& tile);

/// Throws Error where `directory` is there: usage where it holds anything but an index and the
/// tiles that the index lists, byte for byte, for it would be replaced; resource where it cannot be
/// read. Returns the names of what it holds.
std::vector<std::string> check_tile_directory(const std::filesystem::path& directory);

/// Removes a directory of tiles that is on `record`, the index last. False, with nothing removed,
/// where it is not, or where it holds anything that check_tile_directory() refuses or that is not
/// on record.
bool remove_tile_directory(const std::filesystem::path& directory, OwnedFiles& record);

/// Files are made in a directory beside the target, which takes its place in commit(). It is on the
/// process's record (io/system/owned_files.h), as its files are. Destroyed without commit, it
/// removes what was made; after a kill, the next run does. Failures are an Error (resource) with
/// the system's reason.
class TileDirectory {
 public:
  /// `target`: links followed.
  explicit TileDirectory(std::filesystem::path target);
  ~TileDirectory();
  TileDirectory(const TileDirectory&) = delete;
  TileDirectory& operator=(const TileDirectory&) = delete;

  /// Where the files are until commit.
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Throws Error (usage) where by now strangers are in the target.
  void commit();

 private:
  void replace(const std::vector<std::string>& old);
  void clear(const std::filesystem::path& directory) noexcept;

  std::filesystem::path target_;
  std::filesystem::path temporary_;
  std::shared_ptr<OwnedFiles> record_;
};

}  // namespace orbweave
