#include "engine/spacing/sampled_neighbors.h"

#include <algorithm>

#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// Points that one thread takes at once, between two looks at the request to stop.
constexpr std::size_t kPlacesAtOnce = 256;

}  // namespace

SampledNeighbors::SampledNeighbors(const SearchedSites& sites, std::size_t neighbors,
                                   const StopToken* stop, std::uint64_t places)
    : sites_(sites), stride_(neighbors + 1) {
  choose_places(places, stop);
  nearest_.resize(places_.size() * stride_);
  for_each_whole((places_.size() + kPlacesAtOnce - 1) / kPlacesAtOnce, [&](std::size_t block) {
    check_stop(stop);
    find(block * kPlacesAtOnce, std::min(places_.size(), (block + 1) * kPlacesAtOnce));
  });
}

void SampledNeighbors::choose_places(std::uint64_t wanted, const StopToken* stop) {
  struct Block {
    std::uint32_t site;
    std::size_t begin;
  };
  constexpr std::size_t kPointsAtOnce = 4096;
  std::vector<Block> blocks;
  for (std::uint32_t s = 0; s < sites_.all().size(); ++s)
    if (const std::size_t points = sites_.all()[s].points.size(); points >= 2)
      for (std::size_t begin = 0; begin < points; begin += kPointsAtOnce)
        blocks.push_back({s, begin});
  const PointSelection selection = select_points(sites_.all(), wanted);
  std::vector<std::vector<SitePoint>> chosen(blocks.size());
  for_each_whole(blocks.size(), [&](std::size_t block) {
    check_stop(stop);
    const auto [s, begin] = blocks[block];
    const SpacingSite& site = sites_.all()[s];
    const std::size_t points = std::min(kPointsAtOnce, site.points.size() - begin);
    for (const std::uint32_t i : sites_.search(s).by_rank().subspan(begin, points))
      if (site.core.contains(site.points[i]) && selection.takes(site.points[i]))
        chosen[block].push_back({s, i});
  });
  for (const std::vector<SitePoint>& places : chosen)
    places_.insert(places_.end(), places.begin(), places.end());
}

void SampledNeighbors::find(std::size_t begin, std::size_t end) {
  SiteSearch::Query query;
  std::vector<Neighbor> found;
  for (std::size_t i = begin; i < end; ++i) {
    find_nearest(i, places_[i].point, stride_, query, found);
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
