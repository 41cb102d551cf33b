// The sites of a cloud with the search for neighbours in each of them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/spacing/site_points.h"
#include "engine/spacing/site_search.h"
#include "engine/spacing/spacing_site.h"
#include "io/stop_token.h"

namespace orbweave {

/// Sites without copies of points, made ready once for all that is measured at them. Takes about 40
/// bytes per point of the sites, and as much as the sites where these hold copies of points.
class SearchedSites {
 public:
  /// `sites` outlive it. `stop` may be null. Runs on the calling TBB arena.
  explicit SearchedSites(std::span<const SpacingSite> sites, const StopToken* stop = nullptr);

  std::span<const SpacingSite> all() const { return distinct_.all(); }
  const SiteSearch& search(std::size_t site) const { return searches_[site]; }

 private:
  DistinctSites distinct_;
  std::vector<SiteSearch> searches_;
};

}  // namespace orbweave
