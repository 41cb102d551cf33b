#include "engine/holes/plane/plane_heights.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace orbweave {
namespace {

// Smoothing lengths that are tried, in spacings. Real scans ask for 0.2 to 0.6.
constexpr double kLengths[] = {0.2, 0.3, 0.45, 0.65, 1.0};
// Number of lengths in a row, each worse than the best, that ends the search.
constexpr int kPatience = 2;
// A part shows whether there is noise: this number of adjacent sites.
constexpr std::size_t kSample = 100;

std::vector<double> heights_of(const std::vector<Vec3>& places) {
  std::vector<double> heights;
  heights.reserve(places.size());
  for (const Vec3 place : places) heights.push_back(place.z);
  return heights;
}

RbfOptions fit_options(double spacing, double length, const PatchOptions& options) {
  RbfOptions rbf;
  rbf.dimension = 2;
  rbf.kernel = options.kernel;
  rbf.max_sites = options.max_sites;
  rbf.tolerance = options.tolerance * spacing;
  rbf.smoothing_length = length * spacing;
  rbf.site_spacing = spacing;
  rbf.measure = false;
  return rbf;
}

RbfInterpolant fit(const std::vector<Vec3>& places, double spacing, double length,
                   const PatchOptions& options) {
  return RbfInterpolant(places, heights_of(places), 1, fit_options(spacing, length, options));
}

struct SmoothedFit {
  RbfInterpolant heights;
  double length = 0.0;  // spacings
};

// For as many sites as are solved for at once.
SmoothedFit fit_least_deviance(const std::vector<Vec3>& places, double spacing,
                               const PatchOptions& options) {
  const std::vector<double> values = heights_of(places);
  RbfInterpolant::Family family(places, values, 1, fit_options(spacing, 0.0, options),
                                1 + std::size(kLengths));
  SmoothedFit best{family.with_smoothing(0.0), 0.0};
  int worse = 0;
  for (const double length : kLengths) {
    RbfInterpolant heights = best.heights.valid()
                                 ? family.with_smoothing(length * spacing, best.heights.deviance())
                                 : family.with_smoothing(length * spacing);
    const bool better = heights.valid();
    if (better) best = {std::move(heights), length};
    worse = better ? 0 : worse + 1;
    if (worse == kPatience) break;
  }
  return best;
}

// The sites nearest to the first one.
std::vector<Vec3> sample_of(std::vector<Vec3> places, std::size_t count) {
  const auto from_first = [first = places[0]](Vec3 x) {
    const double dx = x.x - first.x;
    const double dy = x.y - first.y;
    return dx * dx + dy * dy;
  };
  std::stable_sort(places.begin(), places.end(),
                   [&](Vec3 a, Vec3 b) { return from_first(a) < from_first(b); });
  places.resize(std::min(places.size(), count));
  return places;
}

}  // namespace

RbfInterpolant fit_heights(const std::vector<Vec3>& places, double spacing,
                           const PatchOptions& options) {
  const std::size_t sample = std::min<std::size_t>(kSample, options.max_sites);
  if (places.size() <= sample) return fit_least_deviance(places, spacing, options).heights;
  const SmoothedFit part = fit_least_deviance(sample_of(places, sample), spacing, options);
  const double length = part.heights.valid() ? part.length : 0.0;
  if (places.size() <= options.max_sites || length == 0.0) {
    return fit(places, spacing, length, options);
  }
  const std::vector<Vec3> means = mean_places(places, options.max_sites);
  const double ratio = static_cast<double>(places.size()) / static_cast<double>(means.size());
  return fit(means, spacing * std::sqrt(ratio), length, options);
}

HoleHeights::HoleHeights(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
                         const PlaneOutline& outline, const PatchOptions& options)
    : problem_(problem), rim_(rim), frame_(frame), outline_(outline), options_(options) {}

bool HoleHeights::is_steep() const {
  constexpr double kSteep = 0.5;  // 60 degrees: lattices half as fine begin at 67
  return std::any_of(rim_.face_normals.begin(), rim_.face_normals.end(), [&](Vec3 normal) {
    return normal != Vec3{} && dot(normal, frame_.axis) < kSteep;
  });
}

RbfInterpolant::ValueGradient HoleHeights::at(Vec3 place) const {
  std::call_once(once_, [this] {
    sites_ = plane_sites(problem_, rim_, frame_, outline_);
    fit_ = fit_heights(sites_.places, rim_.spacing, options_);
  });
  return fit_->valid() ? fit_->evaluate_with_gradient(place) : RbfInterpolant::ValueGradient{};
}

}  // namespace orbweave
