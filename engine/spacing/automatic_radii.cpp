#include "engine/spacing/automatic_radii.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/geometry/symmetric_eigen.h"
#include "engine/spacing/neighbor_spread.h"
#include "engine/spacing/scan_lines.h"
#include "engine/spacing/site_points.h"

namespace orbweave {
namespace {

constexpr std::size_t kNeighbors = 6;
constexpr std::size_t kSurfaceNeighbors = 12;
/// Largest share of the variance that lies across a surface. A dozen points all through space have
/// 0.17 in the mean and a third at most, a dozen at an edge of a box 0.07 in the mean.
constexpr double kMostVariation = 0.1;
constexpr int kMostAutomaticLevels = 8;
/// Points that one thread takes at once, between two looks at the request to stop.
constexpr std::size_t kPlacesAtOnce = 256;
/// Farther from their neighbours than that, points are strays and not a sparse part.
constexpr double kFarthestPerMedian = 16.0;

struct Measured {
  double mean = 0.0;       ///< distance to the nearest neighbours, world units
  bool on_surface = true;  ///< as far as the nearest neighbours tell, where that was asked
};

struct Measuring {
  std::size_t neighbors = kNeighbors;
  bool judges_surface = false;
  bool only_sure = true;  ///< only points whose neighbours are all in the site for certain
  const StopToken* stop = nullptr;
};

/// To the first `count` neighbours of a place, which has as many.
double mean_distance(std::span<const Neighbor> nearest, std::size_t count) {
  double sum = 0.0;
  for (std::size_t k = 1; k <= count; ++k) sum += std::sqrt(nearest[k].squared_distance);
  return sum / static_cast<double>(count);
}

/// Judges whether points and their nearest neighbours lie about a surface rather than all through
/// space, as leaves do. Pauly, Gross, Kobbelt: Efficient Simplification of Point-Sampled Surfaces,
/// 2002, section 2.1. Four at a time.
class SurfaceJudge {
 public:
  /// `spread` of the neighbourhood of what is measured, which is judged later.
  void add(const SymmetricMatrix& spread, Measured& measured) {
    spreads_[waiting_] = spread;
    measured_[waiting_] = &measured;
    if (++waiting_ == spreads_.size()) judge();
  }
  /// What waits.
  void judge() {
    const auto eigen = eigen_of_four(spreads_);
    for (std::size_t i = 0; i < waiting_; ++i) {
      const auto [across, along, longest] = eigen[i].values;
      measured_[i]->on_surface = across <= kMostVariation * (across + along + longest);
    }
    waiting_ = 0;
  }

 private:
  std::array<SymmetricMatrix, 4> spreads_;
  std::array<Measured*, 4> measured_{};
  std::size_t waiting_ = 0;
};

/// At the places of a sample that are sure, ascending by the mean distance.
std::vector<Measured> measure(const SampledNeighbors& sample, const Measuring& measuring) {
  constexpr double kUnsure = -1.0;
  std::vector<Measured> all(sample.size(), {kUnsure});
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, sample.size(), kPlacesAtOnce), [&](const Range& range) {
    check_stop(measuring.stop);
    SurfaceJudge judge;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const auto [site, point, nearest] = sample.at(i);
      const std::size_t count = std::min(measuring.neighbors, nearest.size() - 1);
      const double reach = std::sqrt(nearest[count].squared_distance);
      if (measuring.only_sure && reach > distance_to_border(site.points[point], site.box)) continue;
      all[i].mean = mean_distance(nearest, count);
      if (!measuring.judges_surface) continue;
      const std::size_t around = std::min(kSurfaceNeighbors + 1, nearest.size());
      judge.add(spread_of(site.points, nearest.first(around)), all[i]);
    }
    judge.judge();
  });
  std::erase_if(all, [](const Measured& m) { return m.mean == kUnsure; });
  std::sort(all.begin(), all.end(),
            [](const Measured& a, const Measured& b) { return a.mean < b.mean; });
  return all;
}

/// At points whose neighbours are all in a site for certain, or else at any.
std::vector<Measured> measure_somewhere(const SampledNeighbors& sample, Measuring measuring) {
  std::vector<Measured> all = measure(sample, measuring);
  measuring.only_sure = false;
  return all.empty() ? measure(sample, measuring) : all;
}

/// What a ball has to span where points lie on lines: it touches two lines from somewhat more than
/// half of what lies between them on.
constexpr double kSpacingPerGap = 0.55;

/// As measure(), of points on lines.
std::vector<Measured> measure_lines(const SampledNeighbors& sample,
                                    const std::vector<LinePlace>& lines) {
  std::vector<Measured> all;
  for (const LinePlace& line : lines) {
    const auto nearest = sample.at(line.place).nearest;
    const double mean = mean_distance(nearest, std::min(kNeighbors, nearest.size() - 1));
    all.push_back({std::max(mean, kSpacingPerGap * line.across)});
  }
  std::sort(all.begin(), all.end(),
            [](const Measured& a, const Measured& b) { return a.mean < b.mean; });
  return all;
}

double quantile(const std::vector<Measured>& sorted, std::size_t percent) {
  return sorted[(sorted.size() - 1) * percent / 100].mean;
}

/// The farthest that a point may be from its neighbours without being a stray.
double farthest(const std::vector<Measured>& measured) {
  return kFarthestPerMedian * quantile(measured, 50);
}

/// What a ball must span for all but a tenth of the surface. (A part a hundred times sparser than
/// the rest holds hardly any points. A tree's leaves take up much room, and are no surface.)
double spacing_by_area(const std::vector<Measured>& measured) {
  const double far = farthest(measured);
  const auto counts = [&](const Measured& m) { return m.on_surface && m.mean <= far; };
  double area = 0.0, below = 0.0;
  for (const Measured& m : measured)
    if (counts(m)) area += m.mean * m.mean;
  double by_area = quantile(measured, 50);
  for (const Measured& m : measured) {
    if (!counts(m)) continue;
    below += m.mean * m.mean;
    if (below > 0.9 * area) break;
    by_area = m.mean;
  }
  return by_area;
}

/// What the largest ball must span: all but a fiftieth of the points as well.
double sparse_spacing(const std::vector<Measured>& measured) {
  return std::max(spacing_by_area(measured), std::min(farthest(measured), quantile(measured, 98)));
}

/// How far a point lies off the plane that fits other points best.
double offset_from_plane(std::span<const Vec3> points, std::uint32_t point,
                         std::span<const Neighbor> others) {
  const Vec3 origin = points[point];
  Vec3 center;
  for (const Neighbor& n : others) center = center + (points[n.index] - origin);
  center = center / static_cast<double>(others.size());
  SymmetricMatrix spread;
  for (const Neighbor& n : others) spread += outer(points[n.index] - origin - center);
  return std::abs(dot(center, eigen_of(spread).vectors[0]));
}

/// See RadiiChoice.
double sparse_offset(const SampledNeighbors& sample, double spacing, const StopToken* stop) {
  constexpr double kSparse = kRadiusGrowth * kRadiusGrowth;
  constexpr std::size_t kFewest = 16;
  std::vector<double> offsets;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    if (i % kPlacesAtOnce == 0) check_stop(stop);
    const auto [site, point, nearest] = sample.at(i);
    if (nearest.size() <= kSurfaceNeighbors) continue;
    const double mean = mean_distance(nearest, kNeighbors);
    if (mean <= kSparse * spacing) continue;
    const auto others = nearest.subspan(1, kSurfaceNeighbors);
    offsets.push_back(offset_from_plane(site.points, point, others) / mean);
  }
  if (offsets.size() < kFewest) return 0.0;
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return *middle;
}

/// One where a step of growth would reach the sparse parts, else as many as lead there.
int levels_for(double spacing, double sparse) {
  if (sparse <= kRadiusGrowth * spacing) return 1;
  int levels = 1;
  for (double reach = spacing; reach < sparse && levels < kMostAutomaticLevels; ++levels)
    reach *= kRadiusGrowth;
  return levels;
}

std::string density_reason(const std::vector<Measured>& measured, int levels) {
  const double sparse = sparse_spacing(measured);
  const std::string times = short_text(sparse / quantile(measured, 50)) + " times the median";
  if (levels == 1)
    return "; the sparser parts have " + short_text(sparse) + ", " + times +
           ", which one radius serves";
  return "; the sparser parts have " + short_text(sparse) + ", " + times + ", to which " +
         std::to_string(levels) + " levels lead";
}

std::string reason_of(const RadiiChoice& choice, const std::vector<Measured>& measured,
                      std::uint64_t points, bool on_lines) {
  const bool lone = choice.radii.size() == 1;
  const double sparse = quantile(measured, 95);
  std::string measure =
      "the mean distance to the " + std::to_string(kNeighbors) + " nearest neighbours";
  if (on_lines)
    measure = "the points lie on scan lines farther apart than the points on them; the larger of " +
              measure + " and " + short_text(kSpacingPerGap) + " of the distance to the next line";
  std::string reason = measure + ", measured at " + std::to_string(measured.size()) + " of " +
                       std::to_string(points) + " points, has the median " +
                       short_text(choice.spacing) + " and the ninth decile " +
                       short_text(quantile(measured, 90)) + "; the radius is " +
                       short_text(kRadiusPerSpacing) + " times the " + (lone ? "latter" : "former");
  if (!lone) reason += " and then grows by " + short_text(kRadiusGrowth) + " from level to level";
  if (sparse > choice.radii.back())
    reason += "; one point in twenty is more than " + short_text(sparse) +
              " from its neighbours and may need a larger radius";
  return reason;
}

}  // namespace

std::size_t neighbors_for_radii() { return kSurfaceNeighbors; }

std::vector<double> neighbor_distances(const SampledNeighbors& sample, std::size_t neighbors,
                                       const StopToken* stop) {
  std::vector<double> means;
  for (const Measured& m : measure_somewhere(sample, {.neighbors = neighbors, .stop = stop}))
    means.push_back(m.mean);
  return means;
}

RadiiChoice choose_radii(const SampledNeighbors& sample, std::uint64_t points, int levels,
                         const StopToken* stop) {
  const bool by_density = levels == 0;
  RadiiChoice choice;
  const std::vector<LinePlace> lines = find_scan_lines(sample, stop);
  const std::vector<Measured> measured =
      lines.empty() ? measure_somewhere(sample, {.judges_surface = true, .stop = stop})
                    : measure_lines(sample, lines);
  if (measured.empty()) {
    choice.reason = points < 2 ? "there are fewer than two points"
                               : "no two different points were found near one another";
    return choice;
  }
  choice.line_neighbors = neighbors_across_lines(lines);
  choice.spacing = quantile(measured, 50);
  if (by_density) levels = levels_for(choice.spacing, sparse_spacing(measured));
  double ball_radius = kRadiusPerSpacing * (levels == 1 ? quantile(measured, 90) : choice.spacing);
  for (int level = 0; level < levels; ++level) {
    choice.radii.push_back(ball_radius);
    ball_radius *= kRadiusGrowth;
  }
  choice.reason = reason_of(choice, measured, points, !lines.empty());
  choice.spacing_by_area = spacing_by_area(measured);
  if (!by_density) return choice;
  choice.reason += density_reason(measured, levels);
  constexpr int kManyLevels = 3;
  if (levels >= kManyLevels) choice.sparse_offset = sparse_offset(sample, choice.spacing, stop);
  return choice;
}

}  // namespace orbweave
