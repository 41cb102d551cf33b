// One simplified mesh of a mesh of any size, out of core, by its levels of detail.
//
// The octree of engine/levels/levels.h is made from the leaves up as long as nodes are fine enough:
// until they have fewer triangles than their share of those that are wanted, or are farther from
// the mesh than the error that is allowed. The coarsest nodes that serve are simplified once more,
// each to its share or to what is left of the error, with borders as they are. So the pieces fit
// together vertex by vertex.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "engine/levels/levels.h"
#include "io/meshes/mesh_writer.h"
#include "io/simplify_target.h"

namespace orbweave {

struct SimplifyOptions {
  LevelOptions levels;
  SimplifyTarget target;
  /// How the file is written, by the bounds of the mesh that is read.
  std::function<MeshWriterOptions(const Box& bounds)> written;
};

/// What happens on the way. Calls come from several threads.
struct SimplifyEvents {
  std::function<void(std::uint64_t triangles)> read;   ///< of the mesh, since the last call
  std::function<void(std::uint32_t nodes)> planned;    ///< all triangles are read; most nodes
  std::function<void()> made;                          ///< one node more
  std::function<void(std::uint64_t triangles)> begun;  ///< writing so many triangles begins
  std::function<void(std::uint64_t triangles)> written;
};

struct SimplifiedFacts {
  std::uint64_t vertices_read = 0;
  std::uint64_t triangles_read = 0;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t nodes = 0;           ///< of levels, made or not
  std::uint64_t nodes_reused = 0;    ///< that an earlier run simplified
  std::uint64_t most_triangles = 0;  ///< that were asked for; 0: an error was
  /// How far the two surfaces are apart, world units, as engine/levels/simplify.h measures it,
  /// added up over the levels.
  double error = 0.0;
  bool fills_holes = false;      ///< a face of the result fills a hole
  bool has_confidence = false;   ///< and faces say how sure the patch is
  Vec3 origin;                   ///< that the file's coordinates are counted from
  std::uint64_t bytes = 0;       ///< of the file
  std::uint64_t work_bytes = 0;  ///< of the files without a name, when the pieces were made
};

/// That there are more triangles than asked for, and why; empty where there are not.
std::string missed_limit(const SimplifiedFacts& facts);

/// Reads the mesh twice and writes the simplified one. Its vertices are vertices of the mesh, in
/// their order, with all that they carry. A triangle fills the hole of that triangle of the mesh
/// which is nearest to it among those around its corners. Triangles come by the cells of the
/// octree. The bytes depend on the mesh, the target and the leaves' size alone. There are at most
/// as many triangles as asked for where borders between nodes, rims and handles allow that. Throws
/// Error as make_levels() does, and where the file cannot be written.
SimplifiedFacts write_simplified(const std::filesystem::path& mesh,
                                 const std::filesystem::path& target,
                                 const SimplifyOptions& options, const SimplifyEvents& events,
                                 const StopToken& stop);

}  // namespace orbweave
