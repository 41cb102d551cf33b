#include "engine/spacing/noise_places.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <tuple>

#include "engine/geometry/lattice_cube.h"
#include "engine/geometry/neighbor_search.h"
#include "engine/spacing/place_noise.h"
#include "engine/spacing/site_points.h"

namespace orbweave {
namespace {

/// Places that one thread takes at once, between two looks at the request to stop.
constexpr std::size_t kPlacesAtOnce = 64;

/// A cube's point that comes first.
struct FirstPoint {
  LatticeCell cube;
  std::uint64_t hash = 0;
  std::uint32_t point = 0;
};

/// The first point of each run of points of one cube. Points in canonical order have few runs.
std::vector<FirstPoint> first_of_runs(std::span<const Vec3> positions, double cell,
                                      const StopToken* stop) {
  std::vector<FirstPoint> runs;
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    if (i % kStopBlock == 0) check_stop(stop);
    const FirstPoint one{cube_of(positions[i], cell), hash_of(positions[i]), i};
    if (runs.empty() || runs.back().cube != one.cube)
      runs.push_back(one);
    else if (one.hash < runs.back().hash)
      runs.back() = one;
  }
  return runs;
}

/// The points of [begin, end) that come first in their cubes.
std::vector<std::uint32_t> first_points(std::span<const Vec3> positions, std::uint32_t begin,
                                        std::uint32_t end, const NoisePlaceOptions& options) {
  std::vector<FirstPoint> runs = first_of_runs(positions, options.cell, options.stop);
  const auto comes_first = [](const FirstPoint& a, const FirstPoint& b) {
    return std::tie(a.cube, a.hash, a.point) < std::tie(b.cube, b.hash, b.point);
  };
  std::sort(runs.begin(), runs.end(), comes_first);
  std::vector<std::uint32_t> points;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (k > 0 && runs[k].cube == runs[k - 1].cube) continue;
    if (runs[k].point >= begin && runs[k].point < end) points.push_back(runs[k].point);
  }
  std::sort(points.begin(), points.end());
  return points;
}

/// The noise at one point of the cloud after the other.
class PlaceMeasure {
 public:
  PlaceMeasure(std::span<const Vec3> positions, const NeighborSearch& search, PlaceLimits limits)
      : positions_(positions), search_(search), limits_(limits) {}

  NoisePlace at(std::uint32_t point) {
    const Vec3 p = positions_[point];
    const auto measured = meter_.at(
        p, positions_, limits_,
        [&](std::size_t count, std::vector<Neighbor>& found) { find(point, count, found); });
    if (!measured) return {p, 0.0, 0.0};
    return {p, measured->spacing, measured->is_layer ? measured->noise : -1.0};
  }

 private:
  void find(std::uint32_t point, std::size_t count, std::vector<Neighbor>& found) {
    query_.find(search_, point, point + 1, count, squared_reach(limits_.reach));
    const auto indices = query_.of(point);
    const auto squared = query_.squared_of(point);
    found.assign(1, {0.0, point});
    for (std::size_t i = 0; i < indices.size(); ++i) found.push_back({squared[i], indices[i]});
    std::sort(found.begin() + 1, found.end(), kNearerFirst);
  }

  std::span<const Vec3> positions_;
  const NeighborSearch& search_;
  PlaceLimits limits_;
  NeighborSearch::Query query_;
  NoiseMeter meter_;
};

}  // namespace

double noise_halo(const NoisePlaceOptions& options) {
  return std::max(options.cell, options.reach);
}

std::vector<NoisePlace> measure_noise_places(std::span<const Vec3> positions, std::uint32_t begin,
                                             std::uint32_t end, const NoisePlaceOptions& options) {
  if (begin == end) return {};
  const std::vector<std::uint32_t> points = first_points(positions, begin, end, options);
  const NeighborSearch search(positions);
  std::vector<NoisePlace> places(points.size());
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, points.size(), kPlacesAtOnce), [&](const Range& range) {
    check_stop(options.stop);
    PlaceMeasure measure(positions, search, {options.reach, options.most_points});
    for (std::size_t i = range.begin(); i < range.end(); ++i) places[i] = measure.at(points[i]);
  });
  return places;
}

}  // namespace orbweave
