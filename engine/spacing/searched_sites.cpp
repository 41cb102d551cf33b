#include "engine/spacing/searched_sites.h"

#include <optional>
#include <utility>

#include "io/whole_loop.h"

namespace orbweave {

SearchedSites::SearchedSites(std::span<const SpacingSite> sites, const StopToken* stop)
    : distinct_(sites, stop) {
  std::vector<std::optional<SiteSearch>> made(sites.size());
  for_each_whole(made.size(), [&](std::size_t site) {
    check_stop(stop);
    made[site].emplace(distinct_.all()[site].points);
  });
  searches_.reserve(made.size());
  for (std::optional<SiteSearch>& search : made) searches_.push_back(std::move(*search));
}

}  // namespace orbweave
