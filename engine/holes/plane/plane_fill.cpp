#include "engine/holes/plane/plane_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "engine/geometry/vertex_groups.h"
#include "engine/holes/loops/bridges.h"
#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/patch/patch_values.h"
#include "engine/holes/patch/rim.h"
#include "engine/holes/patch/smooth_disc.h"
#include "engine/holes/plane/hole_frame.h"
#include "engine/holes/plane/plane_grid.h"
#include "engine/holes/plane/plane_heights.h"
#include "engine/holes/plane/plane_outline.h"

namespace orbweave {
namespace {

HolePatch no_patch(std::string reason, OpenReason open = OpenReason::kOther) {
  HolePatch patch;
  patch.open = open;
  patch.reason = std::move(reason);
  return patch;
}

double largest_residual(const RbfInterpolant& heights, const std::vector<Vec3>& places) {
  double largest = 0.0;
  for (const Vec3 place : places) {
    largest = std::max(largest, std::abs(heights.evaluate(place) - place.z));
  }
  return largest;
}

// The triangulated disc over the plane: corners, then new points.
struct PlaneDisc {
  std::vector<GridPoint> points;  // of corners the place alone
  std::vector<CornerTriangle> triangles;
};

PlaneDisc triangulate(const HoleProblem& problem, const Rim& rim, std::vector<GridPoint> points) {
  const auto corners = static_cast<std::uint32_t>(rim.corners.size());
  const auto is_forbidden = [&](std::uint32_t a, std::uint32_t b) {
    const auto [low, high] = std::minmax(problem.loop[a], problem.loop[b]);
    return low == high ||
           std::binary_search(problem.forbidden.begin(), problem.forbidden.end(),
                              std::array<std::uint32_t, 2>{low, high}) ||
           share_a_group(problem.apart, low, high);
  };
  std::vector<Vec3> places;
  for (const GridPoint& point : points) places.push_back(point.place);
  PlaneDisc disc;
  disc.triangles = triangulate_polygon(snap_to_grid(places, rim.radius), corners, is_forbidden);
  // Points that fell on an edge or outside go.
  std::vector<std::uint32_t> number(points.size(), 0);
  for (const CornerTriangle& t : disc.triangles) {
    for (const std::uint32_t v : t) number[v] = 1;
  }
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    if (v >= corners && number[v] == 0) continue;
    number[v] = static_cast<std::uint32_t>(disc.points.size());
    disc.points.push_back(points[v]);
  }
  for (CornerTriangle& t : disc.triangles) {
    for (std::uint32_t& v : t) v = number[v];
  }
  return disc;
}

// A disc in space, on the interpolant.
class PatchSurface {
 public:
  PatchSurface(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
               const HoleHeights& heights)
      : problem_(problem), rim_(rim), frame_(frame), heights_(heights) {}

  HolePatch patch_of(const PlaneDisc& disc) const {
    PatchMesh mesh = flipped(disc);
    std::vector<Vec3> normals;
    for (std::size_t v = rim_.corners.size(); v < disc.points.size(); ++v) {
      normals.push_back(normal_of(disc.points[v].slope));
    }
    mesh.split_forbidden_chords();
    for (std::size_t v = disc.points.size(); v < mesh.size(); ++v) {
      Vec3 place = frame_.to_frame(mesh.positions()[v]);
      const auto [height, slope] = heights_.at(place);
      place.z = height;
      mesh.positions()[v] = frame_.to_space(place);
      normals.push_back(normal_of(slope));
    }
    HolePatch patch = patch_of_disc(problem_, rim_, mesh);
    // All points are in use, so that they come in their order.
    if (normals.size() == patch.normals.size()) patch.normals = std::move(normals);
    return patch;
  }

 private:
  PatchMesh lifted(const PlaneDisc& disc) const {
    std::vector<Vec3> positions = rim_.corners;
    for (std::size_t v = positions.size(); v < disc.points.size(); ++v) {
      positions.push_back(frame_.to_space(disc.points[v].place));
    }
    return PatchMesh(std::move(positions), problem_.loop, disc.triangles, problem_.forbidden,
                     problem_.apart);
  }

  // What is Delaunay in space may be folded over the plane: then as it is Delaunay there.
  PatchMesh flipped(const PlaneDisc& disc) const {
    PatchMesh mesh = lifted(disc);
    mesh.flip_to_delaunay();
    return is_height_field(mesh) ? mesh : lifted(disc);
  }

  bool is_height_field(const PatchMesh& mesh) const {
    const std::vector<CornerTriangle> triangles = mesh.triangles();
    const std::vector<Vec3>& x = mesh.positions();
    return std::all_of(triangles.begin(), triangles.end(), [&](const CornerTriangle& t) {
      return dot(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]), frame_.axis) > 0.0;
    });
  }

  Vec3 normal_of(Vec3 slope) const {
    return normalized(frame_.to_space({-slope.x, -slope.y, 1.0}));
  }

  const HoleProblem& problem_;
  const Rim& rim_;
  const HoleFrame& frame_;
  const HoleHeights& heights_;
};

// The rim with its corners relative to `origin`, as the frame and the heights are.
Rim rim_about(Rim rim, Vec3 origin) {
  const Vec3 shift = rim.center - origin;
  for (Vec3& corner : rim.corners) corner = corner + shift;
  rim.center = origin;
  return rim;
}

// The patch over the plane with these heights; none where the loop cannot be triangulated or takes
// too many points.
HolePatch patch_over_plane(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
                           const HoleHeights& heights, const PatchOptions& options) {
  std::vector<GridPoint> points;
  std::vector<Vec3> places;
  for (const Vec3 corner : rim.corners) {
    places.push_back(frame.to_frame(corner));
    points.push_back({places.back(), {}});
  }
  const PlaneOutline outline(std::move(places), grid_clearance(rim));
  const auto grid =
      plane_grid(rim, outline, heights, options.graded, options.max_new_points, options.stop);
  if (!grid) return no_patch(too_many_points(options), OpenReason::kTooManyPoints);
  points.insert(points.end(), grid->begin(), grid->end());
  const PlaneDisc disc = triangulate(problem, rim, std::move(points));
  HolePatch patch = PatchSurface(problem, rim, frame, heights).patch_of(disc);
  if (patch.triangles.empty()) return no_patch("the loop could not be triangulated in its plane");
  patch.method = FillMethod::kPlane;
  return patch;
}

// Bridges to islands are cut into edges as long as those of the rim, on the interpolant as well.
HolePatch patch_with_bridges(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
                             const HoleHeights& heights, const PatchOptions& options) {
  const auto on_patch = [&](std::uint32_t a, std::uint32_t b, double share) {
    const Vec3 from = frame.to_frame(problem.positions[a] - rim.center);
    Vec3 place = from + share * (frame.to_frame(problem.positions[b] - rim.center) - from);
    place.z = heights.at(place).value;
    return rim.center + frame.to_space(place);
  };
  const BridgedProblem bridged = cut_bridges(problem, rim.spacing, on_patch);
  HolePatch patch = patch_over_plane(
      bridged.problem, rim_about(find_rim(bridged.problem), rim.center), frame, heights, options);
  if (patch.method == FillMethod::kNone) return patch;
  give_bridge_points(bridged, patch);
  for (std::uint32_t v = 0; v < bridged.points; ++v) {
    const Vec3 place = frame.to_frame(patch.positions[v] - rim.center);
    const Vec3 slope = heights.at(place).gradient;
    patch.normals[v] = normalized(frame.to_space({-slope.x, -slope.y, 1.0}));
  }
  return patch;
}

}  // namespace

HolePatch plane_fill(const HoleProblem& problem, const PatchOptions& options) {
  if (problem.loop.size() < 3) return no_patch("the loop has no inside");
  return plane_fill(problem, find_rim(problem), options);
}

HolePatch plane_fill(const HoleProblem& problem, const Rim& rim, const PatchOptions& options) {
  if (!(rim.spacing > 0.0 && std::isfinite(rim.radius))) return no_patch("the loop has no extent");
  const FrameChoice choice = choose_frame(problem, rim);
  if (!choice.frame) return no_patch(choice.reason);
  const HoleFrame& frame = *choice.frame;

  std::vector<Vec3> places;
  for (const Vec3 corner : rim.corners) places.push_back(frame.to_frame(corner));
  const PlaneOutline outline(places, grid_clearance(rim));
  const HoleHeights heights(problem, rim, frame, outline, options);

  HolePatch patch = has_bridges(problem) ? patch_with_bridges(problem, rim, frame, heights, options)
                                         : patch_over_plane(problem, rim, frame, heights, options);
  const RbfInterpolant* const fit = heights.interpolant();
  if (fit != nullptr && !fit->valid()) {
    return no_patch("the points around it determine no interpolant");
  }
  if (patch.method == FillMethod::kNone || fit == nullptr) return patch;
  patch.values = values_from_sites(problem, heights.sites().vertices, patch.positions, options);
  patch.sites = fit->sites();
  patch.residual = largest_residual(*fit, heights.sites().places);
  patch.condition = fit->condition();
  return patch;
}

}  // namespace orbweave
