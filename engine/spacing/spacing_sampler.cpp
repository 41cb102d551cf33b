#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "engine/spacing/automatic_radii.h"
#include "engine/spacing/site_points.h"
#include "partition/octree.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kMostLeaves = std::uint64_t{1} << 18;
/// A site's box is larger than its core by this part of the core's side. Six neighbours of a point
/// are rarely farther away, and surfaces that lie exactly on a face of the core are whole.
constexpr double kMargin = 0.125;

/// splitmix64 (Steele, Lea, Flood 2014).
std::uint64_t mixed(std::uint64_t word) {
  word += 0x9E3779B97F4A7C15u;
  word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9u;
  word = (word ^ (word >> 27)) * 0x94D049BB133111EBu;
  return word ^ (word >> 31);
}

/// The whole cloud as one site: nothing lies beyond.
SpacingSite whole_cloud() {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const Box everything{{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  return {everything, everything, {}};
}

/// The leaves whose hashes come first. Leaves of few points, where a surface
/// just touches a cube, say little about distances and are taken only if there is nothing else.
std::vector<Chunk> chosen_leaves(const PointCounts& grid, const RootCube& root, std::size_t sites,
                                 std::uint32_t points_per_site, std::uint64_t limit) {
  std::vector<Chunk> leaves = cut_octree(grid, root, limit).chunks();
  const auto has_few = [&](const Chunk& leaf) { return leaf.points < points_per_site / 8; };
  if (!std::all_of(leaves.begin(), leaves.end(), has_few)) std::erase_if(leaves, has_few);
  const auto comes_first = [](const Chunk& a, const Chunk& b) {
    return mixed(a.code_begin) < mixed(b.code_begin);
  };
  std::sort(leaves.begin(), leaves.end(), comes_first);
  leaves.resize(std::min(leaves.size(), sites));
  return leaves;
}

/// Which sites a point may belong to: a coarse lattice over all of them, with a list per cell.
class SiteLattice {
 public:
  explicit SiteLattice(const std::vector<SpacingSite>& sites) {
    for (const SpacingSite& site : sites) bounds_.extend(site.box);
    cells_per_unit_ = kCells / bounds_.largest_extent();
    first_.assign(kCells * kCells * kCells + 1, 0);
    // Counted, then filled: a counting sort of (cell, site).
    for (const SpacingSite& site : sites)
      for_cells(site.box, [&](std::size_t cell) { ++first_[cell + 1]; });
    for (std::size_t cell = 1; cell < first_.size(); ++cell) first_[cell] += first_[cell - 1];
    sites_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t s = 0; s < sites.size(); ++s)
      for_cells(sites[s].box, [&](std::size_t cell) { sites_[next[cell]++] = s; });
  }
  std::span<const std::uint32_t> near(Vec3 p) const {
    if (!bounds_.contains(p)) return {};
    const std::size_t cell = cell_at(index(p, 0), index(p, 1), index(p, 2));
    return std::span(sites_).subspan(first_[cell], first_[cell + 1] - first_[cell]);
  }
  std::size_t memory_bytes() const { return 4 * (first_.capacity() + sites_.capacity()); }

 private:
  static constexpr int kCells = 64;

  /// Monotone in the coordinate, so a point of a box is never outside the box's cells.
  int index(Vec3 p, int axis) const {
    return std::min(kCells - 1, static_cast<int>((p[axis] - bounds_.min[axis]) * cells_per_unit_));
  }
  static std::size_t cell_at(int x, int y, int z) {
    constexpr std::size_t kRow = kCells;
    return (static_cast<std::size_t>(z) * kRow + static_cast<std::size_t>(y)) * kRow +
           static_cast<std::size_t>(x);
  }
  void for_cells(const Box& box, const auto& visit) const {
    for (int z = index(box.min, 2); z <= index(box.max, 2); ++z)
      for (int y = index(box.min, 1); y <= index(box.max, 1); ++y)
        for (int x = index(box.min, 0); x <= index(box.max, 0); ++x) visit(cell_at(x, y, z));
  }

  Box bounds_;
  double cells_per_unit_ = 1.0;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> sites_;
};

SpacingSite site_of(const Chunk& leaf) {
  return {leaf.box, leaf.box.grown(kMargin * leaf.box.largest_extent()), {}};
}

/// Points of the cells that reach into each site's box. A cell is no wider than a box, so one of
/// its corners lies in it.
std::vector<std::uint64_t> points_in_reach(const std::vector<SpacingSite>& sites,
                                           const SiteLattice& lattice, const PointCounts& grid) {
  std::vector<std::uint64_t> points(sites.size(), 0);
  std::vector<std::uint32_t> found;
  grid.for_each([&](Vec3 corner, std::uint64_t count) {
    found.clear();
    for (int c = 0; c < 8; ++c) {
      const Vec3 p =
          corner + grid.cell() * Vec3{static_cast<double>(c & 1), static_cast<double>((c >> 1) & 1),
                                      static_cast<double>((c >> 2) & 1)};
      for (const std::uint32_t s : lattice.near(p))
        if (sites[s].box.contains(p)) found.push_back(s);
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    for (const std::uint32_t s : found) points[s] += count;
  });
  return points;
}

/// The site of the most points, and of the others, in their order, those that fit into what is left
/// of kMostPoints; with room for their points.
void keep_affordable(std::vector<SpacingSite>& sites, const PointCounts& grid) {
  const std::vector<std::uint64_t> points = points_in_reach(sites, SiteLattice(sites), grid);
  const auto densest =
      static_cast<std::size_t>(std::max_element(points.begin(), points.end()) - points.begin());
  std::vector<SpacingSite> kept;
  std::uint64_t left = SpacingSampler::kMostPoints;
  for (std::size_t s = 0; s < sites.size(); ++s) {
    if (s != densest && points[s] > left) continue;
    if (s != densest) left -= points[s];
    kept.push_back(std::move(sites[s]));
    kept.back().points.reserve(points[s]);
  }
  sites = std::move(kept);
}

}  // namespace

struct SpacingSampler::State {
  std::uint64_t points = 0;
  std::vector<SpacingSite> sites;
  std::vector<std::vector<std::uint32_t>> scans;  ///< of the sites' points; empty: not collected
  std::optional<SiteLattice> lattice;             ///< none where the whole cloud is one site
};

SpacingSampler::SpacingSampler(const RootCube& root, const PointCounts& grid, std::size_t sites,
                               std::uint32_t points_per_site)
    : state_(std::make_unique<State>()) {
  state_->points = grid.points();
  if (grid.points() <= sites * std::uint64_t{points_per_site}) {
    state_->sites.push_back(whole_cloud());
    state_->sites.back().points.reserve(grid.points());
    return;
  }
  const std::uint64_t limit =
      std::max<std::uint64_t>(4 * std::uint64_t{points_per_site}, grid.points() / kMostLeaves);
  const std::vector<Chunk> leaves = chosen_leaves(grid, root, sites, points_per_site, limit);
  for (const Chunk& leaf : leaves) state_->sites.push_back(site_of(leaf));
  if (std::any_of(leaves.begin(), leaves.end(), [&](const Chunk& l) { return l.points > limit; })) {
    keep_affordable(state_->sites, grid);
  } else {
    for (std::size_t s = 0; s < leaves.size(); ++s)
      state_->sites[s].points.reserve(leaves[s].points + leaves[s].points / 2);
  }
  state_->lattice.emplace(state_->sites);
}

SpacingSampler::SpacingSampler(std::vector<SpacingSite> sites, std::uint64_t cloud_points)
    : state_(std::make_unique<State>()) {
  state_->points = cloud_points;
  state_->sites = std::move(sites);
  const bool whole = state_->sites.size() == 1 && !std::isfinite(state_->sites[0].box.max.x);
  if (!whole) state_->lattice.emplace(state_->sites);
}

SpacingSampler::~SpacingSampler() = default;
SpacingSampler::SpacingSampler(SpacingSampler&&) noexcept = default;
SpacingSampler& SpacingSampler::operator=(SpacingSampler&&) noexcept = default;

void SpacingSampler::collect_scans() {
  state_->scans.resize(state_->sites.size());
  for (std::size_t s = 0; s < state_->sites.size(); ++s)
    state_->scans[s].reserve(state_->sites[s].points.capacity());
}

void SpacingSampler::add(std::span<const Vec3> positions, std::uint32_t scan) {
  if (!state_->lattice) {
    auto& all = state_->sites.front().points;
    all.insert(all.end(), positions.begin(), positions.end());
  } else {
    for (const Vec3& p : positions)
      for (const std::uint32_t s : state_->lattice->near(p))
        if (state_->sites[s].box.contains(p)) state_->sites[s].points.push_back(p);
  }
  for (std::size_t s = 0; s < state_->scans.size(); ++s)
    state_->scans[s].resize(state_->sites[s].points.size(), scan);
}

void SpacingSampler::add_at_site(std::size_t site, std::span<const Vec3> positions,
                                 std::span<const std::uint32_t> scans) {
  auto& points = state_->sites.at(site).points;
  points.insert(points.end(), positions.begin(), positions.end());
  if (state_->scans.empty()) return;
  if (scans.size() != positions.size())
    throw std::invalid_argument("a point of a site comes without its scan");
  state_->scans[site].insert(state_->scans[site].end(), scans.begin(), scans.end());
}

void SpacingSampler::merge_duplicates(const StopToken* stop) {
  state_->scans.clear();
  orbweave::merge_duplicates(state_->sites, stop);
  for (SpacingSite& site : state_->sites) keep_part(site, kMostPointsOfSite, stop);
}

RadiiChoice SpacingSampler::choose(int levels, const StopToken* stop) const {
  const SearchedSites sites(state_->sites, stop);
  return choose_radii(SampledNeighbors(sites, neighbors_for_radii(), stop), state_->points, levels,
                      stop);
}

std::span<const SpacingSite> SpacingSampler::sites() const { return state_->sites; }

std::span<const std::vector<std::uint32_t>> SpacingSampler::scans() const { return state_->scans; }

std::uint64_t SpacingSampler::cloud_points() const { return state_->points; }

std::size_t SpacingSampler::memory_bytes() const {
  std::size_t bytes = state_->lattice ? state_->lattice->memory_bytes() : 0;
  for (const SpacingSite& site : state_->sites)
    bytes += sizeof site + site.points.capacity() * sizeof(Vec3);
  for (const auto& scans : state_->scans) bytes += scans.capacity() * sizeof(std::uint32_t);
  return bytes;
}

}  // namespace orbweave
