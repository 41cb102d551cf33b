#include "engine/pipeline/points/halo_work.h"

#include <algorithm>
#include <utility>

#include "partition/canonical_order.h"

namespace orbweave {
namespace {

constexpr int kPlaceDepth = 8;
/// Points with halos over points. An even surface has 1.2 to 1.4.
constexpr double kMostWork = 2.0;

}  // namespace

std::vector<CrowdedPlace> crowded_places(const PointCounts& grid, const RootCube& root) {
  const MortonFrame frame(root);
  const double half = grid.cell() / 2.0;
  constexpr int kShift = 3 * (kMortonDepth - kPlaceDepth);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> counts;
  grid.for_each([&](Vec3 corner, std::uint64_t points) {
    const std::uint64_t code = frame.code(corner + Vec3{half, half, half}) >> kShift;
    if (!counts.empty() && counts.back().first == code)
      counts.back().second += points;
    else
      counts.emplace_back(code, points);
  });
  std::sort(counts.begin(), counts.end());
  std::vector<CrowdedPlace> places;
  const double side = root.side / (1 << kPlaceDepth);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::uint64_t code = counts[i].first, points = counts[i].second;
    if (i > 0 && counts[i - 1].first == code) {
      places.back().points += points;
      continue;
    }
    const auto along = [&](int axis) { return (deinterleave(code, axis) + 0.5) * side; };
    places.push_back({root.origin + Vec3{along(0), along(1), along(2)}, points});
  }
  return places;
}

std::vector<std::uint64_t> points_in_reach(std::span<const CrowdedPlace> places,
                                           const Octree& octree, double halo) {
  std::vector<std::uint64_t> points;
  for (const Chunk& chunk : octree.chunks()) {
    const Box box = chunk.box.grown(halo);
    points.push_back(0);
    for (const CrowdedPlace& place : places)
      if (box.contains(place.middle)) points.back() += place.points;
  }
  return points;
}

double halo_work(std::span<const CrowdedPlace> places, const Octree& octree, double halo) {
  double points = 0.0, loaded = 0.0;
  for (const CrowdedPlace& place : places) points += static_cast<double>(place.points);
  for (const std::uint64_t of_chunk : points_in_reach(places, octree, halo))
    loaded += static_cast<double>(of_chunk);
  return points > 0.0 ? loaded / points : 1.0;
}

Octree without_needless_halos(std::span<const CrowdedPlace> places, const Octree& fine, double halo,
                              std::uint64_t chunk_points, const ChunkRoom& room) {
  const auto fits = [&](const Octree& octree) {
    const std::vector<std::uint64_t> points = points_in_reach(places, octree, halo);
    return std::all_of(points.begin(), points.end(),
                       [&](std::uint64_t of_chunk) { return of_chunk <= room.with_halo; });
  };
  Octree octree = coarsened(fine, chunk_points);
  while (octree.chunks().size() > 1 && chunk_points < room.points &&
         halo_work(places, octree, halo) > kMostWork) {
    chunk_points = std::min(2 * chunk_points, room.points);
    Octree larger = coarsened(fine, chunk_points);
    if (!fits(larger)) break;
    octree = std::move(larger);
  }
  return octree;
}

}  // namespace orbweave
