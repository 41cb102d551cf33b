#include "engine/holes/rbf/rbf_centers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace orbweave {
namespace {

bool before(Vec3 a, Vec3 b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

// For each site the first one at the same place.
std::vector<std::uint32_t> first_at_place(const std::vector<Vec3>& sites) {
  std::vector<std::uint32_t> order(sites.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&sites](std::uint32_t a, std::uint32_t b) {
    return before(sites[a], sites[b]) || (sites[a] == sites[b] && a < b);
  });
  std::vector<std::uint32_t> first(sites.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && sites[order[i]] == sites[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

}  // namespace

UniqueSites merge_duplicates(const std::vector<Vec3>& sites, std::span<const double> values,
                             std::uint32_t channels, std::uint32_t exact_sites) {
  const std::vector<std::uint32_t> first = first_at_place(sites);
  UniqueSites unique;
  unique.of.resize(sites.size());
  std::vector<double> count;
  for (std::uint32_t i = 0; i < sites.size(); ++i) {
    if (first[i] == i) {
      unique.of[i] = static_cast<std::uint32_t>(unique.sites.size());
      unique.sites.push_back(sites[i]);
      unique.exact.push_back(i < exact_sites ? 1 : 0);
      count.push_back(0.0);
    } else {
      unique.of[i] = unique.of[first[i]];  // first[i] < i
    }
    count[unique.of[i]] += 1.0;
  }
  unique.channels = channels;
  unique.values.assign(unique.sites.size() * channels, 0.0);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    for (std::uint32_t c = 0; c < channels; ++c) {
      unique.values[unique.of[i] * channels + c] += values[i * channels + c] / count[unique.of[i]];
    }
  }
  return unique;
}

FarthestPoints::FarthestPoints(const std::vector<Vec3>& sites, std::span<const std::uint32_t> seeds)
    : sites_(sites), squared_(sites.size(), std::numeric_limits<double>::infinity()) {
  for (const std::uint32_t seed : seeds) cover(seed);
}

std::optional<std::uint32_t> FarthestPoints::next() {
  const auto best = std::max_element(squared_.begin(), squared_.end());
  if (best == squared_.end() || !(*best > 0.0)) return std::nullopt;
  const auto which = static_cast<std::uint32_t>(best - squared_.begin());
  cover(which);
  return which;
}

double FarthestPoints::radius() const {
  return std::sqrt(*std::max_element(squared_.begin(), squared_.end()));
}

void FarthestPoints::cover(std::uint32_t center) {
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    squared_[i] = std::min(squared_[i], squared_norm(sites_[i] - sites_[center]));
  }
}

std::vector<std::uint32_t> worst_sites(const std::vector<Vec3>& sites,
                                       const std::vector<double>& residuals,
                                       std::vector<std::uint32_t> candidates, std::size_t count,
                                       double separation) {
  std::sort(candidates.begin(), candidates.end(), [&](std::uint32_t a, std::uint32_t b) {
    return residuals[a] > residuals[b] || (residuals[a] == residuals[b] && a < b);
  });
  std::vector<std::uint32_t> chosen;
  std::vector<std::uint32_t> passed;
  for (const std::uint32_t site : candidates) {
    if (chosen.size() == count) break;
    const bool close = std::any_of(chosen.begin(), chosen.end(), [&](std::uint32_t other) {
      return squared_norm(sites[site] - sites[other]) < separation * separation;
    });
    (close ? passed : chosen).push_back(site);
  }
  for (std::size_t i = 0; i < passed.size() && chosen.size() < (count + 1) / 2; ++i) {
    chosen.push_back(passed[i]);
  }
  return chosen;
}

}  // namespace orbweave
