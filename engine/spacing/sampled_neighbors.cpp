#include "engine/spacing/sampled_neighbors.h"

#include <algorithm>

#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// Approximate maximum number of points measured.
constexpr std::uint64_t kMeasuredPoints = 32768;
/// Points that one thread takes at once, between two looks at the request to stop.
constexpr std::size_t kPlacesAtOnce = 256;

}  // namespace

SampledNeighbors::SampledNeighbors(const SearchedSites& sites, std::size_t neighbors,
                                   const StopToken* stop)
    : sites_(sites), stride_(neighbors + 1) {
  const PointSelection selection = select_points(sites.all(), kMeasuredPoints);
  for (std::uint32_t s = 0; s < sites.all().size(); ++s) {
    check_stop(stop);
    const SpacingSite& site = sites.all()[s];
    if (site.points.size() < 2) continue;
    for (const std::uint32_t i : sites.search(s).by_rank())
      if (site.core.contains(site.points[i]) && selection.takes(site.points[i]))
        places_.push_back({s, i});
  }
  nearest_.resize(places_.size() * stride_);
  for_each_whole((places_.size() + kPlacesAtOnce - 1) / kPlacesAtOnce, [&](std::size_t block) {
    check_stop(stop);
    find(block * kPlacesAtOnce, std::min(places_.size(), (block + 1) * kPlacesAtOnce));
  });
}

void SampledNeighbors::find(std::size_t begin, std::size_t end) {
  SiteSearch::Query query;
  std::vector<Neighbor> found;
  for (std::size_t i = begin; i < end; ++i) {
    query.nearest(sites_.search(places_[i].site), places_[i].point, stride_, found);
    std::copy(found.begin(), found.end(),
              nearest_.begin() + static_cast<std::ptrdiff_t>(i * stride_));
  }
}

SampledNeighbors::Place SampledNeighbors::at(std::size_t i) const {
  const SpacingSite& site = sites_.all()[places_[i].site];
  return {site, places_[i].point,
          std::span(nearest_).subspan(i * stride_, std::min(stride_, site.points.size()))};
}

}  // namespace orbweave
