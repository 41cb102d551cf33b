#include "engine/holes/patch/creased_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/holes/patch/direct_fill.h"
#include "engine/holes/patch/patch_values.h"
#include "engine/holes/patch/planes_at_rim.h"
#include "engine/holes/patch/smooth_disc.h"

namespace orbweave {
namespace {

/// The point that three planes share. Precondition: their normals span space.
Vec3 common_point(const std::vector<FittedPlane>& planes) {
  const FittedPlane &a = planes[0], &b = planes[1], &c = planes[2];
  const Vec3 bc = cross(b.normal, c.normal), ca = cross(c.normal, a.normal),
             ab = cross(a.normal, b.normal);
  return (a.offset * bc + b.offset * ca + c.offset * ab) / dot(a.normal, bc);
}

/// The edges inside the hole: from each anchor to the other one, or to the corner that all share.
struct InnerEdges {
  std::vector<Vec3> points;                          ///< new vertices, relative to the rim's centre
  std::vector<std::vector<std::uint32_t>> of_plane;  ///< per plane: points between the anchor at
                                                     ///< the end of its part of the rim and that at
                                                     ///< its beginning
};

/// Points on a line between two places on it, at about the spacing; both ends left out.
std::vector<Vec3> points_between(const CommonLine& line, double from, double to, double spacing) {
  const auto steps =
      static_cast<std::size_t>(std::max(1.0, std::round(std::abs(to - from) / spacing)));
  std::vector<Vec3> points;
  for (std::size_t i = 1; i < steps; ++i)
    points.push_back(
        line.at(from + (to - from) * static_cast<double>(i) / static_cast<double>(steps)));
  return points;
}

std::vector<std::uint32_t> numbers_from(std::size_t first, std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<std::uint32_t>(first + i);
  return numbers;
}

InnerEdges edge_of_two(const PlanesAtRim& crease, const Rim& rim) {
  const CommonLine line = common_line(crease.planes[0], crease.planes[1]);
  const double begin = line.place_of(rim.corners[crease.anchors[0]]);
  const double end = line.place_of(rim.corners[crease.anchors[1]]);
  InnerEdges edges;
  edges.points = points_between(line, begin, end, rim.spacing);
  const std::vector<std::uint32_t> forwards = numbers_from(0, edges.points.size());
  // The first plane's part of the rim ends at the second anchor.
  edges.of_plane = {{forwards.rbegin(), forwards.rend()}, forwards};
  return edges;
}

/// Empty where the corner lies outside the hole.
std::optional<InnerEdges> edges_of_three(const PlanesAtRim& crease, const Rim& rim) {
  constexpr double kFar = 1.5;  // radii
  const Vec3 corner = common_point(crease.planes);
  if (!(norm(corner) < kFar * rim.radius)) return std::nullopt;
  InnerEdges edges;
  edges.points.push_back(corner);
  std::vector<std::vector<std::uint32_t>> from_anchor;  // to the corner, without it
  for (std::size_t i = 0; i < crease.planes.size(); ++i) {
    const CommonLine line = common_line(crease.planes[crease.before(i)], crease.planes[i]);
    const double begin = line.place_of(rim.corners[crease.anchors[i]]);
    const std::vector<Vec3> points =
        points_between(line, begin, line.place_of(corner), rim.spacing);
    from_anchor.push_back(numbers_from(edges.points.size(), points.size()));
    edges.points.insert(edges.points.end(), points.begin(), points.end());
  }
  for (std::size_t i = 0; i < crease.planes.size(); ++i) {
    std::vector<std::uint32_t> inner = from_anchor[(i + 1) % crease.planes.size()];
    inner.push_back(0);
    inner.insert(inner.end(), from_anchor[i].rbegin(), from_anchor[i].rend());
    edges.of_plane.push_back(std::move(inner));
  }
  return edges;
}

/// The values of a problem's vertices and of points behind these.
struct WidenedValues {
  const HoleProblem& problem;
  std::vector<double> of_points;  ///< rows

  std::vector<double> operator()(std::span<const std::uint32_t> wanted) const {
    const auto given = static_cast<std::uint32_t>(problem.positions.size());
    std::vector<std::uint32_t> of_problem;
    std::copy_if(wanted.begin(), wanted.end(), std::back_inserter(of_problem),
                 [&](std::uint32_t v) { return v < given; });
    const std::vector<double> known = problem.values_of(of_problem);
    const auto channels = static_cast<std::ptrdiff_t>(problem.channels);
    auto next = known.begin();
    std::vector<double> values;
    for (const std::uint32_t v : wanted) {
      const auto row = v < given ? next : of_points.begin() + (v - given) * channels;
      values.insert(values.end(), row, row + channels);
      next += v < given ? channels : 0;
    }
    return values;
  }
};

/// The hole with the points of its inner edges among the given vertices. The problem must
/// outlive it.
HoleProblem with_points(const HoleProblem& problem, const Rim& rim, const InnerEdges& edges) {
  HoleProblem widened = problem;
  std::vector<Vec3> points;
  for (const Vec3 p : edges.points) points.push_back(rim.center + p);
  if (problem.channels > 0)
    widened.values_of = WidenedValues{problem, values_from_corners(problem, points)};
  widened.positions.insert(widened.positions.end(), points.begin(), points.end());
  widened.normals.resize(widened.positions.size());
  return widened;
}

/// The loop of one plane's part of the hole: its part of the rim, then back along the edges.
std::vector<std::uint32_t> loop_of(const HoleProblem& problem, const PlanesAtRim& crease,
                                   const InnerEdges& edges, std::size_t plane) {
  const auto n = static_cast<std::uint32_t>(problem.loop.size());
  const auto given = static_cast<std::uint32_t>(problem.positions.size());
  const std::uint32_t end = crease.anchors[(plane + 1) % crease.planes.size()];
  std::vector<std::uint32_t> loop;
  for (std::uint32_t i = crease.anchors[plane]; i != end; i = (i + 1) % n)
    loop.push_back(problem.loop[i]);
  loop.push_back(problem.loop[end]);
  for (const std::uint32_t point : edges.of_plane[plane]) loop.push_back(given + point);
  return loop;
}

/// The vertices that parts share may be joined by the edges themselves alone: a chord of one part
/// could be one of another.
void forbid_shared_chords(const HoleProblem& problem, const PlanesAtRim& crease,
                          const InnerEdges& edges, HoleProblem& widened) {
  const auto given = static_cast<std::uint32_t>(problem.positions.size());
  std::vector<std::uint32_t> shared;
  for (const std::uint32_t anchor : crease.anchors) shared.push_back(problem.loop[anchor]);
  for (std::uint32_t i = 0; i < edges.points.size(); ++i) shared.push_back(given + i);
  std::sort(shared.begin(), shared.end());
  for (std::size_t a = 0; a < shared.size(); ++a)
    for (std::size_t b = a + 1; b < shared.size(); ++b)
      widened.forbidden.push_back({shared[a], shared[b]});
  std::sort(widened.forbidden.begin(), widened.forbidden.end());
  widened.forbidden.erase(std::unique(widened.forbidden.begin(), widened.forbidden.end()),
                          widened.forbidden.end());
}

/// Adds the membrane over a loop to the patch, whose first new vertices are the points of the
/// edges; false where it would need too many points.
bool add_membrane(const HoleProblem& part, std::uint32_t given, const PatchOptions& options,
                  HolePatch& patch) {
  const LoopTriangles triangles = triangles_of_loop(part);
  const std::optional<PatchMesh> disc = smooth_disc(part, triangles, 1, options);
  if (!disc) return false;
  const HolePatch membrane = patch_of_disc(part, triangles.rim, *disc);
  const auto known = static_cast<std::uint32_t>(part.positions.size());
  const auto moved_to = given + static_cast<std::uint32_t>(patch.positions.size());
  for (Triangle t : membrane.triangles) {
    for (std::uint32_t& v : t)
      if (v >= known) v = v - known + moved_to;
    patch.triangles.push_back(t);
  }
  patch.positions.insert(patch.positions.end(), membrane.positions.begin(),
                         membrane.positions.end());
  return true;
}

std::string reason_of(const PlanesAtRim& crease) {
  if (crease.planes.size() > 2)
    return "creased, because the surroundings are three planes that meet in a corner";
  const double angle = std::atan2(norm(cross(crease.planes[0].normal, crease.planes[1].normal)),
                                  dot(crease.planes[0].normal, crease.planes[1].normal));
  return "creased, because the surroundings are two planes, " +
         std::to_string(std::lround(angle * 180.0 / std::numbers::pi)) + " degrees apart";
}

HolePatch none_because(std::string reason, OpenReason open = OpenReason::kOther) {
  HolePatch patch;
  patch.open = open;
  patch.reason = std::move(reason);
  return patch;
}

}  // namespace

HolePatch creased_fill(const HoleProblem& problem, const PatchOptions& options) {
  if (problem.loop.empty()) return {};
  return creased_fill(problem, find_rim(problem), options);
}

HolePatch creased_fill(const HoleProblem& problem, const Rim& rim, const PatchOptions& options) {
  constexpr std::size_t kLeastEdges = 12;
  constexpr std::size_t kMostPoints = 500;  // on edges: the pairs of them are listed
  if (problem.loop.size() < kLeastEdges) return {};
  const std::optional<PlanesAtRim> crease = find_planes_at_rim(problem, rim);
  if (!crease) return {};
  const std::optional<InnerEdges> edges =
      crease->planes.size() == 2 ? edge_of_two(*crease, rim) : edges_of_three(*crease, rim);
  if (!edges) return none_because("the planes around the hole meet outside of it");
  if (edges->points.empty() || edges->points.size() > kMostPoints) return {};
  HoleProblem widened = with_points(problem, rim, *edges);
  forbid_shared_chords(problem, *crease, *edges, widened);
  const auto given = static_cast<std::uint32_t>(problem.positions.size());
  HolePatch patch;
  patch.positions.assign(widened.positions.begin() + given, widened.positions.end());
  for (std::size_t plane = 0; plane < crease->planes.size(); ++plane) {
    widened.loop = loop_of(problem, *crease, *edges, plane);
    if (!add_membrane(widened, given, options, patch))
      return none_because(too_many_points(options), OpenReason::kTooManyPoints);
  }
  patch.method = FillMethod::kCreased;
  patch.reason = reason_of(*crease);
  patch.normals = normals_of_patch(problem, patch);
  patch.values = values_from_corners(problem, patch.positions);
  return patch;
}

}  // namespace orbweave
