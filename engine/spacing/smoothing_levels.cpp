#include "engine/spacing/smoothing_levels.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/geometry/lattice_cube.h"
#include "engine/spacing/place_noise.h"

namespace orbweave {
namespace {

/// Of thick layers: a projection averages over some 40 points, more where the layers are thicker.
constexpr double kRadiusPerSpacing = 3.75;
constexpr double kRadiusPerThickness = 12.0;
/// Of very thick layers: the mean of a neighbourhood of radius r is off by 1.4 noise spacing / r,
/// which is to be a fourteenth of the spacing r / 4 that thinning keeps. More would flatten the
/// shape.
constexpr double kRadiusPerRoot = 8.8;
constexpr double kStep = 2.0;
/// A radius is up to a fifth shorter than what is asked for, or longer.
constexpr double kShorter = 1.2;
/// Steps up and down from the radius of the whole cloud.
constexpr int kMostStepsUp = 5, kMostStepsDown = 6;
/// Edges, furniture and leaves look like noise, and the smoother places around them tell how far
/// smoothing has to reach: a third of the places has no more noise than that.
constexpr double kSmooth = 0.35;
constexpr double kAbove = 1.001;  // the limit of thick layers, surely
/// Sparse places ask for a larger radius than the whole cloud where noise is this much above the
/// limit. Where it is near the limit, as far from a tripod whose noise is the same everywhere, a
/// larger radius flattened rims of windows and closed what they show as gaps.
constexpr double kCrumpled = 1.5 * kThickPerSpacing;
/// Cubes on each side of one whose places count for it.
constexpr std::int64_t kReach = 2;
constexpr std::size_t kCubesAtOnce = 256;
constexpr std::size_t kPointsAtOnce = 4096;

double quantile_of(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median_of(std::vector<double>& values) { return quantile_of(values, 0.5); }

/// What the noise alone asks for.
double radius_of_noise(double spacing, double noise) {
  return std::min(kRadiusPerThickness * noise, kRadiusPerRoot * std::sqrt(noise * spacing));
}

}  // namespace

double wanted_radius(double spacing, double noise) {
  if (!(noise > kThickPerSpacing * spacing)) return 0.0;
  return std::max(kRadiusPerSpacing * spacing, radius_of_noise(spacing, noise));
}

SmoothingLevels::SmoothingLevels(std::vector<NoisePlace> places, double cell,
                                 const WholeCloudNoise& whole, const StopToken* stop)
    : cell_(cell), whole_(whole) {
  sort_by_cubes(std::move(places));
  std::vector<LatticeCell> cells = cell_of_place_;
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  cubes_.resize(cells.size());
  std::vector<double> radius_of_cube(cells.size());
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, cells.size(), kCubesAtOnce), [&](const Range& range) {
    check_stop(stop);
    Scratch scratch;
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      radius_of_cube[i] = measure(cells[i], scratch, cubes_[i]);
  });
  number_levels(radius_of_cube);
}

void SmoothingLevels::sort_by_cubes(std::vector<NoisePlace> places) {
  struct PlaceInCube {
    LatticeCell cube;
    NoisePlace place;
    bool operator<(const PlaceInCube& other) const {
      const Vec3 p = place.position, q = other.place.position;
      return std::tie(cube, p.x, p.y, p.z, place.spacing, place.noise) <
             std::tie(other.cube, q.x, q.y, q.z, other.place.spacing, other.place.noise);
    }
  };
  std::vector<PlaceInCube> sorted(places.size());
  std::transform(places.begin(), places.end(), sorted.begin(), [this](const NoisePlace& place) {
    return PlaceInCube{cube_of(place.position, cell_), place};
  });
  tbb::parallel_sort(sorted.begin(), sorted.end());
  for (const PlaceInCube& each : sorted) {
    cell_of_place_.push_back(each.cube);
    places_.push_back(each.place);
  }
}

double SmoothingLevels::measure(const LatticeCell& cell, Scratch& scratch, Cube& cube) const {
  scratch.spacings.clear();
  scratch.noises.clear();
  std::size_t volumes = 0;
  for (std::int64_t z = cell.z - kReach; z <= cell.z + kReach; ++z)
    for (std::int64_t y = cell.y - kReach; y <= cell.y + kReach; ++y) {
      const LatticeCell first{z, y, cell.x - kReach}, last{z, y, cell.x + kReach};
      auto at = std::lower_bound(cell_of_place_.begin(), cell_of_place_.end(), first);
      for (; at != cell_of_place_.end() && !(last < *at); ++at) {
        const NoisePlace& place = places_[static_cast<std::size_t>(at - cell_of_place_.begin())];
        if (!(place.spacing > 0.0)) continue;
        scratch.spacings.push_back(place.spacing);
        if (place.noise < 0.0)
          ++volumes;
        else
          scratch.noises.push_back(place.noise);
      }
    }
  cube = {cell, {}, 0};
  if (scratch.spacings.empty()) return 0.0;
  const double spacing = median_of(scratch.spacings);
  cube.noise.spacing = static_cast<float>(spacing);
  if (2 * volumes >= scratch.spacings.size()) return whole_.is_thick ? whole_.radius : 0.0;
  const double noise = median_of(scratch.noises);
  cube.noise.noise = static_cast<float>(noise);
  const double thin = kThickPerSpacing * spacing;
  if (!(noise > thin)) return 0.0;
  const double least = std::max(quantile_of(scratch.noises, kSmooth), kAbove * thin);
  const double most = least > kCrumpled * spacing
                          ? wanted_radius(spacing, least)
                          : std::max(whole_.radius, radius_of_noise(spacing, least));
  return step_of(std::min(wanted_radius(spacing, least), most));
}

double SmoothingLevels::step_of(double wanted) const {
  if (whole_.most > 0.0) wanted = std::min(wanted, whole_.most);
  double radius = whole_.radius;
  for (int up = 0; up < kMostStepsUp && wanted > kShorter * radius; ++up) radius *= kStep;
  for (int down = 0; down < kMostStepsDown && kStep * wanted < kShorter * radius; ++down)
    radius /= kStep;
  return radius;
}

void SmoothingLevels::number_levels(const std::vector<double>& radius_of_cube) {
  radii_ = radius_of_cube;
  radii_.push_back(0.0);
  std::sort(radii_.begin(), radii_.end());
  radii_.erase(std::unique(radii_.begin(), radii_.end()), radii_.end());
  for (std::size_t i = 0; i < cubes_.size(); ++i) cubes_[i].level = level_of(radius_of_cube[i]);
}

/// The level of the largest radius that is no larger.
std::uint8_t SmoothingLevels::level_of(double radius) const {
  const auto after = std::upper_bound(radii_.begin(), radii_.end(), radius);
  return static_cast<std::uint8_t>(after - radii_.begin() - 1);
}

double SmoothingLevels::untouched_share() const {
  if (cubes_.empty()) return 1.0;
  const auto untouched =
      std::count_if(cubes_.begin(), cubes_.end(), [](const Cube& cube) { return cube.level == 0; });
  return static_cast<double>(untouched) / static_cast<double>(cubes_.size());
}

/// Points that follow each other often lie in one cube.
template <class Visit>
void SmoothingLevels::visit_cubes(std::span<const Vec3> positions, const Visit& visit) const {
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, positions.size(), kPointsAtOnce), [&](const Range& range) {
    Scratch scratch;
    Cube cube;
    bool is_known = false;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const LatticeCell cell = cube_of(positions[i], cell_);
      if (!is_known || cell != cube.cell) cube = cube_at(cell, scratch);
      is_known = true;
      visit(i, cube);
    }
  });
}

SmoothingLevels::Cube SmoothingLevels::cube_at(const LatticeCell& cell, Scratch& scratch) const {
  const auto comes_before = [](const Cube& cube, const LatticeCell& wanted) {
    return cube.cell < wanted;
  };
  const auto found = std::lower_bound(cubes_.begin(), cubes_.end(), cell, comes_before);
  if (found != cubes_.end() && found->cell == cell) return *found;
  // A point that was moved may be the only one in its cube.
  Cube cube;
  cube.level = level_of(measure(cell, scratch, cube));
  return cube;
}

std::vector<std::uint8_t> SmoothingLevels::at(std::span<const Vec3> positions) const {
  std::vector<std::uint8_t> levels(positions.size(), 0);
  if (radii_.size() > 1)
    visit_cubes(positions, [&](std::size_t i, const Cube& cube) { levels[i] = cube.level; });
  return levels;
}

std::vector<LocalNoise> SmoothingLevels::noise_at(std::span<const Vec3> positions) const {
  std::vector<LocalNoise> noise(positions.size());
  visit_cubes(positions, [&](std::size_t i, const Cube& cube) { noise[i] = cube.noise; });
  return noise;
}

}  // namespace orbweave
