// Two meshes, or a mesh and a cloud, side by side.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

struct CompareOptions {
  /// Maximum number of points measured on each side; of more points, a sample evenly spaced by
  /// index.
  std::uint64_t max_samples = 2'000'000;
  /// Number of points that are spread over each surface by area; 0: none.
  std::uint64_t area_samples = 500'000;
  /// Distances for which SurfaceAgreement::within is wanted, world units, positive.
  std::vector<double> within;
};

/// Distances from points to a surface (or to the points of a cloud), world units.
struct DistanceSummary {
  std::uint64_t points = 0;    ///< there were
  std::uint64_t measured = 0;  ///< of them; fewer where sampled, or where points are not finite
  double mean = 0.0;
  double rms = 0.0;
  double median = 0.0;
  double percentile_95 = 0.0;
  double max = 0.0;
  bool sampled() const { return measured < points; }
};

/// How many of the points on two surfaces have the other surface near.
struct NearShare {
  double distance = 0.0;   ///< world units
  double precision = 0.0;  ///< share of a's area that is at most so far from b
  double recall = 0.0;     ///< share of b's area that is at most so far from a
  double f_score = 0.0;    ///< harmonic mean of both; 0 where both are 0
};

/// Two surfaces by points that are spread over each by area. Knapitsch, Park, Zhou, Koltun: Tanks
/// and Temples, 2017, section 3, for precision, recall and F-score.
struct SurfaceAgreement {
  DistanceSummary a_to_b, b_to_a;
  /// Largest distance of any of these points or of any vertex of a triangle to the other surface.
  double hausdorff = 0.0;
  /// Mean angle between the normals of a point's triangle and of the nearest on the other surface,
  /// degrees, without regard to their sides; both directions together.
  double normal_angle = 0.0;
  double opposite = 0.0;          ///< share of these points whose normals point to opposite sides
  std::vector<NearShare> within;  ///< as CompareOptions::within
  bool measured() const { return a_to_b.measured > 0 && b_to_a.measured > 0; }
};

struct MeshComparison {
  bool identical = false;     ///< same checksum: same vertices and triangles in the same order
  bool same_surface = false;  ///< same oriented triangles by coordinates, in whatever order
  std::string checksum_a, checksum_b;
  std::uint64_t vertices_a = 0, vertices_b = 0;
  std::uint64_t triangles_a = 0, triangles_b = 0;
  /// From the vertices that triangles of a use to the surface of b; of a cloud from all.
  DistanceSummary a_to_b;
  DistanceSummary b_to_a;
  SurfaceAgreement surface;  ///< not measured where one of them has no triangles
};

/// Compares two meshes in core. A mesh without triangles is taken as its vertices. Distances to
/// or from nothing are not measured (`measured` is 0). On the calling TBB arena; the result does
/// not depend on the number of threads. Throws Error (bad input) for indices outside the vertices.
MeshComparison compare_meshes(const TriangleMesh& a, const TriangleMesh& b,
                              const CompareOptions& options = {});

/// Distance of each vertex of a mesh to the surface of another, world units: NaN where it is not
/// finite, infinite where the other is empty. As compare_meshes.
std::vector<double> vertex_distances(const TriangleMesh& mesh, const TriangleMesh& other);

struct CloudDistances {
  /// From the vertices that the mesh's triangles use to the nearest point; of a cloud from all.
  DistanceSummary mesh_to_cloud;
  DistanceSummary cloud_to_mesh;  ///< from the points to the mesh's surface
  /// From points spread over the mesh by area to the nearest point of the cloud; not measured where
  /// the mesh has no triangles.
  DistanceSummary surface_to_cloud;
  /// As CompareOptions::within: precision is the share of the mesh's area that is at most so far
  /// from a point, recall the share of the points that are at most so far from the mesh.
  std::vector<NearShare> within;
};
/// How a mesh lies to a cloud; as compare_meshes.
CloudDistances distances_to_cloud(const TriangleMesh& mesh, const PointCloud& cloud,
                                  const CompareOptions& options = {});

}  // namespace orbweave
