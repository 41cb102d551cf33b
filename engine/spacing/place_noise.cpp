#include "engine/spacing/place_noise.h"

#include <algorithm>
#include <cmath>

namespace orbweave {
namespace {

constexpr std::size_t kSpacingNeighbors = 6;
/// Points of the first neighbourhood; each further one has twice as many, which is 1.4 times the
/// radius on a surface.
constexpr std::size_t kFirstNeighborhood = 12;
/// A neighbourhood is wide when its radius is at least this multiple of the deviation in it. (A
/// ball filled evenly has 2.2.)
constexpr double kWide = 6.0;
/// The widest neighbourhood of a layer is at least that multiple; leaves of trees have about 3.
constexpr double kLayer = 5.0;
/// Numbers of a quadratic surface and of its plane that are fitted.
constexpr double kFitted = 6.0;

/// Of samples from their local surface.
struct Deviation {
  double root_mean_square = 0.0;  ///< in radii
  double kurtosis = 3.0;
};

std::optional<Deviation> deviation_of(const std::vector<SurfaceSample>& samples) {
  const auto surface = fit_surface(samples, {});
  if (!surface) return std::nullopt;
  double squares = 0.0, fourth_powers = 0.0;
  for (const SurfaceSample& sample : samples) {
    const double off = surface->distance_above(sample.offset);
    squares += off * off;
    fourth_powers += off * off * (off * off);
  }
  const auto count = static_cast<double>(samples.size());
  Deviation deviation{.root_mean_square = std::sqrt(squares / (count - kFitted))};
  if (squares > 0.0) deviation.kurtosis = count * fourth_powers / (squares * squares);
  return deviation;
}

/// Noise is the same in both neighbourhoods; what the surface is finer than a quadric doubles
/// (measured on scanned and generated models) with the number of points.
double noise_of(double before, double deviation) {
  return std::sqrt(std::max(0.0, (4.0 * before * before - deviation * deviation) / 3.0));
}

double spacing_of(const std::vector<Neighbor>& found) {
  double sum = 0.0;
  for (std::size_t i = 1; i <= kSpacingNeighbors; ++i) sum += std::sqrt(found[i].squared_distance);
  return sum / static_cast<double>(kSpacingNeighbors);
}

}  // namespace

std::optional<PlaceNoise> NoiseMeter::at(Vec3 p, std::span<const Vec3> points, PlaceLimits limits,
                                         const Find& find) {
  constexpr std::size_t kNext = 4;  // as many as the next neighbourhoods have
  std::optional<PlaceNoise> measured;
  std::optional<double> before;
  found_.clear();
  for (std::size_t count = kFirstNeighborhood; count <= limits.most_points; count *= 2) {
    if (found_.size() <= count) find(std::min(kNext * count, limits.most_points), found_);
    if (found_.size() <= count) break;
    const double radius = std::sqrt(found_[count].squared_distance);
    if (radius > limits.reach) break;
    samples_.clear();
    for (std::size_t i = 0; i <= count; ++i)
      samples_.push_back({(points[found_[i].index] - p) / radius, 1.0});
    const auto deviation = deviation_of(samples_);
    if (deviation && before)
      measured = {.spacing = spacing_of(found_),
                  .noise = noise_of(*before, deviation->root_mean_square * radius),
                  .radius = radius,
                  .is_layer = deviation->root_mean_square * kLayer <= 1.0,
                  .nearest = std::sqrt(found_[1].squared_distance),
                  .kurtosis = deviation->kurtosis};
    if (measured && deviation->root_mean_square * kWide <= 1.0) break;
    before = deviation ? std::optional(deviation->root_mean_square * radius) : std::nullopt;
  }
  return measured;
}

}  // namespace orbweave
