#include "engine/spacing/layer_thickness.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/spacing/place_noise.h"
#include "engine/spacing/site_points.h"

namespace orbweave {
namespace {

/// The noise is measured at one of so many points, within limits: medians of more places are no
/// better, and those of fewer are uncertain.
constexpr std::uint64_t kPointsPerPlace = 16;
constexpr std::uint64_t kFewestPlaces = 1024, kMostPlaces = 4096;

/// Of the places of a site, that part is looked at first, and so many at least.
constexpr std::size_t kFirstLookPart = 8, kFirstLookPlaces = 256;
/// Where fewer of these lie on a surface, points fill the site: every further place would cost the
/// widest neighbourhood to say the same.
constexpr double kFilledPart = 0.05;

constexpr double kOutlierSigma = 4.0;
constexpr std::uint64_t kClusterPoints = 16;
/// Side of a cube in which noise is measured, in spacings.
constexpr double kSpacingsPerCell = 24.0;
/// Layers that are thick in so large a part of the places are cleaned there. (Edges and corners
/// look like noise, and are a smaller part.)
constexpr double kThickPart = 0.05;

/// What was measured at a place of the cloud.
struct Measured : PlaceNoise {
  Vec3 position;
};

/// Places that one thread takes at once, between two looks at the request to stop: a quadric is
/// fitted several times at each.
constexpr std::size_t kPlacesAtOnce = 64;

/// Places of a site, in their order, and which of them are looked at first.
struct Places {
  std::vector<std::uint32_t> points;  ///< of the site
  std::vector<std::size_t> first;
  std::vector<std::size_t> others;
};

/// The first are chosen by hash as well.
Places places_of(const SpacingSite& site, PointSelection selection) {
  Places places;
  for (std::uint32_t i = 0; i < site.points.size(); ++i)
    if (site.core.contains(site.points[i]) && selection.takes(site.points[i]))
      places.points.push_back(i);
  const std::size_t count = places.points.size();
  const std::size_t wanted = std::max(count / kFirstLookPart, kFirstLookPlaces);
  if (wanted < count) selection.last = selection.last / count * wanted;
  for (std::size_t i = 0; i < count; ++i)
    (selection.takes(site.points[places.points[i]]) ? places.first : places.others).push_back(i);
  return places;
}

using AtPlaces = std::vector<std::optional<PlaceNoise>>;

/// Whether hardly any of many places lies on a surface.
bool is_filled(const AtPlaces& at_place) {
  std::size_t measured = 0, layers = 0;
  for (const auto& place : at_place) {
    measured += place ? 1 : 0;
    layers += place && place->is_layer ? 1 : 0;
  }
  return measured >= kFirstLookPlaces / 2 &&
         static_cast<double>(layers) < kFilledPart * static_cast<double>(measured);
}

/// What is measured at the selected points of a site, in their order; at some of them where points
/// fill the site. With `only_sure`: nothing where a neighbourhood could reach out of the site
/// before it is wide.
std::vector<Measured> measure_site(const SpacingSite& site, const SiteSearch& search,
                                   PointSelection selection, bool only_sure,
                                   const StopToken* stop) {
  Places places = places_of(site, selection);
  if (places.points.empty()) return {};
  AtPlaces at_place(places.points.size());
  const auto measure_at = [&](NoiseMeter& meter, SiteSearch::Query& query, std::size_t i) {
    const Vec3 p = site.points[places.points[i]];
    constexpr double kAnywhere = std::numeric_limits<double>::infinity();
    const double reach = only_sure ? distance_to_border(p, site.box) : kAnywhere;
    const auto find = [&](std::size_t count, std::vector<Neighbor>& found) {
      query.nearest(search, places.points[i], count + 1, found);
    };
    at_place[i] = meter.at(p, site.points, {.reach = reach}, find);
  };
  using Range = tbb::blocked_range<std::size_t>;
  const auto measure_all_of = [&](const std::vector<std::size_t>& chosen) {
    tbb::parallel_for(Range(0, chosen.size(), kPlacesAtOnce), [&](const Range& range) {
      check_stop(stop);
      NoiseMeter meter;
      SiteSearch::Query query;
      for (std::size_t k = range.begin(); k < range.end(); ++k) measure_at(meter, query, chosen[k]);
    });
  };
  const auto comes_before = [&](std::size_t a, std::size_t b) {
    return search.rank(places.points[a]) < search.rank(places.points[b]);
  };
  std::sort(places.first.begin(), places.first.end(), comes_before);
  std::sort(places.others.begin(), places.others.end(), comes_before);
  measure_all_of(places.first);
  if (!is_filled(at_place)) measure_all_of(places.others);
  std::vector<Measured> measured;
  for (std::size_t i = 0; i < at_place.size(); ++i)
    if (at_place[i]) measured.push_back({*at_place[i], site.points[places.points[i]]});
  return measured;
}

std::vector<Measured> measure_all(const SearchedSites& sites, bool only_sure,
                                  const StopToken* stop) {
  const std::uint64_t wanted =
      std::clamp(points_of(sites.all()) / kPointsPerPlace, kFewestPlaces, kMostPlaces);
  const PointSelection selection = select_points(sites.all(), wanted);
  std::vector<std::vector<Measured>> of_site(sites.all().size());
  tbb::parallel_for(std::size_t{0}, of_site.size(), [&](std::size_t i) {
    of_site[i] = measure_site(sites.all()[i], sites.search(i), selection, only_sure, stop);
  });
  std::vector<Measured> all;
  for (const auto& part : of_site) all.insert(all.end(), part.begin(), part.end());
  return all;
}

double median(const std::vector<Measured>& all, double PlaceNoise::*member) {
  std::vector<double> values;
  for (const Measured& one : all) values.push_back(one.*member);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Where the layers are thick, and how far smoothing has to reach there.
void measure_parts(const std::vector<Measured>& all, LayerThickness& layers,
                   const StopToken* stop) {
  if (!(layers.spacing > 0.0)) return;
  std::vector<NoisePlace> places;
  for (const Measured& one : all)
    places.push_back({one.position, one.spacing, one.is_layer ? one.noise : -1.0});
  const SmoothingLevels levels(std::move(places), noise_cell(layers), whole_cloud_noise(layers),
                               stop);
  layers.thick_share = 1.0 - levels.untouched_share();
  layers.largest_radius = levels.radii().back();
}

/// Places of two sharp layers, and of points that lie beside another one.
void count_doubles(const std::vector<Measured>& all, LayerThickness& layers) {
  constexpr double kSharp = 1.5, kTwinPerSpacing = 0.05;
  std::vector<double> gaps;
  std::size_t twins = 0;
  for (const Measured& one : all) {
    if (one.nearest < kTwinPerSpacing * one.spacing) ++twins;
    // Two sharp layers deviate from their middle by half of what lies between them.
    if (one.is_layer && one.kurtosis < kSharp && one.noise > kThickPerSpacing * one.spacing)
      gaps.push_back(2.0 * one.noise);
  }
  const auto count = static_cast<double>(all.size());
  layers.twin_share = static_cast<double>(twins) / count;
  layers.double_share = static_cast<double>(gaps.size()) / count;
  if (gaps.empty()) return;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  layers.gap = *middle;
}

}  // namespace

double noise_cell(const LayerThickness& layers) { return kSpacingsPerCell * layers.spacing; }

WholeCloudNoise whole_cloud_noise(const LayerThickness& layers) {
  const bool is_thick = layers.is_thick();
  // At the limit, the noise asks for no more than the spacing does.
  const double noise = std::max(layers.thickness, 1.001 * kThickPerSpacing * layers.spacing);
  return {wanted_radius(layers.spacing, noise), is_thick, layers.largest_radius};
}

bool LayerThickness::is_thick_somewhere() const { return is_thick() || thick_share >= kThickPart; }

bool LayerThickness::is_thick() const { return thickness > kThickPerSpacing * spacing; }

LayerThickness measure_layers(const SearchedSites& sites, const StopToken* stop) {
  std::vector<Measured> all = measure_all(sites, true, stop);
  if (all.empty()) all = measure_all(sites, false, stop);
  LayerThickness layers;
  layers.measured = all.size();
  if (all.empty()) return layers;
  layers.thickness = median(all, &PlaceNoise::noise);
  layers.spacing = median(all, &PlaceNoise::spacing);
  layers.radius = median(all, &PlaceNoise::radius);
  measure_parts(all, layers, stop);
  count_doubles(all, layers);
  return layers;
}

namespace {

constexpr const char* kNoNoise = "too few points to measure the noise";

/// Noise that is so large a part of the spacing may be the gap between two surfaces.
std::string other_reading(const LayerThickness& layers) {
  constexpr double kGapPerSpacing = 0.6;
  return layers.thickness > kGapPerSpacing * layers.spacing
             ? ", or two surfaces this close, which cleaning would merge"
             : "";
}

std::string percent_of(double share) { return short_text(std::round(100.0 * share)) + " %"; }

std::string brief_length(double value, double meters_per_unit) {
  const Length length = readable_length(value, meters_per_unit);
  return brief_text(length.value) + length.unit;
}

}  // namespace

std::string short_noise(const LayerThickness& layers, double meters_per_unit) {
  if (layers.measured == 0) return kNoNoise;
  const double percent = 100.0 * layers.thickness / layers.spacing;
  const double limit = 100.0 * kThickPerSpacing;
  // A share beside the limit keeps its digits: 8.97 % is not "9 %; below 9 %".
  const std::string share =
      std::abs(percent - limit) < 0.5 ? short_text(percent) : short_text(std::round(percent));
  return "noise " + brief_length(layers.thickness, meters_per_unit) + " RMS, " + share +
         " % of the point spacing (" + brief_length(layers.spacing, meters_per_unit) + ")" +
         other_reading(layers) + "; " + (layers.is_thick() ? "above " : "below ") +
         short_text(limit) + " %";
}

std::string short_reason(const LayerThickness& layers, double meters_per_unit) {
  const CleaningChoice choice = choose_cleaning(layers);
  const std::string noise = short_noise(layers, meters_per_unit);
  if (layers.measured == 0) return noise + ": no cleaning";
  if (!layers.is_thick_somewhere()) return noise + ": no cleaning needed";
  if (!layers.is_thick())
    return noise + " on the whole, but above it in " + percent_of(layers.thick_share) +
           " of the places, which are smoothed";
  return noise + ": outliers dropped, " + std::to_string(choice.smooth_passes) +
         " smoothing passes, thinned to " + brief_length(choice.thin_to_spacing, meters_per_unit);
}

CleaningChoice choose_cleaning(const LayerThickness& layers) {
  CleaningChoice choice;
  if (layers.measured == 0) {
    choice.noise = kNoNoise;
    return choice;
  }
  const auto percent = [](double share) { return short_text(100.0 * share) + " %"; };
  const bool is_thick = layers.is_thick_somewhere();
  const char* const beside = !is_thick           ? "up to "
                             : layers.is_thick() ? "above "
                                                 : "on the whole below ";
  choice.noise = "noise " + short_text(layers.thickness) + " RMS, " +
                 percent(layers.thickness / layers.spacing) + " of the point spacing (" +
                 short_text(layers.spacing) + ")" + other_reading(layers) + "; " + beside +
                 percent(kThickPerSpacing);
  if (!is_thick) return choice;
  choice.outlier_sigma = kOutlierSigma;
  choice.cluster_points = kClusterPoints;
  choice.smooth_radius = whole_cloud_noise(layers).radius;
  choice.thin_to_spacing = kThinningPerRadius * choice.smooth_radius;
  return choice;
}

}  // namespace orbweave
