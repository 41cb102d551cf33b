#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/peers/fill_cgal.h"
#include "bench/quality/fill_patch.h"
#include "bench/quality/fill_workloads.h"
#include "engine/holes/rbf/rbf.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"

namespace orbweave::bench {
namespace {

using nlohmann::json;

/// The hole plane: through the points' mean, across the axis of their least spread.
struct HoleFrame {
  Vec3 origin, u, v, w;
  Vec3 of(Vec3 p) const { return {dot(p - origin, u), dot(p - origin, v), dot(p - origin, w)}; }
};

HoleFrame principal_frame(const std::vector<Vec3>& points) {
  HoleFrame frame;
  for (const Vec3 p : points) frame.origin = frame.origin + p;
  frame.origin = frame.origin / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3 p : points) {
    const Vec3 d = p - frame.origin;
    const Eigen::Vector3d column(d.x, d.y, d.z);
    spread += column * column.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const auto axis = [&](int k) {
    const Eigen::Vector3d column = solver.eigenvectors().col(k);
    return Vec3{column.x(), column.y(), column.z()};
  };
  frame.w = axis(0);
  frame.u = axis(2);
  frame.v = cross(frame.w, frame.u);
  return frame;
}

/// Height at (x, y) of the triangle of a mesh in the frame that is nearest to z there.
std::optional<double> height_at(const TriangleMesh& mesh, Vec3 place) {
  std::optional<double> best;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices.positions[t[0]], b = mesh.vertices.positions[t[1]],
               c = mesh.vertices.positions[t[2]];
    const auto twice_area = [](Vec3 p, Vec3 q, Vec3 r) {
      return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    };
    const double area = twice_area(a, b, c);
    if (area == 0.0) continue;
    const double wa = twice_area(b, c, place) / area, wb = twice_area(c, a, place) / area;
    if (wa < 0.0 || wb < 0.0 || wa + wb > 1.0) continue;
    const double height = wa * a.z + wb * b.z + (1.0 - wa - wb) * c.z;
    if (!best || std::abs(height - place.z) < std::abs(*best - place.z)) best = height;
  }
  return best;
}

json statistics_of(std::vector<double> errors) {
  if (errors.empty()) return {{"count", 0}};
  std::sort(errors.begin(), errors.end());
  double sum = 0.0, squares = 0.0;
  for (const double e : errors) {
    sum += e;
    squares += e * e;
  }
  const auto count = static_cast<double>(errors.size());
  return {{"count", errors.size()}, {"mean", sum / count},  {"median", errors[errors.size() / 2]},
          {"min", errors.front()},  {"max", errors.back()}, {"rms", std::sqrt(squares / count)}};
}

/// What the paper does: the removed points' x and y give a new height.
std::vector<double> spline_errors(const HoleFrame& frame, const std::vector<Vec3>& sites,
                                  const std::vector<Vec3>& removed, RbfKernel kernel) {
  std::vector<RbfSite> places;
  std::vector<double> heights;
  for (const Vec3 p : sites) {
    const Vec3 local = frame.of(p);
    places.push_back({local.x, local.y, 0.0});
    heights.push_back(local.z);
  }
  RbfOptions options;
  options.kernel = kernel;
  options.max_sites = static_cast<std::uint32_t>(sites.size());
  const RbfInterpolant spline(places, heights, 1, options);
  std::vector<double> errors;
  if (!spline.valid()) return errors;
  for (const Vec3 p : removed) {
    const Vec3 local = frame.of(p);
    errors.push_back(std::abs(spline.evaluate({local.x, local.y, 0.0}) - local.z));
  }
  return errors;
}

struct PatchErrors {
  std::vector<double> heights, distances;
  std::size_t beside = 0;  ///< removed points that the patch lies neither above nor below
};

PatchErrors patch_errors(const HoleFrame& frame, TriangleMesh patch,
                         const std::vector<Vec3>& removed) {
  PatchErrors errors;
  if (patch.triangles.empty()) return errors;
  const NearestFace nearest(patch);
  for (const Vec3 p : removed) errors.distances.push_back(std::sqrt(nearest(p).squared_distance));
  for (Vec3& p : patch.vertices.positions) p = frame.of(p);
  for (const Vec3 p : removed) {
    const Vec3 local = frame.of(p);
    const std::optional<double> height = height_at(patch, local);
    if (height) {
      errors.heights.push_back(std::abs(*height - local.z));
    } else {
      ++errors.beside;
    }
  }
  return errors;
}

Vec3 rim_center(const MeshIndex& index, const Disc& disc) {
  Vec3 sum;
  for (const std::uint32_t v : disc.rim) sum = sum + index.mesh().vertices.positions[v];
  return sum / static_cast<double>(disc.rim.size());
}

std::uint32_t nearest_vertex(const TriangleMesh& mesh, Vec3 place) {
  const std::vector<Vec3>& positions = mesh.vertices.positions;
  const auto nearest = std::min_element(positions.begin(), positions.end(), [&](Vec3 a, Vec3 b) {
    return squared_norm(a - place) < squared_norm(b - place);
  });
  return static_cast<std::uint32_t>(nearest - positions.begin());
}

/// Of the ball around the rim's centre, as the hole pass measures a hole.
double rim_radius(const MeshIndex& index, const Disc& disc) {
  const Vec3 center = rim_center(index, disc);
  double radius = 0.0;
  for (const std::uint32_t v : disc.rim) {
    radius = std::max(radius, norm(index.mesh().vertices.positions[v] - center));
  }
  return radius;
}

void measure(const MeshIndex& index, const Disc& disc, double neighborhood_radius,
             const HeightWorkload& work) {
  const Cut around =
      cut_part(index, connected_within(index, disc.center, 3.0 * neighborhood_radius), disc.faces);
  std::vector<Vec3> sites, removed;
  const Vec3 center = rim_center(index, disc);
  for (const Vec3 p : around.mesh.vertices.positions) {
    if (norm(p - center) <= neighborhood_radius) sites.push_back(p);
  }
  for (const std::uint32_t v : disc.removed) {
    removed.push_back(index.mesh().vertices.positions[v]);
  }
  const bool is_triharmonic = work.kernel == "triharmonic";
  const HoleFrame frame = principal_frame(sites);
  FillOptions options;
  options.kernel = is_triharmonic ? FillKernel::kTriharmonic : FillKernel::kBiharmonic;
  options.neighborhood = std::max(1.0, neighborhood_radius / rim_radius(index, disc));
  options.max_edges = disc.rim.size();
  options.keep_outer_border = false;
  const Patch patch = fill_by_engine(index, disc, around, options);
  const PatchErrors errors = patch_errors(frame, patch_mesh(index, patch), removed);
  const Vec3 place = index.mesh().vertices.positions[disc.center];
  const json line = {
      {"center", disc.center},
      {"place", {place.x, place.y, place.z}},
      {"hole_radius", work.radius},
      {"rim_radius", rim_radius(index, disc)},
      {"neighborhood_radius", neighborhood_radius},
      {"removed_points", removed.size()},
      {"rim_edges", disc.rim.size()},
      {"sites", sites.size()},
      {"method", patch.method},
      {"reason", patch.reason},
      {"new_points", patch.positions.size()},
      {"seconds", patch.seconds},
      {"spline", statistics_of(spline_errors(
                     frame, sites, removed,
                     is_triharmonic ? RbfKernel::kTriharmonic : RbfKernel::kBiharmonic))},
      {"patch_height", statistics_of(errors.heights)},
      {"beside_patch", errors.beside},
      {"patch_distance", statistics_of(errors.distances)},
  };
  std::puts(line.dump().c_str());
}

}  // namespace

void run_heights(const HeightWorkload& work) {
  const TriangleMesh mesh = read_mesh(work.mesh);
  const MeshIndex index(mesh);
  for (std::size_t i = 0; i + 2 < work.places.size(); i += 3) {
    const Vec3 place{work.places[i], work.places[i + 1], work.places[i + 2]};
    const std::optional<Disc> disc = clean_disc(index, nearest_vertex(mesh, place), work.radius);
    if (!disc) throw_usage("no clean disc at place " + std::to_string(i / 3 + 1));
    for (const double radius : work.neighborhood_radii) measure(index, *disc, radius, work);
  }
}

}  // namespace orbweave::bench
