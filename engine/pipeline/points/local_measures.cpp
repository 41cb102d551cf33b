#include "engine/pipeline/points/local_measures.h"

#include <algorithm>
#include <optional>

#include "engine/cleaning/points_near.h"

namespace orbweave {
namespace {

/// Side of the cubes that a cloud is cut into to find parts of it.
constexpr double kRunsPerHalo = 1.0;

/// Calls measure(part, level, chosen), which returns a value for each of the part's points asked
/// for, for every level with the part of the cloud that it needs; gives the chunk's own points
/// theirs.
template <class Value, class Measure>
std::vector<Value> by_level(const PassPoints& points, std::span<const std::uint8_t> levels,
                            std::span<const double> halos, const Measure& measure) {
  std::vector<Value> result(points.end - points.begin);
  std::optional<PointRuns> runs;
  for (std::size_t level = 0; level < halos.size(); ++level) {
    std::vector<std::uint8_t> wanted(points.positions.size(), 0);
    std::size_t count = 0;
    for (std::uint32_t i = points.begin; i < points.end; ++i) {
      wanted[i] = levels[i] == level ? 1 : 0;
      count += wanted[i];
    }
    if (count == 0) continue;
    if (count == result.size())
      return measure(std::span<const Vec3>(points.positions), points.begin, points.end, level,
                     std::span<const std::uint8_t>());
    if (2 * count > result.size()) {  // among all, without a copy of them
      const auto own = std::span<const std::uint8_t>(wanted).subspan(points.begin, result.size());
      const auto values =
          measure(std::span<const Vec3>(points.positions), points.begin, points.end, level, own);
      for (std::size_t i = 0; i < result.size(); ++i)
        if (own[i] != 0) result[i] = values[i];
      continue;
    }
    if (!runs) runs.emplace(points.positions, kRunsPerHalo * halos.front());
    const NearPart part =
        part_of(runs->near(wanted, halos[level]), points.positions, {}, points.begin, points.end);
    std::vector<std::uint8_t> chosen;
    for (std::uint32_t row = part.begin; row < part.end; ++row)
      chosen.push_back(wanted[part.points[row]]);
    const auto values = measure(std::span<const Vec3>(part.positions), part.begin, part.end, level,
                                std::span<const std::uint8_t>(chosen));
    for (std::uint32_t row = part.begin; row < part.end; ++row)
      if (wanted[part.points[row]] != 0)
        result[part.points[row] - points.begin] = values[row - part.begin];
  }
  return result;
}

}  // namespace

double local_normal_halo(std::span<const NormalEstimateOptions> of_level) {
  double halo = 0.0;
  for (const NormalEstimateOptions& options : of_level) halo = std::max(halo, normal_halo(options));
  return halo;
}

std::vector<Vec3> normals_locally(const PassPoints& points, std::span<const std::uint8_t> levels,
                                  std::span<const NormalEstimateOptions> of_level) {
  std::vector<double> halos;
  for (const NormalEstimateOptions& options : of_level) halos.push_back(normal_halo(options));
  return by_level<Vec3>(
      points, levels, halos,
      [&](std::span<const Vec3> positions, std::uint32_t begin, std::uint32_t end,
          std::size_t level, std::span<const std::uint8_t> chosen) {
        return estimate_normals(positions, begin, end, of_level[level], chosen).normals;
      });
}

std::vector<float> surfaceness_locally(const PassPoints& points,
                                       std::span<const std::uint8_t> levels,
                                       std::span<const SurfacenessOptions> of_level) {
  std::vector<double> halos;
  for (const SurfacenessOptions& options : of_level) halos.push_back(options.max_radius);
  return by_level<float>(points, levels, halos,
                         [&](std::span<const Vec3> positions, std::uint32_t begin,
                             std::uint32_t end, std::size_t level, std::span<const std::uint8_t>) {
                           return surfaceness_of(positions, begin, end, of_level[level]);
                         });
}

}  // namespace orbweave
