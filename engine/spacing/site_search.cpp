#include "engine/spacing/site_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "io/bounds.h"
#include "partition/canonical_order.h"
#include "partition/radix_sort.h"
#include "partition/root_cube.h"

namespace orbweave {
namespace {

/// How many more are asked for at first than are wanted: of those as far away as the last one, the
/// search may take others than their indices say.
constexpr std::size_t kSpare = 4;

std::vector<std::uint32_t> morton_order(std::span<const Vec3> positions) {
  std::vector<KeyIndex> keys;
  keys.reserve(positions.size());
  if (!positions.empty()) {
    const MortonFrame frame(root_cube(bounds_of(positions)));
    for (const Vec3& p : positions)
      keys.push_back({frame.code(p), static_cast<std::uint32_t>(keys.size())});
    radix_sort(keys);
  }
  std::vector<std::uint32_t> order;
  order.reserve(keys.size());
  for (const KeyIndex& key : keys) order.push_back(key.index);
  return order;
}

std::vector<std::uint32_t> inverse(std::span<const std::uint32_t> order) {
  std::vector<std::uint32_t> rank(order.size());
  for (std::uint32_t r = 0; r < order.size(); ++r) rank[order[r]] = r;
  return rank;
}

std::vector<Vec3> in_order(std::span<const Vec3> positions, std::span<const std::uint32_t> order) {
  std::vector<Vec3> sorted;
  sorted.reserve(order.size());
  for (const std::uint32_t i : order) sorted.push_back(positions[i]);
  return sorted;
}

}  // namespace

SiteSearch::SiteSearch(std::span<const Vec3> positions)
    : position_of_rank_(morton_order(positions)),
      rank_of_position_(inverse(position_of_rank_)),
      search_(in_order(positions, position_of_rank_)) {}

/// Sorts few neighbours by counting how many are nearer than each: no branch depends on the
/// distances. False where two are equally near.
bool SiteSearch::Query::sort_by_counts(std::vector<Neighbor>& found) {
  const std::size_t count = found.size();
  std::array<double, kFew> squared;
  for (std::size_t i = 0; i < count; ++i) squared[i] = found[i].squared_distance;
  sorted_.resize(count);
  std::uint64_t taken = 0;  // a bit for each place
  for (const Neighbor& each : found) {
    std::uint64_t nearer = 0;
    for (std::size_t k = 0; k < count; ++k) nearer += squared[k] < each.squared_distance ? 1 : 0;
    taken |= std::uint64_t{1} << nearer;
    sorted_[nearer] = each;
  }
  if (static_cast<std::size_t>(std::popcount(taken)) != count) return false;
  found.swap(sorted_);
  return true;
}

/// Sorts neighbours, nearest first. Many neighbours are dealt to as many buckets by their squared
/// distances, which are about evenly spread on a surface; each bucket is sorted on its own.
void SiteSearch::Query::sort(std::vector<Neighbor>& found) {
  if (found.size() <= kFew && sort_by_counts(found)) return;
  double most = 0.0;
  for (const Neighbor& each : found) most = std::max(most, each.squared_distance);
  const double scale = static_cast<double>(found.size() - 1) / most;
  // Points of opposite ends of what doubles hold are infinitely far apart by their squares.
  const bool spreads = scale > 0.0 && scale < std::numeric_limits<double>::max();
  if (found.size() <= kFew || !spreads) {
    std::sort(found.begin(), found.end(), kNearerFirst);
    return;
  }
  const auto place = [&](const Neighbor& each) {
    return static_cast<std::size_t>(each.squared_distance * scale);
  };
  ends_.assign(found.size() + 2, 0);
  for (const Neighbor& each : found) ++ends_[place(each) + 2];
  for (std::size_t i = 2; i < ends_.size(); ++i) ends_[i] += ends_[i - 1];
  sorted_.resize(found.size());
  for (const Neighbor& each : found) sorted_[ends_[place(each) + 1]++] = each;
  for (std::size_t i = 0; i + 1 < ends_.size(); ++i)
    if (ends_[i + 1] - ends_[i] > 1)
      std::sort(sorted_.begin() + ends_[i], sorted_.begin() + ends_[i + 1], kNearerFirst);
  found.swap(sorted_);
}

void SiteSearch::Query::nearest(const SiteSearch& search, std::uint32_t point, std::size_t count,
                                std::vector<Neighbor>& found) {
  constexpr double kAnywhere = std::numeric_limits<double>::infinity();
  const std::uint32_t rank = search.rank_of_position_[point];
  for (std::size_t spare = kSpare;; spare *= 2) {
    query_.find(search.search_, rank, rank + 1, count + spare, kAnywhere);
    const auto ranks = query_.of(rank);
    const auto squared = query_.squared_of(rank);
    found.assign(1, {0.0, point});
    for (std::size_t i = 0; i < ranks.size(); ++i)
      found.push_back({squared[i], search.position_of_rank_[ranks[i]]});
    sort(found);
    const bool are_all = ranks.size() < count + spare;
    if (are_all || found.back().squared_distance > found[count - 1].squared_distance) break;
  }
  if (found.size() > count) found.resize(count);
}

}  // namespace orbweave
