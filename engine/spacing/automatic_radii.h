// Ball radii from the cloud itself: from the distances between neighbours in a sample of sites,
// small cubes from all over the cloud with all points in and around them.
//
// Sites are leaves of the octree that the count grid gives, chosen by a hash of where they lie,
// never by the order of points. The choice hence depends on the cloud as a set: not on the order
// of points, not on files, chunks or threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/spacing/sampled_neighbors.h"
#include "engine/spacing/spacing_site.h"
#include "io/box.h"
#include "io/stop_token.h"
#include "partition/point_counts.h"
#include "partition/root_cube.h"

namespace orbweave {

struct RadiiChoice {
  std::vector<double> radii;  ///< ascending, world units; empty where no radius makes sense
  double spacing = 0.0;       ///< typical distance between neighbours, world units
  std::string reason;         ///< a sentence for the reader, with the numbers
  /// The same distance in the sparse parts: all but a tenth of the surface has a smaller one.
  double spacing_by_area = 0.0;
  /// Of the points that are sparser by two steps of growth or more: how far they lie off the plane
  /// of their neighbours, in mean distances to these, the median. Leaves of trees reach 0.3, strays
  /// around an object lie above 0.4. 0 where such points are few, or are not asked for.
  double sparse_offset = 0.0;
  /// Where points lie on lines farther apart than the points on them: the number of neighbours of a
  /// point that reaches the lines beside its own. 0 elsewhere.
  std::size_t line_neighbors = 0;
};

/// The smallest radius, in spacings: closes a clean surface, and is little more than that, so that
/// thin walls and fine detail stay apart. (Calibrated: the base paper's hand-picked radii of the
/// Stanford models are 0.71 to 1.11 times what this gives; tori close from 1.0 on.)
inline constexpr double kRadiusPerSpacing = 1.1;
/// The ratio of each further radius to the one before.
inline constexpr double kRadiusGrowth = 1.5;

/// A ball of this number of spacings holds some 50,000 points of a surface: larger ones take no
/// sensible time.
inline constexpr double kMostSpacingsPerRadius = 64.0;

/// Neighbours that a sample has to have for choose_radii.
std::size_t neighbors_for_radii();

/// Mean distance to the `neighbors` nearest neighbours of every point measured (see choose_radii),
/// ascending. The sample has at least so many. Runs on the calling TBB arena.
std::vector<double> neighbor_distances(const SampledNeighbors& sample, std::size_t neighbors,
                                       const StopToken* stop = nullptr);

/// Radii for `levels` levels; 0: as many as the density asks for. What is measured is the mean
/// distance to the six nearest neighbours (fewer in clouds of fewer points; exact duplicates are
/// one point), at all points of a site's core that are farther from its box's border than from
/// their sixth neighbour (at all of the core where there is none such); of many points a sample by
/// hash. The spacing is the median of that. A lone radius has to serve the sparser parts too and is
/// taken from the ninth decile; several begin at the median and grow into them. From the density
/// follows one level where a step of growth reaches from the median to the sparse parts (the 98th
/// percentile of the points or, where that is more, the 90th of the surface, a point counting as
/// the square of its distance; points beyond 16 medians are strays, points whose dozen neighbours
/// lie all through space, as leaves do, are no surface), else as many as lead there, at most 8.
/// Where points lie on lines farther apart than the points on them, 0.55 of the distance to the
/// next line counts, too (find_scan_lines). No radii where no two points differ. `points` is the
/// size of the whole cloud, for the reason. Runs on the calling TBB arena.
RadiiChoice choose_radii(const SampledNeighbors& sample, std::uint64_t points, int levels,
                         const StopToken* stop = nullptr);

/// Collects the sites' points while the cloud streams by.
class SpacingSampler {
 public:
  /// `grid` holds the whole cloud and is settled. Clouds of at most sites * points_per_site
  /// points are one site as a whole; of larger ones `sites` leaves of at most four times
  /// points_per_site points are taken, as far as the grid resolves them. Where it does not, the
  /// cells of one place may fall into many sites: then the densest site is taken, and others that
  /// hold kMostPoints between them.
  SpacingSampler(const RootCube& root, const PointCounts& grid, std::size_t sites = 256,
                 std::uint32_t points_per_site = 512);
  /// Goes on with the sites of another sampler, with or without the points that it collected, of a
  /// cloud of `cloud_points` points.
  SpacingSampler(std::vector<SpacingSite> sites, std::uint64_t cloud_points);
  ~SpacingSampler();
  SpacingSampler(SpacingSampler&&) noexcept;
  SpacingSampler& operator=(SpacingSampler&&) noexcept;

  /// From now on, before any point, the scan of each point is collected as well.
  void collect_scans();
  /// Finite points, in any order, all of one scan. Every point of the cloud is added once. Not
  /// thread-safe.
  void add(std::span<const Vec3> positions, std::uint32_t scan = 0);
  /// Adds points that another sampler, with the same sites, collected at one of them, and their
  /// scans where these are collected.
  void add_at_site(std::size_t site, std::span<const Vec3> positions,
                   std::span<const std::uint32_t> scans = {});
  /// Makes copies of a point one, in place: whatever is measured afterwards need not copy the
  /// points. Scans are forgotten. Of a site with more than kMostPointsOfSite points a part is kept,
  /// which can be searched within the time that a request to stop may take. Once all points are
  /// added.
  void merge_duplicates(const StopToken* stop = nullptr);
  RadiiChoice choose(int levels, const StopToken* stop = nullptr) const;
  std::span<const SpacingSite> sites() const;
  /// The scan of each point of each site; empty where scans are not collected.
  std::span<const std::vector<std::uint32_t>> scans() const;
  std::uint64_t cloud_points() const;
  std::size_t memory_bytes() const;

  static constexpr std::uint64_t kMostPoints = std::uint64_t{1} << 19;
  static constexpr std::size_t kMostPointsOfSite = std::size_t{1} << 20;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
