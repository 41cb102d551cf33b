#include "engine/cleaning/local_cleaning.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/cleaning/points_near.h"

namespace orbweave {
namespace {

/// Side of the cubes that a cloud is cut into to find parts of it, in radii or spacings of the
/// finest level.
constexpr double kRadiiPerRun = 3.0;
constexpr double kSpacingsPerRun = 12.0;

/// The points asked for that are at a level and chosen; 1 for each of them among all points.
std::vector<std::uint8_t> asked_at(const LeveledPoints& points, std::size_t level,
                                   std::span<const std::uint8_t> chosen) {
  std::vector<std::uint8_t> asked(points.positions.size(), 0);
  for (std::uint32_t i = points.begin; i < points.end; ++i)
    if (points.levels[i] == level && (chosen.empty() || chosen[i - points.begin] != 0))
      asked[i] = 1;
  return asked;
}

bool are_all_at(const LeveledPoints& points, std::size_t level) {
  const auto first = points.levels.begin();
  return std::all_of(first + points.begin, first + points.end,
                     [&](std::uint8_t other) { return other == level; });
}

/// Takes over what was projected of the points that were asked for, row by row.
void take_over(const LeveledPoints& points, const ProjectedPoints& projected,
               std::span<const std::uint8_t> chosen, std::span<const std::uint32_t> point_of_row,
               ProjectedPoints& result) {
  for (std::uint32_t row = 0; row < chosen.size(); ++row) {
    if (chosen[row] == 0) continue;
    const std::uint32_t to = point_of_row[row] - points.begin;
    result.positions[to] = projected.positions[row];
    result.normals[to] = projected.normals[row];
    result.moved[to] = projected.moved[row];
  }
}

/// Projects the points of one level among those around them; of most points, among all.
void project_level(const LeveledPoints& points, const PointRuns& runs,
                   const ProjectionOptions& options, const std::vector<std::uint8_t>& asked,
                   ProjectedPoints& result) {
  const auto own = std::span(asked).subspan(points.begin, points.end - points.begin);
  if (2 * static_cast<std::size_t>(std::count(own.begin(), own.end(), 1)) > own.size())
    return project_chosen(points.positions, points.normals, points.begin, points.end, options, own,
                          result);
  const NearPart part = part_of(runs.near(asked, projection_halo(options)), points.positions,
                                points.normals, points.begin, points.end);
  std::vector<std::uint8_t> chosen;
  for (std::uint32_t row = part.begin; row < part.end; ++row)
    chosen.push_back(asked[part.points[row]]);
  take_over(points,
            project_points(part.positions, part.normals, part.begin, part.end, options, chosen),
            chosen, std::span(part.points).subspan(part.begin), result);
}

/// What thin_points() is told of each point: those of the level are undecided.
std::vector<std::uint8_t> states_at(const LeveledPoints& points, std::size_t level,
                                    const std::vector<std::uint8_t>& kept) {
  constexpr std::uint8_t kUndecided = 0, kKept = 1, kLeftOut = 2;
  std::vector<std::uint8_t> states(points.positions.size());
  for (std::size_t i = 0; i < states.size(); ++i)
    states[i] = points.levels[i] == level ? kUndecided : kept[i] != 0 ? kKept : kLeftOut;
  return states;
}

/// Decides the points of one level; `kept` has those of the levels below.
void thin_level(const LeveledPoints& points, const PointRuns& runs, std::size_t level,
                const ThinningOptions& options, std::vector<std::uint8_t>& kept) {
  const std::vector<std::uint8_t> states = states_at(points, level, kept);
  const auto size = static_cast<std::uint32_t>(states.size());
  std::vector<std::uint8_t> undecided(size);
  std::transform(states.begin(), states.end(), undecided.begin(),
                 [](std::uint8_t state) { return static_cast<std::uint8_t>(state == 0 ? 1 : 0); });
  if (2 * std::count(undecided.begin(), undecided.end(), 1) > static_cast<std::ptrdiff_t>(size)) {
    kept = thin_points(points.positions, points.normals, 0, size, options, states);
    return;
  }
  const NearPart part =
      part_of(runs.near(undecided, options.spacing), points.positions, points.normals, 0, size);
  std::vector<std::uint8_t> of_part;
  of_part.reserve(part.points.size());
  for (const std::uint32_t i : part.points) of_part.push_back(states[i]);
  const std::vector<std::uint8_t> chosen =
      thin_points(part.positions, part.normals, 0,
                  static_cast<std::uint32_t>(part.positions.size()), options, of_part);
  for (std::size_t row = 0; row < chosen.size(); ++row) kept[part.points[row]] = chosen[row];
}

}  // namespace

double local_projection_halo(std::span<const double> radii, const ProjectionOptions& options) {
  ProjectionOptions largest = options;
  largest.radius = radii.back();
  return projection_halo(largest);
}

ProjectedPoints project_locally(const LeveledPoints& points, std::span<const double> radii,
                                const ProjectionOptions& options,
                                std::span<const std::uint8_t> chosen) {
  ProjectionOptions of_level = options;
  for (std::size_t level = 1; level < radii.size(); ++level) {
    if (!are_all_at(points, level)) continue;
    of_level.radius = radii[level];
    return project_points(points.positions, points.normals, points.begin, points.end, of_level,
                          chosen);
  }
  ProjectedPoints result = as_given(points.positions, points.normals, points.begin, points.end);
  if (radii.size() < 2) return result;
  const PointRuns runs(points.positions, kRadiiPerRun * radii[1]);
  for (std::size_t level = 1; level < radii.size(); ++level) {
    const std::vector<std::uint8_t> asked = asked_at(points, level, chosen);
    if (std::find(asked.begin(), asked.end(), 1) == asked.end()) continue;
    of_level.radius = radii[level];
    project_level(points, runs, of_level, asked, result);
  }
  return result;
}

double local_thinning_halo(std::span<const double> spacings) {
  double halo = 0.0;
  for (const double spacing : spacings)
    if (spacing > 0.0) halo += thinning_halo({.spacing = spacing});
  return halo;
}

std::vector<std::uint8_t> thin_locally(const LeveledPoints& points,
                                       std::span<const double> spacings,
                                       const ThinningOptions& options) {
  ThinningOptions of_level = options;
  const auto is_at = [&](std::size_t level) {
    return [level](std::uint8_t other) { return other == level; };
  };
  std::optional<PointRuns> runs;
  std::vector<std::uint8_t> kept(points.positions.size());
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = points.levels[i] == 0 ? 1 : 0;
  for (std::size_t level = 1; level < spacings.size(); ++level) {
    of_level.spacing = spacings[level];
    if (std::all_of(points.levels.begin(), points.levels.end(), is_at(level)))
      return thin_points(points.positions, points.normals, points.begin, points.end, of_level);
    if (std::none_of(points.levels.begin(), points.levels.end(), is_at(level))) continue;
    if (!runs) runs.emplace(points.positions, kSpacingsPerRun * spacings[1]);
    thin_level(points, *runs, level, of_level, kept);
  }
  return {kept.begin() + points.begin, kept.begin() + points.end};
}

}  // namespace orbweave
