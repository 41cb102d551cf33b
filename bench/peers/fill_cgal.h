// The peer of the hole pass, and judge over both: CGAL (GPL; used in the benchmarks alone).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bench/quality/fill_patch.h"

namespace orbweave::bench {

/// Polygon_mesh_processing::triangulate_refine_and_fair_hole; its defaults are continuity 1 and
/// density sqrt(2).
Patch fill_by_cgal(const MeshIndex& index, const Disc& disc, const Cut& around,
                   unsigned continuity = 1);

/// Pairs of faces that meet otherwise than in what they share, one at least of the patch; the
/// largest number where the mesh with the patch is no manifold.
std::uint64_t count_self_intersections(const MeshIndex& index, const Cut& around,
                                       const Patch& patch);

/// Nearest places of a mesh, through CGAL's AABB tree.
class NearestFace {
 public:
  explicit NearestFace(const TriangleMesh& mesh);
  ~NearestFace();
  struct Found {
    double squared_distance = 0.0;
    std::uint32_t face = 0;
  };
  Found operator()(Vec3 place) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace orbweave::bench
