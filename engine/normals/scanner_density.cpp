#include "engine/normals/scanner_density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "io/box.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

constexpr int kScanners = 4;
/// A density that is more even says nothing: from the middle of a ball it looks the same.
constexpr double kUneven = 0.15;
/// Places inside the bounds, about.
constexpr double kPlaces = 800.0;

/// Share of the area that no scanner need explain: shadows, and what stands before others.
constexpr double kUnexplained = 0.15;

/// What a scanner at a place makes of each sample's density, relative to the true one.
using Light = std::vector<double>;

using Lights = std::span<const double>;

double weighted(Lights weights, Lights a, Lights b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * a[i] * b[i];
  return sum;
}

/// Where scanners may stand, and what they light.
struct Stand {
  Box bounds;         ///< of the part
  double side = 1.0;  ///< 1: outside of the bounds, lighting the outside; -1: inside
  double step = 0.0;  ///< between places

  bool is_inside() const { return side < 0.0; }
};

class Fit {
 public:
  explicit Fit(std::span<const DensitySample> samples) : samples_(samples) {
    double area = 0.0;
    for (const DensitySample& s : samples) area += s.area;
    for (const DensitySample& s : samples) weights_.push_back(s.area / area);
  }

  double even() const {
    Light light;
    for (const DensitySample& s : samples_) light.push_back(s.area / s.points);
    const Light one(samples_.size(), 1.0);
    const double scale = weighted(weights_, light, one) / weighted(weights_, light, light);
    double left = 0.0;
    for (std::size_t i = 0; i < light.size(); ++i)
      left += weights_[i] * (1.0 - scale * light[i]) * (1.0 - scale * light[i]);
    return left;
  }

  /// What the best scanners leave: the best among some places, which are then moved.
  double best(std::span<const Vec3> places, const Stand& stand, const StopToken* stop) const {
    Light lights(places.size() * samples_.size());
    for_each_whole(places.size(), [&](std::size_t place) {
      check_stop(stop);
      set_light_from(places[place], stand.side,
                     std::span(lights).subspan(place * samples_.size(), samples_.size()));
    });
    Scanners chosen;
    Left left{Light(samples_.size(), 1.0), weights_};
    for (int k = 0; k < kScanners; ++k) {
      const std::optional<std::size_t> place = brightest(lights, left);
      if (!place) break;
      chosen.places.push_back(places[*place]);
      chosen.lights.push_back(of_unit_power(light_of(lights, *place), left.weights));
      left = explain(chosen.lights);
    }
    return moved(std::move(chosen), error_of(left), stand, stop);
  }

 private:
  struct Scanners {
    std::vector<Vec3> places;
    std::vector<Light> lights;
  };

  /// What scanners leave of 1, and what counts of it.
  struct Left {
    Light errors, weights;
  };

  Lights light_of(const Light& lights, std::size_t place) const {
    return Lights(lights).subspan(place * samples_.size(), samples_.size());
  }

  /// The place of the scanner which explains most of what is left; none where none explains any.
  std::optional<std::size_t> brightest(const Light& lights, const Left& left) const {
    Light wanted = left.errors;
    for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] *= left.weights[i];
    std::vector<double> gains(lights.size() / samples_.size());
    for_each_whole(gains.size(), [&](std::size_t place) {
      gains[place] = gain_of(light_of(lights, place), wanted, left.weights);
    });
    const auto best = std::max_element(gains.begin(), gains.end());
    if (best == gains.end() || !(*best > 0.0)) return std::nullopt;
    return static_cast<std::size_t>(best - gains.begin());
  }

  /// 0 where it explains none. Sums of every fourth sample, as wide as vectors are.
  static double gain_of(Lights light, Lights wanted, Lights weights) {
    constexpr std::size_t kLanes = 4;
    std::array<double, kLanes> power{}, gain{};
    const auto add = [&](std::size_t i, std::size_t lane) {
      power[lane] += weights[i] * light[i] * light[i];
      gain[lane] += wanted[i] * light[i];
    };
    std::size_t first = 0;
    for (; first + kLanes <= light.size(); first += kLanes)
      for (std::size_t lane = 0; lane < kLanes; ++lane) add(first + lane, lane);
    for (; first < light.size(); ++first) add(first, 0);
    const double all_power = (power[0] + power[1]) + (power[2] + power[3]);
    const double all_gain = (gain[0] + gain[1]) + (gain[2] + gain[3]);
    return all_power > 0.0 && all_gain > 0.0 ? all_gain / std::sqrt(all_power) : 0.0;
  }

  static Light of_unit_power(Lights light, Lights weights) {
    const double power = std::sqrt(weighted(weights, light, light));
    Light scaled(light.begin(), light.end());
    if (power > 0.0)
      for (double& value : scaled) value /= power;
    return scaled;
  }

  static double error_of(const Left& left) {
    return weighted(left.weights, left.errors, left.errors);
  }

  /// What scanners leave that are moved along the axes, by half of a step, a quarter and an eighth,
  /// as long as less is left. Places of a coarse lattice are off those of real scanners by as much
  /// as makes a wall before one of them another one.
  double moved(Scanners scanners, double error, const Stand& stand, const StopToken* stop) const {
    constexpr int kHalvings = 3;
    double step = stand.step;
    for (int halving = 0; halving < kHalvings; ++halving) {
      step *= 0.5;
      for (std::size_t k = 0; k < scanners.places.size(); ++k)
        for (int way = 0; way < 6; ++way) {
          check_stop(stop);
          Vec3 place = scanners.places[k];
          place[way / 2] += way % 2 == 0 ? step : -step;
          if (stand.bounds.contains(place) != stand.is_inside()) continue;
          Light light(samples_.size());
          set_light_from(place, stand.side, light);
          light = of_unit_power(light, weights_);
          std::swap(light, scanners.lights[k]);
          const double other = error_of(explain(scanners.lights));
          if (other < error) {
            error = other;
            scanners.places[k] = place;
          } else {
            std::swap(light, scanners.lights[k]);
          }
        }
    }
    return error;
  }

  void set_light_from(Vec3 place, double side, std::span<double> light) const {
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const DensitySample& s = samples_[i];
      const Vec3 to = place - s.position;
      const double squared = squared_norm(to);
      const double along = side * dot(s.normal, to);
      const bool is_seen = squared > 0.0 && along > 0.0;
      light[i] = is_seen ? along / (squared * std::sqrt(squared)) * s.area / s.points : 0.0;
    }
  }

  /// The best sum of lights, where the worst of the area need not be explained.
  Left explain(const std::vector<Light>& lights) const {
    constexpr int kTrims = 3;
    Left left{solve(lights, weights_), weights_};
    for (int trim = 0; trim < kTrims; ++trim) {
      left.weights = without_worst(left.errors);
      left.errors = solve(lights, left.weights);
    }
    return left;
  }

  Light without_worst(const Light& errors) const {
    std::vector<std::uint32_t> order(errors.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::abs(errors[a]) > std::abs(errors[b]);
    });
    Light weights = weights_;
    double dropped = 0.0;
    for (const std::uint32_t i : order) {
      if (dropped + weights_[i] > kUnexplained) break;
      dropped += weights_[i];
      weights[i] = 0.0;
    }
    for (double& weight : weights) weight /= 1.0 - dropped;
    return weights;
  }

  /// What is left of 1 by the best sum of lights with strengths that are not negative: coordinate
  /// descent on the normal equations.
  Light solve(const std::vector<Light>& lights, const Light& weights) const {
    constexpr int kRounds = 60;
    const std::size_t count = lights.size();
    const Light one(samples_.size(), 1.0);
    std::array<std::array<double, kScanners>, kScanners> shared{};
    std::array<double, kScanners> strength{}, wanted{};
    for (std::size_t k = 0; k < count; ++k) {
      wanted[k] = weighted(weights, lights[k], one);
      for (std::size_t l = 0; l <= k; ++l)
        shared[k][l] = shared[l][k] = weighted(weights, lights[k], lights[l]);
    }
    for (int round = 0; round < kRounds; ++round)
      for (std::size_t k = 0; k < count; ++k) {
        if (!(shared[k][k] > 0.0)) continue;
        double left = wanted[k];
        for (std::size_t l = 0; l < count; ++l) left -= shared[k][l] * strength[l];
        strength[k] = std::max(0.0, strength[k] + left / shared[k][k]);
      }
    Light left = one;
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t i = 0; i < left.size(); ++i) left[i] -= strength[k] * lights[k][i];
    return left;
  }

  std::span<const DensitySample> samples_;
  Light weights_;
};

/// The middles of a box's cells, whose sides are about `side`.
std::vector<Vec3> lattice(const Box& box, double side) {
  std::array<int, 3> cells{};
  for (int axis = 0; axis < 3; ++axis)
    cells[axis] = std::max(1, static_cast<int>(std::ceil((box.max[axis] - box.min[axis]) / side)));
  std::vector<Vec3> places;
  for (int i = 0; i < cells[0]; ++i)
    for (int j = 0; j < cells[1]; ++j)
      for (int k = 0; k < cells[2]; ++k) {
        const Vec3 share{(i + 0.5) / cells[0], (j + 0.5) / cells[1], (k + 0.5) / cells[2]};
        Vec3 place;
        for (int axis = 0; axis < 3; ++axis)
          place[axis] = box.min[axis] + share[axis] * (box.max[axis] - box.min[axis]);
        places.push_back(place);
      }
  return places;
}

/// Near the box as densely as inside, and farther off half as densely.
std::vector<Vec3> places_outside(const Box& box, double side) {
  const Vec3 extent = box.extent();
  std::array<double, 3> sorted = {extent.x, extent.y, extent.z};
  std::ranges::sort(sorted);
  std::vector<Vec3> places = lattice(box.grown(3.0 * side), side);
  const std::vector<Vec3> far = lattice(box.grown(sorted[1]), 2.0 * side);
  places.insert(places.end(), far.begin(), far.end());
  std::erase_if(places, [&](const Vec3& place) { return box.contains(place); });
  return places;
}

}  // namespace

bool DensityFit::is_seen_from_inside() const {
  constexpr double kExplained = 0.18, kBetter = 0.6, kFar = 0.35;
  return even > kUneven && inside < kExplained && inside < kFar * even &&
         inside < kBetter * outside;
}

bool DensityFit::may_be_seen_from_inside() const { return even > kUneven && inside <= outside; }

DensityFit fit_density(std::span<const DensitySample> samples, const StopToken* stop) {
  constexpr double kThinnest = 24.0;  // cells along the longest side
  DensityFit fit;
  Box box;
  for (const DensitySample& s : samples) box.extend(s.position);
  if (samples.size() < 2 || !(box.largest_extent() > 0.0)) return fit;
  const double longest = box.largest_extent();
  double volume = 1.0;
  for (int axis = 0; axis < 3; ++axis)
    volume *= std::max(box.extent()[axis], 1e-3 * longest) / longest;
  const double side = longest * std::max(std::cbrt(volume / kPlaces), 1.0 / kThinnest);
  const Fit search(samples);
  fit.even = search.even();
  if (!(fit.even > kUneven)) return fit;
  for_each_whole(2, [&](std::size_t k) {
    if (k == 0) fit.inside = search.best(lattice(box, side), {box, -1.0, side}, stop);
    if (k == 1) fit.outside = search.best(places_outside(box, side), {box, 1.0, side}, stop);
  });
  return fit;
}

}  // namespace orbweave
