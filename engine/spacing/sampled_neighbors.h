// The nearest neighbours of some points of a cloud, for what is measured by distances.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/point_tree.h"
#include "engine/spacing/searched_sites.h"
#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

/// The neighbours of a sample of the points in the cores of sites, chosen by hash, found once for
/// all that is measured there. Some 33,000 points at most: quantiles of more are no better.
class SampledNeighbors {
 public:
  static constexpr std::uint64_t kMostPlaces = 32768;

  /// `neighbors` of each of about `places` points, or as many as its site has; `sites` outlive it.
  /// `stop` may be null. Runs on the calling TBB arena.
  SampledNeighbors(const SearchedSites& sites, std::size_t neighbors,
                   const StopToken* stop = nullptr, std::uint64_t places = kMostPlaces);

  struct Place {
    const SpacingSite& site;
    std::uint32_t point = 0;            ///< of the site
    std::span<const Neighbor> nearest;  ///< the point itself, then the others, nearest first
  };
  std::size_t size() const { return places_.size(); }
  std::size_t neighbors() const { return stride_ - 1; }
  Place at(std::size_t i) const;
  /// A point of the site of place `i` and its nearest others, `count` in all, nearest first.
  void find_nearest(std::size_t i, std::uint32_t point, std::size_t count, SiteSearch::Query& query,
                    std::vector<Neighbor>& found) const {
    query.nearest(sites_.search(places_[i].site), point, count, found);
  }

 private:
  struct SitePoint {
    std::uint32_t site = 0, point = 0;
  };
  void choose_places(std::uint64_t wanted, const StopToken* stop);
  void find(std::size_t begin, std::size_t end);

  const SearchedSites& sites_;
  std::size_t stride_;
  std::vector<SitePoint> places_;
  std::vector<Neighbor> nearest_;  // stride_ for each place
};

}  // namespace orbweave
