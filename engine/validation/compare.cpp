#include "engine/validation/compare.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "engine/geometry/triangle_tree.h"
#include "engine/validation/area_samples.h"
#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/mesh_size.h"
#include "io/vec3_order.h"

namespace orbweave {
namespace {

void check_indices(const TriangleMesh& mesh) {
  require_mesh_in_core({}, mesh.vertices.size(), mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    if (*std::max_element(t.begin(), t.end()) >= mesh.vertices.size())
      throw_bad_input("a triangle has a vertex that does not exist");
}

/// The distances are sorted and then summed, so that the sum depends on nothing but them.
DistanceSummary summarized(std::uint64_t points, std::vector<double> distances) {
  DistanceSummary summary;
  summary.points = points;
  summary.measured = distances.size();
  if (distances.empty()) return summary;
  tbb::parallel_sort(distances.begin(), distances.end());
  double sum = 0.0, squares = 0.0;
  const double largest = distances.back();
  for (const double d : distances) {
    sum += d;
    // Relative to the largest: squares of tiny distances must not underflow.
    const double part = largest > 0.0 ? d / largest : 0.0;
    squares += part * part;
  }
  const auto count = static_cast<double>(distances.size());
  summary.mean = sum / count;
  summary.rms = largest * std::sqrt(squares / count);
  summary.median = distances[(distances.size() - 1) / 2];
  summary.percentile_95 = distances[(distances.size() - 1) * 95 / 100];
  summary.max = largest;
  return summary;
}

/// Distances of points, at most options.max_samples of them, to what is in the tree.
std::vector<double> distances(std::span<const Vec3> points, const TriangleTree& tree,
                              const CompareOptions& options) {
  if (tree.empty()) return {};
  const std::uint64_t samples = std::min<std::uint64_t>(points.size(), options.max_samples);
  std::vector<double> found(samples);
  tbb::parallel_for(std::uint64_t{0}, samples, [&](std::uint64_t i) {
    // Evenly by index; 128 bits because the product may not fit 64.
    const auto at = static_cast<std::size_t>(static_cast<__uint128_t>(i) * points.size() / samples);
    found[i] = is_finite(points[at]) ? std::sqrt(tree.squared_distance(points[at])) : -1.0;
  });
  std::erase(found, -1.0);
  return found;
}

/// Triangles by rank of their corners' coordinates, sorted; and those coordinates.
struct OrderFreeSurface {
  std::vector<Vec3> corners;
  std::vector<Triangle> triangles;
  friend bool operator==(const OrderFreeSurface&, const OrderFreeSurface&) = default;
};

OrderFreeSurface order_free(const TriangleMesh& mesh) {
  OrderFreeSurface surface;
  surface.corners.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) surface.corners.push_back(mesh.vertices.positions[v]);
  tbb::parallel_sort(surface.corners.begin(), surface.corners.end(), comes_before);
  surface.corners.erase(std::unique(surface.corners.begin(), surface.corners.end()),
                        surface.corners.end());
  surface.triangles.resize(mesh.triangles.size());
  tbb::parallel_for(std::size_t{0}, mesh.triangles.size(), [&](std::size_t i) {
    Triangle ranks;
    for (int k = 0; k < 3; ++k)
      ranks[k] = static_cast<std::uint32_t>(
          std::lower_bound(surface.corners.begin(), surface.corners.end(),
                           mesh.vertices.positions[mesh.triangles[i][k]], comes_before) -
          surface.corners.begin());
    surface.triangles[i] = smallest_first(ranks);
  });
  tbb::parallel_sort(surface.triangles.begin(), surface.triangles.end());
  return surface;
}

bool all_finite(const TriangleMesh& mesh) {
  return std::all_of(mesh.vertices.positions.begin(), mesh.vertices.positions.end(), is_finite);
}

bool equal_in_some_order(const TriangleMesh& a, const TriangleMesh& b) {
  if (a.triangles.size() != b.triangles.size() || !all_finite(a) || !all_finite(b)) return false;
  if (!a.triangles.empty()) return order_free(a) == order_free(b);
  std::vector<Vec3> of_a = a.vertices.positions, of_b = b.vertices.positions;
  tbb::parallel_sort(of_a.begin(), of_a.end(), comes_before);
  tbb::parallel_sort(of_b.begin(), of_b.end(), comes_before);
  return of_a == of_b;
}

/// A tree needs finite vertices; triangles at others are left out.
TriangleMesh finite_part(const TriangleMesh& mesh) {
  TriangleMesh part;
  const std::vector<Vec3>& positions = mesh.vertices.positions;
  if (mesh.triangles.empty()) {
    std::copy_if(positions.begin(), positions.end(), std::back_inserter(part.vertices.positions),
                 is_finite);
    return part;
  }
  part.vertices.positions = positions;
  for (const Triangle& t : mesh.triangles)
    if (is_finite(positions[t[0]]) && is_finite(positions[t[1]]) && is_finite(positions[t[2]]))
      part.triangles.push_back(t);
  // Without any triangle left the tree must not fall back to the vertices.
  if (part.triangles.empty()) part.vertices.positions.clear();
  return part;
}

/// The vertices that triangles use: others are no part of the surface. Without triangles all.
std::vector<Vec3> points_of_surface(const TriangleMesh& mesh) {
  const std::vector<Vec3>& positions = mesh.vertices.positions;
  if (mesh.triangles.empty()) return positions;
  std::vector<std::uint8_t> is_used(positions.size());
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) is_used[v] = 1;
  std::vector<Vec3> points;
  points.reserve(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v)
    if (is_used[v] != 0) points.push_back(positions[v]);
  return points;
}

std::vector<double> distances_to(std::span<const Vec3> points, const TriangleMesh& mesh,
                                 const CompareOptions& options) {
  if (all_finite(mesh)) return distances(points, TriangleTree(mesh), options);
  const TriangleMesh part = finite_part(mesh);
  return distances(points, TriangleTree(part), options);
}

/// Points of one surface, and what is nearest to them on the other.
struct SampleDistances {
  std::vector<double> distances;
  std::vector<double> cosines;  ///< of the angles between normals
};

SampleDistances distances_of(const AreaSamples& samples, const TriangleMesh& other) {
  const TriangleTree tree(other);
  const std::size_t count = samples.positions.size();
  SampleDistances found{std::vector<double>(count), std::vector<double>(count)};
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const TriangleTree::Nearest nearest = tree.nearest(samples.positions[i]);
    found.distances[i] = std::sqrt(nearest.squared_distance);
    const Triangle& t = other.triangles[nearest.item];
    const std::vector<Vec3>& p = other.vertices.positions;
    const Vec3 normal = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    const double length = norm(normal);
    found.cosines[i] =
        length > 0.0 ? std::clamp(dot(normal, samples.normals[i]) / length, -1.0, 1.0) : 1.0;
  });
  return found;
}

double share_within(const std::vector<double>& distances, double limit) {
  const auto near =
      std::count_if(distances.begin(), distances.end(), [&](double d) { return d <= limit; });
  return static_cast<double>(near) / static_cast<double>(distances.size());
}

std::vector<NearShare> near_shares(const std::vector<double>& from_a,
                                   const std::vector<double>& from_b,
                                   const std::vector<double>& limits) {
  std::vector<NearShare> shares;
  for (const double limit : limits) {
    NearShare share{limit, share_within(from_a, limit), share_within(from_b, limit), 0.0};
    if (const double both = share.precision + share.recall; both > 0.0)
      share.f_score = 2.0 * share.precision * share.recall / both;
    shares.push_back(share);
  }
  return shares;
}

void add_normals(const SampleDistances& side, double& angles, double& opposite) {
  for (const double cosine : side.cosines) {
    angles += std::acos(std::abs(cosine));
    opposite += cosine < 0.0 ? 1.0 : 0.0;
  }
}

SurfaceAgreement agreement(const TriangleMesh& a, const TriangleMesh& b,
                           const CompareOptions& options) {
  SurfaceAgreement result;
  const AreaSamples on_a = sample_by_area(a, options.area_samples);
  const AreaSamples on_b = sample_by_area(b, options.area_samples);
  if (on_a.positions.empty() || on_b.positions.empty()) return result;
  const SampleDistances from_a = distances_of(on_a, b), from_b = distances_of(on_b, a);
  result.within = near_shares(from_a.distances, from_b.distances, options.within);
  double angles = 0.0, opposite = 0.0;
  add_normals(from_a, angles, opposite);
  add_normals(from_b, angles, opposite);
  const auto points = static_cast<double>(from_a.cosines.size() + from_b.cosines.size());
  result.normal_angle = angles / points * 180.0 / std::numbers::pi;
  result.opposite = opposite / points;
  result.a_to_b = summarized(from_a.distances.size(), from_a.distances);
  result.b_to_a = summarized(from_b.distances.size(), from_b.distances);
  result.hausdorff = std::max(result.a_to_b.max, result.b_to_a.max);
  return result;
}

/// Samples and nearest triangles need finite vertices.
SurfaceAgreement agreement_of_finite(const TriangleMesh& a, const TriangleMesh& b,
                                     const CompareOptions& options) {
  if (a.triangles.empty() || b.triangles.empty() || options.area_samples == 0) return {};
  if (all_finite(a) && all_finite(b)) return agreement(a, b, options);
  return agreement(finite_part(a), finite_part(b), options);
}

}  // namespace

MeshComparison compare_meshes(const TriangleMesh& a, const TriangleMesh& b,
                              const CompareOptions& options) {
  check_indices(a);
  check_indices(b);
  MeshComparison result;
  result.vertices_a = a.vertices.size();
  result.vertices_b = b.vertices.size();
  result.triangles_a = a.triangles.size();
  result.triangles_b = b.triangles.size();
  result.checksum_a = mesh_checksum(a.vertices.positions, a.triangles);
  result.checksum_b = mesh_checksum(b.vertices.positions, b.triangles);
  // Without triangles there is no surface: the vertices themselves are compared.
  const bool clouds = a.triangles.empty() && b.triangles.empty();
  result.identical = clouds ? a.vertices.positions == b.vertices.positions
                            : result.checksum_a == result.checksum_b;
  result.same_surface = result.identical || equal_in_some_order(a, b);
  const auto from_vertices = [&](const TriangleMesh& from, const TriangleMesh& to) {
    const std::vector<Vec3> points = points_of_surface(from);
    return summarized(points.size(), distances_to(points, to, options));
  };
  result.a_to_b = from_vertices(a, b);
  result.b_to_a = from_vertices(b, a);
  result.surface = agreement_of_finite(a, b, options);
  if (result.surface.measured())
    result.surface.hausdorff =
        std::max({result.surface.hausdorff, result.a_to_b.max, result.b_to_a.max});
  return result;
}

std::vector<double> vertex_distances(const TriangleMesh& mesh, const TriangleMesh& other) {
  check_indices(other);
  const TriangleMesh part = finite_part(other);
  const TriangleTree tree(part);
  const std::vector<Vec3>& positions = mesh.vertices.positions;
  std::vector<double> found(positions.size());
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
    found[i] = is_finite(positions[i]) ? std::sqrt(tree.squared_distance(positions[i]))
                                       : std::numeric_limits<double>::quiet_NaN();
  });
  return found;
}

CloudDistances distances_to_cloud(const TriangleMesh& mesh, const PointCloud& cloud,
                                  const CompareOptions& options) {
  check_indices(mesh);
  TriangleMesh points;
  points.vertices.positions = cloud.positions;
  CloudDistances result;
  const std::vector<Vec3> of_mesh = points_of_surface(mesh);
  result.mesh_to_cloud = summarized(of_mesh.size(), distances_to(of_mesh, points, options));
  const std::vector<double> to_mesh = distances_to(cloud.positions, mesh, options);
  result.cloud_to_mesh = summarized(cloud.size(), to_mesh);
  const AreaSamples samples = sample_by_area(mesh, options.area_samples);
  const std::vector<double> to_cloud = distances_to(samples.positions, points, options);
  result.surface_to_cloud = summarized(samples.positions.size(), to_cloud);
  if (!to_mesh.empty() && !to_cloud.empty())
    result.within = near_shares(to_cloud, to_mesh, options.within);
  return result;
}

}  // namespace orbweave
