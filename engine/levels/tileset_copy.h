// A tileset in another folder, with further files beside it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "io/named_text.h"
#include "io/stop_token.h"

namespace orbweave {

struct TilesetCopy {
  std::uint64_t vertices = 0;   ///< of the mesh
  std::uint64_t triangles = 0;  ///< of the mesh
  std::uint64_t bytes = 0;      ///< of all files
};

/// Copies tileset.json and the tiles that the index of `from` lists, byte for byte, writes `beside`
/// and an index of all. `to` is written and replaced as write_tileset() does it. Throws Error (bad
/// input) where `from` is no tileset of this program, or not as it was written, and what
/// write_tileset() throws.
TilesetCopy copy_tileset(const std::filesystem::path& from, const std::filesystem::path& to,
                         const std::vector<NamedText>& beside, const StopToken& stop);

}  // namespace orbweave
