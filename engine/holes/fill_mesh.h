// The hole pass on a mesh in core: for meshes from elsewhere, tests and benchmarks. The pipeline
// runs the same steps over the chunk store (engine/pipeline/surface/hole_stage.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "io/hole_facts.h"
#include "io/stop_token.h"
#include "io/surface_options.h"
#include "io/triangle_mesh.h"

namespace orbweave {

struct FilledMesh {
  TriangleMesh mesh;             ///< given vertices and triangles first, then the patches', then
                                 ///< copies of vertices where several fans met
  std::vector<HoleFacts> holes;  ///< every loop, in canonical order
  std::uint64_t pieces_removed = 0;
  std::uint64_t triangles_removed = 0;  ///< of them
  std::uint64_t vertices_doubled = 0;   ///< where several fans were left
  std::uint64_t pinches = 0;            ///< of these the originals
  /// Taken out so that holes are closed soundly: flaps, and what closed objects lost.
  std::uint64_t triangles_mended = 0;
};

/// Called with 0 of all holes that are to be filled before the first of them, then once for each
/// that was filled or given up, from any thread, several at a time.
using HoleProgress = std::function<void(std::uint64_t done, std::uint64_t holes)>;

struct FillMeshSettings {
  const StopToken* stop = nullptr;  ///< looked at before every hole
  /// The vertices' normals are those of scanned points and say where outside is, as in a job; else
  /// the triangles' normals do.
  bool has_point_normals = false;
  /// Pieces that are too small, and crumbs of closed objects, go before anything is filled, and
  /// their vertices with them; needs normals of points. Else fill.min_triangles alone counts, and
  /// vertices stay.
  bool drops_small_pieces = false;
  /// Flaps at the rims of an open scene (rim_flaps.h) go before anything is filled, and vertices
  /// that only they used, as in a job.
  bool takes_flaps = false;
  HoleProgress progress = {};
};

/// Throws Error (bad input) where ids of holes that the mesh has already are too large to go on
/// after.
void require_room_for_ids(const std::filesystem::path& file, const TriangleMesh& mesh);

/// Fills the holes of a mesh. Loops are numbered in the order of their vertices. Normals of new
/// vertices are written where the mesh has normals, attributes are interpolated. The mesh must
/// have no degenerate and no repeated triangles; loops that run into an edge of more than two
/// triangles or of two in the same direction stay open. Throws Error (resource) for a mesh that is
/// too large (io/mesh_size.h), and as require_room_for_ids. Runs on the calling TBB arena; the
/// result does not depend on the number of threads.
FilledMesh fill_mesh(TriangleMesh mesh, const FillOptions& options,
                     const FillMeshSettings& settings = {});

/// The loops and what would become of them, nothing filled (`filled` is false for all; `reason`
/// says why where one would stay open).
std::vector<HoleFacts> list_holes(const TriangleMesh& mesh, const FillOptions& options);

}  // namespace orbweave
