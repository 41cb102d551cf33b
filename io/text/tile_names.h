// Names that a directory of tiles has.
#pragma once

namespace orbweave {

inline constexpr const char* kTilesExtension = ".tiles";
/// Lists the tiles, and lies among them.
inline constexpr const char* kTileIndex = "tiles.json";

}  // namespace orbweave
