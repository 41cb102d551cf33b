#include "engine/spacing/layer_thickness.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/geometry/local_surface.h"
#include "engine/geometry/point_tree.h"
#include "engine/spacing/site_points.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kMeasuredPoints = 4096;
constexpr std::size_t kSpacingNeighbors = 6;
/// Points of the first neighbourhood; each further one has twice as many, which is 1.4 times the
/// radius on a surface.
constexpr std::size_t kFirstNeighborhood = 12;
constexpr std::size_t kLargestNeighborhood = 1536;
/// A neighbourhood is wide when its radius is at least this multiple of the deviation in it. (A
/// ball filled evenly has 2.2.)
constexpr double kWide = 6.0;
/// Above this multiple of the spacing, balls that roll over the layers find points in their way: a
/// torus with noise of 0.1 spacings still closes (0.084 are measured there), one of 0.2 does not.
constexpr double kThick = 0.09;
/// Numbers of a quadratic surface and of its plane that are fitted.
constexpr double kFitted = 6.0;

/// Of thick layers: a projection averages over some 40 points, more where the layers are thicker.
constexpr double kRadiusPerSpacingOfLayers = 3.75;
constexpr double kRadiusPerThickness = 12.0;
/// What was averaged over can be told by far fewer points.
constexpr double kThinningPerRadius = 0.25;
constexpr double kOutlierSigma = 4.0;

struct Measured {
  double spacing = 0.0;
  double deviation = 0.0;
  double radius = 0.0;
};

/// Root of the mean squared distance of the samples from their local surface, in radii.
std::optional<double> deviation_of(const std::vector<SurfaceSample>& samples) {
  const auto surface = fit_surface(samples, {});
  if (!surface) return std::nullopt;
  double sum = 0.0;
  for (const SurfaceSample& sample : samples) {
    const double off = surface->distance_above(sample.offset);
    sum += off * off;
  }
  return std::sqrt(sum / (static_cast<double>(samples.size()) - kFitted));
}

/// Measures around the points of one site, which `tree` holds; one for each thread.
class SiteMeasure {
 public:
  SiteMeasure(const SpacingSite& site, const PointTree& tree) : site_(site), tree_(tree) {}

  /// With `only_sure`: nothing where a neighbourhood could reach out of the site before it is wide.
  std::optional<Measured> at(Vec3 p, bool only_sure) {
    const double border = distance_to_border(p, site_.box);
    std::optional<Measured> measured;
    std::optional<double> before;
    found_.clear();
    for (std::size_t count = kFirstNeighborhood; count <= kLargestNeighborhood; count *= 2) {
      if (found_.size() <= count) find(p, count);
      if (found_.size() <= count) break;
      const double radius = std::sqrt(found_[count].squared_distance);
      if (only_sure && radius > border) break;
      collect(p, radius, count);
      const auto deviation = deviation_of(samples_);
      if (deviation && before) measured = {spacing(), noise(*before, *deviation * radius), radius};
      if (measured && *deviation * kWide <= 1.0) break;
      before = deviation ? std::optional(*deviation * radius) : std::nullopt;
    }
    return measured;
  }

 private:
  /// The point and at least `count` others, and as many as the next neighbourhoods have.
  void find(Vec3 p, std::size_t count) {
    constexpr std::size_t kNext = 4;
    tree_.nearest(p, std::min(kNext * count, kLargestNeighborhood) + 1, found_);
  }
  void collect(Vec3 p, double radius, std::size_t count) {
    samples_.clear();
    for (std::size_t i = 0; i <= count; ++i)
      samples_.push_back({(site_.points[found_[i].index] - p) / radius, 1.0});
  }
  /// Noise is the same in both neighbourhoods; what the surface is finer than a quadric doubles
  /// (measured on scanned and generated models) with the number of points.
  static double noise(double before, double deviation) {
    return std::sqrt(std::max(0.0, (4.0 * before * before - deviation * deviation) / 3.0));
  }
  double spacing() const {
    double sum = 0.0;
    for (std::size_t i = 1; i <= kSpacingNeighbors; ++i)
      sum += std::sqrt(found_[i].squared_distance);
    return sum / static_cast<double>(kSpacingNeighbors);
  }

  const SpacingSite& site_;
  const PointTree& tree_;
  std::vector<Neighbor> found_;
  std::vector<SurfaceSample> samples_;
};

/// Places that one thread takes at once, between two looks at the request to stop: a quadric is
/// fitted several times at each.
constexpr std::size_t kPlacesAtOnce = 64;

/// What is measured at the selected points of a site, in their order.
std::vector<Measured> measure_site(const SpacingSite& site, PointSelection selection,
                                   bool only_sure, const StopToken* stop) {
  std::vector<Vec3> places;
  for (const Vec3& p : site.points)
    if (site.core.contains(p) && selection.takes(p)) places.push_back(p);
  if (places.empty() || site.points.size() <= kFirstNeighborhood) return {};
  const PointTree tree(site.points);
  std::vector<std::optional<Measured>> at_place(places.size());
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, places.size(), kPlacesAtOnce), [&](const Range& range) {
    check_stop(stop);
    SiteMeasure measure(site, tree);
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      at_place[i] = measure.at(places[i], only_sure);
  });
  std::vector<Measured> measured;
  for (const std::optional<Measured>& one : at_place)
    if (one) measured.push_back(*one);
  return measured;
}

std::vector<Measured> measure_all(std::span<const SpacingSite> sites, bool only_sure,
                                  const StopToken* stop) {
  const PointSelection selection = select_points(sites, kMeasuredPoints);
  std::vector<std::vector<Measured>> of_site(sites.size());
  tbb::parallel_for(std::size_t{0}, sites.size(), [&](std::size_t i) {
    of_site[i] = measure_site(sites[i], selection, only_sure, stop);
  });
  std::vector<Measured> all;
  for (const auto& part : of_site) all.insert(all.end(), part.begin(), part.end());
  return all;
}

double median(const std::vector<Measured>& all, double Measured::*member) {
  std::vector<double> values;
  for (const Measured& one : all) values.push_back(one.*member);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

bool LayerThickness::is_thick() const { return thickness > kThick * spacing; }

LayerThickness measure_layers(std::span<const SpacingSite> sites, const StopToken* stop) {
  const DistinctSites distinct(sites, stop);
  std::vector<Measured> all = measure_all(distinct.all(), true, stop);
  if (all.empty()) all = measure_all(distinct.all(), false, stop);
  LayerThickness layers;
  layers.measured = all.size();
  if (all.empty()) return layers;
  layers.thickness = median(all, &Measured::deviation);
  layers.spacing = median(all, &Measured::spacing);
  layers.radius = median(all, &Measured::radius);
  return layers;
}

namespace {

std::string brief_length(double value, double meters_per_unit) {
  const Length length = readable_length(value, meters_per_unit);
  return brief_text(length.value) + length.unit;
}

}  // namespace

std::string short_noise(const LayerThickness& layers, double meters_per_unit) {
  if (layers.measured == 0) return "too few points to measure the noise";
  const double percent = 100.0 * layers.thickness / layers.spacing;
  const double limit = 100.0 * kThick;
  // A share beside the limit keeps its digits: 8.97 % is not "9 %; below 9 %".
  const std::string share =
      std::abs(percent - limit) < 0.5 ? short_text(percent) : short_text(std::round(percent));
  return "noise " + brief_length(layers.thickness, meters_per_unit) + " RMS, " + share +
         " % of the point spacing (" + brief_length(layers.spacing, meters_per_unit) + "); " +
         (layers.is_thick() ? "above " : "below ") + short_text(limit) + " %";
}

std::string short_reason(const LayerThickness& layers, double meters_per_unit) {
  const CleaningChoice choice = choose_cleaning(layers);
  const std::string noise = short_noise(layers, meters_per_unit);
  if (layers.measured == 0) return noise + ": no cleaning";
  if (!layers.is_thick()) return noise + ": no cleaning needed";
  return noise + ": outliers dropped, " + std::to_string(choice.smooth_passes) +
         " smoothing passes, thinned to " + brief_length(choice.thin_to_spacing, meters_per_unit);
}

CleaningChoice choose_cleaning(const LayerThickness& layers) {
  CleaningChoice choice;
  if (layers.measured == 0) {
    choice.reason = "too few points to measure the noise: no cleaning";
    return choice;
  }
  const auto percent = [](double share) { return short_text(100.0 * share) + " %"; };
  const std::string noise = "noise " + short_text(layers.thickness) + " RMS, " +
                            percent(layers.thickness / layers.spacing) + " of the point spacing (" +
                            short_text(layers.spacing) + "); ";
  if (!layers.is_thick()) {
    choice.reason = noise + "up to " + percent(kThick) + ": no cleaning needed";
    return choice;
  }
  choice.outlier_sigma = kOutlierSigma;
  choice.smooth_radius =
      std::max(kRadiusPerSpacingOfLayers * layers.spacing, kRadiusPerThickness * layers.thickness);
  choice.thin_to_spacing = kThinningPerRadius * choice.smooth_radius;
  choice.reason =
      noise + "above " + percent(kThick) + ": outliers beyond " + short_text(choice.outlier_sigma) +
      " standard deviations dropped, " + std::to_string(choice.smooth_passes) +
      " smoothing passes of radius " + short_text(choice.smooth_radius) + " (" +
      short_text(choice.smooth_radius / layers.spacing) +
      " point spacings), thinning to a spacing of " + short_text(choice.thin_to_spacing);
  return choice;
}

}  // namespace orbweave
