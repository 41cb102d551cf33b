#include "engine/ball_pivoting/crowd_tree.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "io/box.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kGroup = GroupedPoints::kGroup;
/// Out of reach of any ball.
constexpr double kFarAway = 1e200;

/// The largest power of eight below n, which is more than eight.
std::uint32_t unit_below(std::uint32_t n) {
  std::uint32_t unit = kGroup;
  while (unit <= (n - 1) / kGroup) unit *= kGroup;
  return unit;
}

}  // namespace

CrowdTree::CrowdTree(const CellGrid& grid) : id_(grid.size()), place_(grid.size()) {
  std::iota(id_.begin(), id_.end(), 0u);
  put_in_order(grid, 0, grid.size());
  for (std::uint32_t k = 0; k < grid.size(); ++k) place_[id_[k]] = k;
  for (std::uint64_t points = 1;; points *= kGroup) {
    add_level(grid, points);
    if (points * kGroup >= grid.size()) break;
  }
  groups_.id = id_.data();
  groups_.place = place_.data();
  groups_.levels = static_cast<int>(levels_.size());
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const Level& level = levels_[l];
    groups_.level[l] = {level.x.data(), level.y.data(), level.z.data(), level.radius.data(),
                        static_cast<std::uint32_t>(level.x.size())};
  }
}

/// Every group of every level is a part that the halves were cut into.
void CrowdTree::put_in_order(const CellGrid& grid, std::uint32_t begin, std::uint32_t end) {
  constexpr std::uint32_t kWorthATask = 4096;
  const std::uint32_t n = end - begin;
  if (n <= kGroup) return;
  Box box;
  for (std::uint32_t k = begin; k < end; ++k) box.extend(grid.position(id_[k]));
  const Vec3 extent = box.extent();
  const int axis =
      extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  const std::uint32_t unit = unit_below(n);
  const std::uint32_t units = (n + unit - 1) / unit;
  const std::uint32_t middle = begin + unit * (units / 2);
  const auto at = [&](std::uint32_t k) { return id_.begin() + static_cast<std::ptrdiff_t>(k); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return grid.position(a)[axis] < grid.position(b)[axis];
  });
  const auto lower = [&] { put_in_order(grid, begin, middle); };
  const auto upper = [&] { put_in_order(grid, middle, end); };
  if (n < kWorthATask) {
    lower();
    upper();
  } else {
    tbb::parallel_invoke(lower, upper);
  }
}

void CrowdTree::add_level(const CellGrid& grid, std::uint64_t points_per_entry) {
  const auto entries =
      static_cast<std::uint32_t>((grid.size() + points_per_entry - 1) / points_per_entry);
  const std::uint32_t padded = (entries + kGroup - 1) / kGroup * kGroup;
  Level level;
  for (auto* array : {&level.x, &level.y, &level.z}) array->assign(padded, kFarAway);
  level.radius.assign(padded, 0.0);
  tbb::parallel_for(std::uint32_t{0}, entries, [&](std::uint32_t entry) {
    const std::uint64_t begin = entry * points_per_entry;
    const std::uint64_t end = std::min<std::uint64_t>(begin + points_per_entry, grid.size());
    Box box;
    for (std::uint64_t k = begin; k < end; ++k) box.extend(grid.position(id_[k]));
    const Vec3 center = end - begin == 1 ? grid.position(id_[begin]) : box.center();
    double squared = 0.0;
    for (std::uint64_t k = begin; k < end; ++k)
      squared = std::max(squared, squared_norm(grid.position(id_[k]) - center));
    level.x[entry] = center.x;
    level.y[entry] = center.y;
    level.z[entry] = center.z;
    level.radius[entry] = std::sqrt(squared) * (1.0 + 1e-12);
  });
  levels_.push_back(std::move(level));
}

}  // namespace orbweave
