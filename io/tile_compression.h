// How tiles of levels of detail are compressed.
#pragma once

namespace orbweave {

/// kMeshopt: GLB files with the extension EXT_meshopt_compression, without loss.
enum class TileCompression { kNone, kMeshopt };

}  // namespace orbweave
