#include "io/report/point_colors.h"

#include <algorithm>
#include <cmath>

#include "io/ply/intensity_name.h"
#include "io/report/picture_samples.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr int kDroppedBits = 16;  // of an intensity: the rest tells 1 % apart
constexpr double kMost8 = 255.0, kMost16 = 65535.0;
constexpr std::uint8_t kDarkGrey = 30, kLightGrey = 245;

/// 0 of what is no number.
std::uint8_t rounded(double value) {
  return value > 0.0 ? static_cast<std::uint8_t>(std::lround(std::min(value, kMost8))) : 0;
}

}  // namespace

PointColors::PointColors(const PointSchema& schema) {
  const auto red = find_attribute(schema, "red"), green = find_attribute(schema, "green"),
             blue = find_attribute(schema, "blue");
  if (red && green && blue)
    colors_ = Channels{*red, *green, *blue};
  else
    intensity_ = find_attribute(schema, kIntensity);
}

bool PointColors::needs_survey() const {
  if (!colors_) return intensity_.has_value();
  return std::ranges::any_of(
      *colors_, [](const NamedAttribute& channel) { return channel.type() != ScalarType::kUint8; });
}

void PointColors::survey(const PointCloud& points) {
  if (intensity_) return survey_intensity(points);
  if (!colors_) return;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (const NamedAttribute& channel : *colors_)
      if (const double value = channel(points.attribute_row(i)); std::isfinite(value))
        largest_ = std::max(largest_, value);
}

void PointColors::survey_intensity(const PointCloud& points) {
  counts_.resize(std::size_t{1} << (32 - kDroppedBits), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto value = static_cast<float>((*intensity_)(points.attribute_row(i)));
    if (std::isfinite(value)) ++counts_[depth_key(value) >> kDroppedBits];
  }
}

/// The intensity that this share of the points does not exceed.
float PointColors::intensity_at_share(double share) const {
  std::uint64_t all = 0;
  for (const std::uint64_t count : counts_) all += count;
  const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(all));
  std::uint64_t below = 0;
  for (std::size_t key = 0; key < counts_.size(); ++key) {
    below += counts_[key];
    if (below > wanted) return depth_of(static_cast<std::uint32_t>(key) << kDroppedBits);
  }
  return 0.0F;
}

void PointColors::finish() {
  constexpr double kLeftOut = 0.02;  // of the points at each end of the scale
  if (!intensity_) return;
  darkest_ = intensity_at_share(kLeftOut);
  lightest_ = intensity_at_share(1.0 - kLeftOut);
}

Rgb PointColors::of(const PointCloud& points, std::size_t i) const {
  const std::span<const std::byte> row = points.attribute_row(i);
  if (colors_) {
    const bool is_integer = (*colors_)[0].type() < ScalarType::kFloat32;
    const double scale = largest_ > kMost8                ? kMost8 / kMost16
                         : !is_integer && largest_ <= 1.0 ? kMost8
                                                          : 1.0;
    Rgb colour{};
    for (std::size_t c = 0; c < 3; ++c) colour[c] = rounded(scale * (*colors_)[c](row));
    return colour;
  }
  const double span = lightest_ - darkest_;
  const double share = span > 0.0 ? ((*intensity_)(row)-darkest_) / span : 0.5;
  const double shown = share > 0.0 ? std::min(share, 1.0) : 0.0;  // of a NaN 0
  const std::uint8_t grey = rounded(kDarkGrey + shown * (kLightGrey - kDarkGrey));
  return {grey, grey, grey};
}

LegendEntry PointColors::legend() const {
  if (colors_) return {{96, 150, 80}, {215, 190, 140}, "surface in the colours of the scan"};
  return {{kDarkGrey, kDarkGrey, kDarkGrey},
          {kLightGrey, kLightGrey, kLightGrey},
          "intensity of the scan, " + format_number(darkest_) + " to " + format_number(lightest_)};
}

}  // namespace orbweave
