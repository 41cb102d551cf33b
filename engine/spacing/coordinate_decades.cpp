#include "engine/spacing/coordinate_decades.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <vector>

#include "engine/spacing/site_points.h"
#include "io/error.h"

namespace orbweave {
namespace {

/// A scanner that measures from millimetres to kilometres has 7.
constexpr int kMostDecades = 20;

int decade_of_binade(int binade) {
  constexpr double kDecadesPerBinade = 0.30102999566398120;
  return static_cast<int>(std::floor(binade * kDecadesPerBinade));
}

int decade_of(double magnitude) { return decade_of_binade(std::ilogb(magnitude)); }

/// Points by the binades of their largest coordinates.
class BinadeCounts {
 public:
  void add(int binade) { ++counts_[static_cast<std::size_t>(binade - kLeast)]; }

  /// The points of each decade that has some.
  std::vector<std::uint64_t> by_decade() const {
    std::map<int, std::uint64_t> decades;
    for (std::size_t i = 0; i < counts_.size(); ++i)
      if (counts_[i] > 0) decades[decade_of_binade(kLeast + static_cast<int>(i))] += counts_[i];
    std::vector<std::uint64_t> counts;
    for (const auto& [decade, count] : decades) counts.push_back(count);
    return counts;
  }

 private:
  using Limits = std::numeric_limits<double>;
  static constexpr int kLeast = Limits::min_exponent - Limits::digits;  // of subnormal numbers
  std::array<std::uint64_t, Limits::max_exponent - kLeast> counts_{};
};

/// How many of the counts, the largest first, make up nine tenths of their sum.
int most_of(std::vector<std::uint64_t> counts) {
  std::ranges::sort(counts, std::greater());
  std::uint64_t left = 0;
  for (const std::uint64_t count : counts) left += count;
  const std::uint64_t rest = left / 10;
  int taken = 0;
  for (auto count = counts.begin(); left > rest; ++count, ++taken) left -= *count;
  return taken;
}

}  // namespace

CoordinateDecades coordinate_decades(std::span<const SpacingSite> sites) {
  CoordinateDecades found;
  BinadeCounts points;
  bool any = false;
  for (const SpacingSite& site : sites)
    for (const Vec3& p : site.points) {
      const double magnitude = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      if (magnitude == 0.0) continue;
      found.least = any ? std::min(found.least, magnitude) : magnitude;
      found.most = std::max(found.most, magnitude);
      points.add(std::ilogb(magnitude));
      any = true;
    }
  found.crowded = most_of(points.by_decade());
  return found;
}

std::string objection_to_decades(const CoordinateDecades& decades) {
  if (decades.crowded <= kMostDecades) return {};
  return "coordinates span " +
         std::to_string(decade_of(decades.most) - decade_of(decades.least) + 1) +
         " decades, from " + short_text(decades.least) + " to " + short_text(decades.most) +
         ": the byte order of the file, or the columns that coordinates are read from, are "
         "probably wrong";
}

void require_few_decades(std::span<const SpacingSite> sites, const std::string& file) {
  const CoordinateDecades decades = coordinate_decades(sites);
  const std::string objection = objection_to_decades(decades);
  if (objection.empty()) return;
  throw_bad_input(objection, {.file = file,
                              .found = "nine tenths of the points in " +
                                       std::to_string(decades.crowded) + " decades",
                              .expected = "at most " + std::to_string(kMostDecades),
                              .advice = "Export the scan again, or name the columns."});
}

}  // namespace orbweave
