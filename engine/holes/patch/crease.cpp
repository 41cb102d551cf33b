#include "engine/holes/patch/crease.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "engine/holes/patch/rim.h"
#include "engine/holes/patch/rim_rings.h"

namespace orbweave {
namespace {

constexpr double kPi = std::numbers::pi;
/// Loops of fewer edges say too little of the surface around them.
constexpr std::size_t kLeastEdges = 20;

/// The rim as a plane has it.
struct FlatRim {
  Vec3 center;             ///< mean of the corners, world
  Vec3 axis;               ///< unit, as the normals of a patch; zero where there is no area
  double width = 0.0;      ///< of a circle the diameter
  double spacing = 0.0;    ///< mean length of the edges
  double off_plane = 0.0;  ///< root of the mean squared distance of the corners from the plane
};

FlatRim flat_rim(const HoleProblem& problem) {
  const std::size_t n = problem.loop.size();
  const Vec3 first = problem.positions[problem.loop[0]];
  std::vector<Vec3> corners;
  Vec3 sum, area;
  for (const std::uint32_t v : problem.loop) {
    corners.push_back(problem.positions[v] - first);
    sum = sum + corners.back();
  }
  const Vec3 center = sum / static_cast<double>(n);
  for (Vec3& corner : corners) corner = corner - center;
  for (std::size_t i = 0; i < n; ++i) area = area + 0.5 * cross(corners[i], corners[(i + 1) % n]);
  FlatRim rim;
  rim.center = first + center;
  rim.spacing = rim_spacing(problem);
  if (!(rim.spacing > 0.0)) return rim;
  rim.axis = normalized(area);
  rim.width = 4.0 * norm(area) / (rim.spacing * static_cast<double>(n));
  double squares = 0.0;
  for (const Vec3 corner : corners) squares += dot(corner, rim.axis) * dot(corner, rim.axis);
  rim.off_plane = std::sqrt(squares / static_cast<double>(n));
  return rim;
}

double angle_between(Vec3 unit, Vec3 axis) {
  return std::acos(std::clamp(dot(unit, axis), -1.0, 1.0));
}

/// A mean of angles.
struct MeanAngle {
  double sum = 0.0;
  std::size_t count = 0;
  void add(double angle) {
    sum += angle;
    ++count;
  }
  double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0.0; }
};

/// The angle of the faces behind the rim to the axis.
MeanAngle angle_at_rim(const Rim& rim, Vec3 axis) {
  MeanAngle angle;
  for (const Vec3 normal : rim.face_normals)
    if (squared_norm(normal) > 0.0) angle.add(angle_between(normal, axis));
  return angle;
}

/// How much of the faces' lean at the rim is towards the hole: the mean of its sine by the mean of
/// the sine's amount. 1: the surface turns away all along the rim, as at the edge of a reveal; -1:
/// it rises, as at the foot of something; near 0: noise.
double lean_into_hole(const Rim& rim, Vec3 axis) {
  const std::size_t n = rim.corners.size();
  double sum = 0.0, amounts = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 edge = rim.corners[(i + 1) % n] - rim.corners[i];
    const double lean = dot(rim.face_normals[i], normalized(cross(axis, edge)));
    sum += lean;
    amounts += std::abs(lean);
  }
  return amounts > 0.0 ? sum / amounts : 0.0;
}

/// The angles of the sheet to the axis at the vertices of one ring; empty where they are few.
std::vector<double> angles_of_ring(const HoleProblem& problem,
                                   const std::vector<std::uint32_t>& ring, std::uint32_t which,
                                   Vec3 axis) {
  std::vector<double> angles;
  for (std::size_t v = 0; v < ring.size(); ++v)
    if (ring[v] == which && squared_norm(problem.normals[v]) > 0.0)
      angles.push_back(angle_between(problem.normals[v], axis));
  constexpr std::size_t kLeast = 8;
  if (angles.size() < kLeast) angles.clear();
  return angles;
}

/// The angle of the sheet to the axis some rings behind the rim; empty where it does not go so far.
std::optional<double> angle_behind(const HoleProblem& problem, Vec3 axis, std::uint32_t rings) {
  MeanAngle angle;
  for (const double each : angles_of_ring(problem, rings_about(problem, rings), rings, axis))
    angle.add(each);
  if (angle.count == 0) return std::nullopt;
  return angle.mean();
}

/// Between a sheet and a plane that count as parallel.
constexpr double kParallel = kPi / 6.0;

/// Half a width behind the rim.
std::uint32_t rings_behind(const FlatRim& rim) {
  constexpr double kFewestRings = 6.0, kMostRings = 48.0;
  return static_cast<std::uint32_t>(
      std::clamp(0.5 * rim.width / rim.spacing, kFewestRings, kMostRings));
}

/// The angle between the rim's plane and the sheet half a width behind the rim, the median over the
/// places there; half a turn where the sheet does not go so far.
double angle_of_wall(const HoleProblem& problem, const FlatRim& rim) {
  const std::uint32_t rings = rings_behind(rim);
  std::vector<double> angles =
      angles_of_ring(problem, rings_about(problem, rings), rings, rim.axis);
  if (angles.empty()) return kPi;
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::ranges::nth_element(angles, middle);
  return *middle;
}

/// Whether the sheet half a width behind the rim is parallel to the rim's plane, at most places:
/// what is steep at the rim is a lip, such as the reveal of a window in a wall.
bool is_lip(const HoleProblem& problem, const FlatRim& rim) {
  return angle_of_wall(problem, rim) < kParallel;
}

/// The vertices half a width behind the rim where the sheet is parallel to the rim's plane.
std::vector<std::uint32_t> parallel_vertices(const HoleProblem& problem, const FlatRim& rim) {
  const std::uint32_t rings = rings_behind(rim);
  const std::vector<std::uint32_t> ring = rings_about(problem, rings);
  std::vector<std::uint32_t> found;
  for (std::uint32_t v = 0; v < ring.size(); ++v)
    if (ring[v] == rings && squared_norm(problem.normals[v]) > 0.0 &&
        angle_between(problem.normals[v], rim.axis) < kParallel)
      found.push_back(v);
  return found;
}

/// The value below which this share of them lies.
double quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

/// True where the rim lies in a plane, the sheet meets that plane steeply all along it, and the
/// sheet does not bend towards the hole as it comes near. False for the cap of a sphere, which
/// bends, and for loops of a few edges. `rim_of_hole`: of the problem.
bool ends_in_crease(const HoleProblem& problem, const Rim& rim_of_hole) {
  constexpr double kFlat = 0.05;  // distance from the plane by the width of the hole
  constexpr double kRough = 1.0;  // and by the spacing, where that is more
  // Between the sheet behind the rim and the plane, 75 degrees; 40 of a lip, which scans round off
  // and see in part, so that its rim lies less in a plane, too; 22.5 of a lip in a flat wall.
  constexpr double kSteep = kPi / 2.4, kSteepLip = kPi / 4.5, kSteepInWall = kPi / 8.0;
  constexpr double kFlatWall = kPi / 15.0;  // between the wall and the plane
  constexpr double kEvenRim = 0.5;          // the roughness of a rim in such a wall, at most
  // Of the lean of the faces behind it. Windows of simulated rooms have 0.74 and more, holes in
  // noisy ground up to 0.65.
  constexpr double kLeansIn = 0.7;
  constexpr double kLipRoughness = 2.0;
  constexpr double kBends = 0.5;            // share of the bend that would close the hole smoothly
  constexpr std::uint32_t kMostRings = 12;  // behind the rim
  if (problem.loop.size() < kLeastEdges || problem.normals.size() != problem.positions.size())
    return false;
  const FlatRim rim = flat_rim(problem);
  if (!(rim.width > 0.0)) return false;
  const double roughness = rim.off_plane / std::max(kFlat * rim.width, kRough * rim.spacing);
  if (roughness > kLipRoughness) return false;
  const MeanAngle at_rim = angle_at_rim(rim_of_hole, rim.axis);
  if (2 * at_rim.count < problem.loop.size() || at_rim.mean() < kSteepInWall) return false;
  const bool is_shallow = at_rim.mean() < kSteepLip;
  if (is_shallow && (roughness > kEvenRim || lean_into_hole(rim_of_hole, rim.axis) < kLeansIn))
    return false;
  const bool needs_wall = roughness > 1.0 || at_rim.mean() < kSteep;
  if (needs_wall && angle_of_wall(problem, rim) >= (is_shallow ? kFlatWall : kParallel))
    return false;
  const double quarter = 0.25 * rim.width / rim.spacing;
  const auto rings =
      static_cast<std::uint32_t>(std::clamp(quarter, 2.0, static_cast<double>(kMostRings)));
  const std::optional<double> behind = angle_behind(problem, rim.axis, rings);
  if (!behind) return false;
  // A circle that leaves the plane at an angle and spans the hole bends by its sine over half the
  // width.
  const double closing = std::sin(std::min(at_rim.mean(), kPi / 2.0)) / (0.5 * rim.width);
  const double bend = (*behind - at_rim.mean()) / (static_cast<double>(rings) * rim.spacing);
  return bend < kBends * closing;
}

/// True where the corners of the rim lie on two levels, the sheet and the ground, with hardly any
/// between, and the ground is shallow for the width of the hole. The scanner saw parts of a
/// recess's ground and none of the sides there: the sheet need not be steep along such a rim.
bool is_stepped(const HoleProblem& problem, const RecessedPlane& plane) {
  constexpr double kLeastStep = 1.5;  // edge lengths
  // Corners spread evenly from one level to the other have 0.29.
  constexpr double kMostBetween = 0.15;  // of the step
  constexpr double kDeepest = 0.25;      // of the width
  const FlatRim rim = flat_rim(problem);
  const double step = (plane.wall - plane.depth) / rim.spacing;
  return step >= kLeastStep && step * rim.spacing <= kDeepest * rim.width &&
         roughness_of_recess(problem, plane) <= kMostBetween * step;
}

}  // namespace

RimShape rim_shape(const HoleProblem& problem) {
  const FlatRim rim = flat_rim(problem);
  if (!(rim.width > 0.0)) return {};
  return {rim.off_plane / rim.spacing,
          problem.normals.size() == problem.positions.size() && is_lip(problem, rim)};
}

std::optional<RecessedPlane> recessed_plane(const HoleProblem& problem) {
  constexpr double kDeepest = 0.10;  // share of the corners: outliers lie deeper
  constexpr double kFront = 0.85;
  constexpr double kLeastDepth = 1.0, kLeastStep = 0.5;  // edge lengths
  if (problem.loop.size() < kLeastEdges || problem.normals.size() != problem.positions.size())
    return std::nullopt;
  const FlatRim rim = flat_rim(problem);
  if (!(rim.width > 0.0) || !is_lip(problem, rim)) return std::nullopt;
  const std::vector<std::uint32_t> sheet = parallel_vertices(problem, rim);
  RecessedPlane plane;
  for (const std::uint32_t v : sheet) plane.axis = plane.axis + problem.normals[v];
  plane.axis = normalized(plane.axis);
  std::vector<double> of_sheet, of_rim;
  for (const std::uint32_t v : sheet)
    of_sheet.push_back(dot(problem.positions[v] - rim.center, plane.axis));
  for (const std::uint32_t v : problem.loop)
    of_rim.push_back(dot(problem.positions[v] - rim.center, plane.axis));
  plane.depth = quantile(of_rim, kDeepest);
  plane.wall = quantile(of_sheet, 0.5);
  if (plane.wall - plane.depth < kLeastDepth * rim.spacing) return std::nullopt;
  if (quantile(of_rim, kFront) - plane.depth < kLeastStep * rim.spacing) return std::nullopt;
  return plane;
}

FlatCall call_for_flat_patch(const HoleProblem& problem, const Rim& rim) {
  FlatCall call{ends_in_crease(problem, rim), recessed_plane(problem)};
  if (call.recess && !call.is_crease && !is_stepped(problem, *call.recess)) call.recess.reset();
  return call;
}

double roughness_of_recess(const HoleProblem& problem, const RecessedPlane& plane) {
  const FlatRim rim = flat_rim(problem);
  double squares = 0.0;
  for (const std::uint32_t v : problem.loop) {
    const double at = dot(problem.positions[v] - rim.center, plane.axis);
    const double off = std::min(std::abs(at - plane.depth), std::abs(at - plane.wall));
    squares += off * off;
  }
  return std::sqrt(squares / static_cast<double>(problem.loop.size())) / rim.spacing;
}

}  // namespace orbweave
