#include "engine/holes/patch/planes_at_rim.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "engine/holes/patch/rim_rings.h"

namespace orbweave {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Whether the faces at the rim point in directions that a flat sheet would not have: most holes
/// are told apart by that alone.
bool may_cross_edge(const Rim& rim) {
  constexpr double kLeastTurn = 8.0 * kDegree;  // of the faces from their mean
  Vec3 sum;
  std::size_t count = 0;
  for (const Vec3 normal : rim.face_normals) {
    sum = sum + normal;
    count += squared_norm(normal) > 0.0 ? 1 : 0;
  }
  // The mean of unit vectors that turn by an angle from it is as long as the angle's cosine.
  return count > 0 && norm(sum) < std::cos(kLeastTurn) * static_cast<double>(count);
}

/// The sheet's faces within some rings of the rim, relative to its centre.
std::vector<PlacedFace> faces_behind(const HoleProblem& problem, const Rim& rim) {
  constexpr double kFewestRings = 3.0, kMostRings = 12.0;
  constexpr double kDepth = 0.5;  // of the hole's radius
  const auto rings = static_cast<std::uint32_t>(
      std::clamp(kDepth * rim.radius / rim.spacing, kFewestRings, kMostRings));
  const std::vector<std::uint32_t> ring = rings_about(problem, rings);
  std::vector<PlacedFace> faces;
  for (const Triangle& t : problem.sheet) {
    if (std::max({ring[t[0]], ring[t[1]], ring[t[2]]}) > rings) continue;
    const Vec3 a = problem.positions[t[0]] - rim.center, b = problem.positions[t[1]] - rim.center,
               c = problem.positions[t[2]] - rim.center;
    const Vec3 normal = normalized(cross(b - a, c - a));
    if (squared_norm(normal) > 0.0) faces.push_back({(a + b + c) / 3.0, normal});
  }
  return faces;
}

double sine_between(const FittedPlane& a, const FittedPlane& b) {
  return norm(cross(a.normal, b.normal));
}

double angle_between(const FittedPlane& a, const FittedPlane& b) {
  return std::atan2(sine_between(a, b), dot(a.normal, b.normal));
}

/// The least angle between two of the planes.
double least_angle(std::span<const FittedPlane> planes) {
  double least = std::numbers::pi;
  for (std::size_t a = 0; a < planes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      least = std::min(least, angle_between(planes[a], planes[b]));
  return least;
}

bool meet_at_edges(std::span<const FittedPlane> planes) {
  constexpr double kLeast = 20.0 * kDegree, kMost = 150.0 * kDegree;
  for (std::size_t a = 0; a < planes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const double angle = angle_between(planes[a], planes[b]);
      if (angle < kLeast || angle > kMost) return false;
    }
  constexpr double kLeastVolume =
      0.1;  // three planes that meet in a point, and not almost in a line
  return planes.size() < 3 ||
         std::abs(dot(planes[0].normal, cross(planes[1].normal, planes[2].normal))) > kLeastVolume;
}

/// Whether the faces lie in the planes as noise would have it, and not on a smooth surface.
bool lie_in_planes(std::span<const FittedPlane> planes, std::span<const PlacedFace> faces,
                   const Rim& rim) {
  constexpr double kClose = 0.15;          // of the spacing
  constexpr double kCloseOfRelief = 0.06;  // of what a chord over the edge would leave out
  constexpr double kBetter = 0.35;         // than a smooth surface
  constexpr double kAtEdge = 1.5;          // spacings
  const std::vector<PlacedFace> inside = faces_off_edges(planes, faces, kAtEdge * rim.spacing);
  if (2 * inside.size() < faces.size()) return false;
  const double off = distance_from_planes(planes, inside);
  const double relief = rim.radius * std::sin(0.5 * least_angle(planes));
  if (!(off <= std::max(kClose * rim.spacing, kCloseOfRelief * relief))) return false;
  return off <= kBetter * distance_from_quadric(inside);
}

/// Edges of the rim in one plane, one after the other.
struct RimRun {
  std::size_t plane = 0;
  std::uint32_t first = 0;  ///< the corner at which it begins
  std::uint32_t edges = 0;
};

std::vector<RimRun> runs_of_rim(std::span<const FittedPlane> planes, const Rim& rim) {
  const auto n = static_cast<std::uint32_t>(rim.corners.size());
  std::vector<RimRun> runs;
  for (std::uint32_t i = 0; i < n; ++i) {
    const PlacedFace edge{0.5 * (rim.corners[i] + rim.corners[(i + 1) % n]), rim.face_normals[i]};
    const std::size_t plane = nearest_plane(planes, edge, rim.spacing);
    if (runs.empty() || runs.back().plane != plane) runs.push_back({plane, i, 0});
    ++runs.back().edges;
  }
  if (runs.size() > 1 && runs.front().plane == runs.back().plane) {
    runs.front().first = runs.back().first;
    runs.front().edges += runs.back().edges;
    runs.pop_back();
  }
  return runs;
}

/// Takes the shortest run from a closed sequence; those around it become one where they are of one
/// plane, else it goes to the one before.
void drop_shortest(std::vector<RimRun>& runs) {
  const auto shortest = std::ranges::min_element(runs, {}, &RimRun::edges);
  std::rotate(runs.begin(), shortest, runs.end());
  RimRun& last = runs.back();
  last.edges += runs.front().edges;
  runs.erase(runs.begin());
  if (runs.size() < 2 || runs.front().plane != runs.back().plane) return;
  runs.back().edges += runs.front().edges;
  runs.erase(runs.begin());
}

/// Edges of the rim in one plane: more than its anchors may be moved together.
constexpr std::uint32_t kLeastRun = 6;

/// Empty where the rim does not run through each plane once.
std::vector<RimRun> one_run_per_plane(std::span<const FittedPlane> planes, const Rim& rim) {
  std::vector<RimRun> runs = runs_of_rim(planes, rim);
  const std::size_t most_dropped = std::max<std::size_t>(2, rim.corners.size() / 12);
  while (runs.size() > planes.size()) {
    if (std::ranges::min_element(runs, {}, &RimRun::edges)->edges > most_dropped) return {};
    drop_shortest(runs);
  }
  if (runs.size() != planes.size()) return {};
  std::vector<std::uint8_t> seen(planes.size(), 0);
  for (const RimRun& run : runs)
    if (seen[run.plane]++ != 0 || run.edges < kLeastRun) return {};
  return runs;
}

/// The corner at which the rim passes from one plane to the other: near their line, and of such
/// corners one that reaches far into the hole, since the edge starts there and the teeth of the rim
/// beside it must not reach over it. Empty where all are far from the line.
std::optional<std::uint32_t> anchor_near(std::uint32_t corner, const CommonLine& line,
                                         const Rim& rim) {
  constexpr double kFar = 1.5;    // spacings
  constexpr double kAside = 2.0;  // what a distance from the line counts by one along it
  constexpr std::uint32_t kReach = 2;
  const auto n = static_cast<std::uint32_t>(rim.corners.size());
  const double middle = line.place_of({});  // the rim's centre
  std::optional<std::uint32_t> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t step = 0; step <= 2 * kReach; ++step) {
    const std::uint32_t candidate = (corner + n + step - kReach) % n;
    const Vec3 p = rim.corners[candidate];
    const double aside = line.distance(p);
    const double cost = std::abs(line.place_of(p) - middle) + kAside * aside;
    if (aside > kFar * rim.spacing || cost >= least) continue;
    least = cost;
    best = candidate;
  }
  return best;
}

std::optional<PlanesAtRim> planes_along(std::span<const FittedPlane> planes, const Rim& rim) {
  const std::vector<RimRun> runs = one_run_per_plane(planes, rim);
  if (runs.empty()) return std::nullopt;
  PlanesAtRim found;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RimRun& last = runs[(i + runs.size() - 1) % runs.size()];
    const std::optional<std::uint32_t> anchor =
        anchor_near(runs[i].first, common_line(planes[last.plane], planes[runs[i].plane]), rim);
    if (!anchor) return std::nullopt;
    found.planes.push_back(planes[runs[i].plane]);
    found.anchors.push_back(*anchor);
  }
  return found;
}

}  // namespace

std::optional<PlanesAtRim> find_planes_at_rim(const HoleProblem& problem, const Rim& rim) {
  constexpr std::size_t kLeastFaces = 30;
  if (!(rim.spacing > 0.0) || !may_cross_edge(rim)) return std::nullopt;
  const std::vector<PlacedFace> faces = faces_behind(problem, rim);
  if (faces.size() < kLeastFaces) return std::nullopt;
  for (const std::size_t count : {std::size_t{2}, std::size_t{3}}) {
    if (rim.corners.size() < count * kLeastRun) break;
    const std::vector<FittedPlane> planes = fit_planes(faces, count, rim.spacing);
    if (planes.empty() || !meet_at_edges(planes)) continue;
    // What takes longest comes last.
    std::optional<PlanesAtRim> found = planes_along(planes, rim);
    if (found && lie_in_planes(planes, faces, rim)) return found;
  }
  return std::nullopt;
}

}  // namespace orbweave
