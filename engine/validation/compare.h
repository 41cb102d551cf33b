// Two meshes, or a mesh and a cloud, side by side.
#pragma once

#include <cstdint>
#include <string>

#include "io/triangle_mesh.h"

namespace orbweave {

struct CompareOptions {
  /// Maximum number of points measured on each side; of more points, a sample evenly spaced by
  /// index.
  std::uint64_t max_samples = 2'000'000;
};

/// Distances from points to a surface (or to the points of a cloud), world units.
struct DistanceSummary {
  std::uint64_t points = 0;    ///< there were
  std::uint64_t measured = 0;  ///< of them; fewer where sampled, or where points are not finite
  double mean = 0.0;
  double rms = 0.0;
  double percentile_95 = 0.0;
  double max = 0.0;
  bool sampled() const { return measured < points; }
};

struct MeshComparison {
  bool identical = false;     ///< same checksum: same vertices and triangles in the same order
  bool same_surface = false;  ///< same oriented triangles by coordinates, in whatever order
  std::string checksum_a, checksum_b;
  std::uint64_t vertices_a = 0, vertices_b = 0;
  std::uint64_t triangles_a = 0, triangles_b = 0;
  DistanceSummary a_to_b;  ///< from the vertices of a to the surface of b
  DistanceSummary b_to_a;
};

/// Compares two meshes in core. A mesh without triangles is taken as its vertices. Distances to
/// or from nothing are not measured (`measured` is 0). On the calling TBB arena; the result does
/// not depend on the number of threads. Throws Error (bad input) for indices outside the vertices.
MeshComparison compare_meshes(const TriangleMesh& a, const TriangleMesh& b,
                              const CompareOptions& options = {});

struct CloudDistances {
  DistanceSummary mesh_to_cloud;  ///< from the mesh's vertices to the nearest point
  DistanceSummary cloud_to_mesh;  ///< from the points to the mesh's surface
};
/// How a mesh lies to a cloud; as compare_meshes.
CloudDistances distances_to_cloud(const TriangleMesh& mesh, const PointCloud& cloud,
                                  const CompareOptions& options = {});

}  // namespace orbweave
