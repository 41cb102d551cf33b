// Levels of detail as 3D Tiles 1.1 (OGC 22-025r4): a folder that a browser streams.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/levels/level_distances.h"
#include "engine/levels/levels.h"
#include "io/named_text.h"
#include "io/surface_options.h"

namespace orbweave {

struct TilesetOptions {
  LevelOptions levels;
  /// Of the mesh: WKT or a code; empty: not known. Where PROJ can transform it to the Earth, the
  /// tileset lies there.
  std::string coordinate_system;
  bool measures = false;          ///< how far each level is from the mesh
  std::vector<NamedText> beside;  ///< further files of the folder
  TileCompression compression = TileCompression::kNone;
  int up_axis = 2;  ///< that is upright where the tileset does not lie on the Earth; 0: x, ...
};

struct TilesetEvents {
  std::function<void(std::uint64_t triangles)> read;  ///< since the last call
  std::function<void(std::uint32_t tiles)> planned;   ///< all triangles are read
  std::function<void()> written;                      ///< one tile more
  std::function<void()> measuring;                    ///< all tiles are written; measuring begins
};

/// All tiles of one height.
struct TilesetLevel {
  std::uint64_t tiles = 0;
  std::uint64_t triangles = 0;
  std::uint64_t border_triangles = 0;
  double error = 0.0;  ///< stated: the largest of its tiles
  std::optional<LevelDistance> measured;
};

struct TilesetFacts {
  std::uint64_t vertices = 0;    ///< of the mesh
  std::uint64_t triangles = 0;   ///< of the mesh
  std::uint64_t bytes = 0;       ///< of all files
  std::uint64_t work_bytes = 0;  ///< of the files without a name, at the end
  bool is_on_earth = false;
  std::vector<TilesetLevel> levels;  ///< by height, the leaves first
  std::uint64_t tiles = 0;           ///< of all levels
  std::uint64_t reused = 0;          ///< tiles that an earlier run simplified
};

inline constexpr const char* kTilesetName = "tileset.json";

/// Writes the tiles ("000012.glb"), tileset.json and an index of all files (tiles.json), by which a
/// later run knows that it may replace the folder. The folder appears whole or not at all. Its
/// bytes depend on the mesh, the leaves' size and the compression alone. Files are put on the
/// process's record, which there has to be. Throws Error as make_levels() does, and (usage) where
/// `directory` holds anything else than an earlier tileset.
TilesetFacts write_tileset(MeshStream& mesh, const std::filesystem::path& directory,
                           const TilesetOptions& options, const TilesetEvents& events,
                           const StopToken& stop);

}  // namespace orbweave
