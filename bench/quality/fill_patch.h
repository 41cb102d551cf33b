// A filled hole, by any program, and how good the patch is.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bench/quality/fill_discs.h"
#include "io/surface_options.h"

namespace orbweave::bench {

/// Triangles that close a disc's rim: vertex numbers of the whole mesh, new ones after them.
struct Patch {
  bool filled = false;
  std::vector<Vec3> positions;  ///< of the new vertices
  std::vector<Triangle> triangles;
  double seconds = 0.0;  ///< of the one hole
  std::string method, reason;
  std::uint64_t sites = 0;
  double rim_mean_deg = 0.0, confidence = 0.0;  ///< of the engine alone
};

/// Fills the disc's hole in a part of the mesh around it by the engine.
Patch fill_by_engine(const MeshIndex& index, const Disc& disc, const Cut& around,
                     const FillOptions& options);

struct PatchQuality {
  bool closed = false;  ///< edge by edge: the rim's once, all others twice, none of the mesh's
  double rms = 0.0;     ///< of the removed points' distances to the patch, world units
  double max = 0.0;
  double back_rms = 0.0;  ///< of the new vertices' distances to what was cut out
  double back_max = 0.0;
  double normal_mean_deg = 0.0;  ///< removed vertex's normal to that of the nearest patch face
  double normal_max_deg = 0.0;
  double rim_dihedral_deg = 0.0;         ///< largest angle between faces on either side of the rim
  std::uint64_t self_intersections = 0;  ///< pairs of faces, one at least of the patch
};

/// The removed vertices of the scan (all but those that an earlier fill made) that are measured.
std::vector<std::uint32_t> measured_points(const MeshIndex& index, const Disc& disc);

PatchQuality quality_of(const MeshIndex& index, const Disc& disc, const Patch& patch);

/// Position of a vertex of the mesh or of the patch.
Vec3 position_of(const MeshIndex& index, const Patch& patch, std::uint32_t vertex);
/// The patch alone as a mesh.
TriangleMesh patch_mesh(const MeshIndex& index, const Patch& patch);

}  // namespace orbweave::bench
