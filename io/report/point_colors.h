// The colours that a scan gave to its points, for a picture.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/point_cloud.h"
#include "io/points/named_attribute.h"
#include "io/report/picture_legend.h"

namespace orbweave {

/// Said where a picture was to show the colours of a scan that has none.
inline constexpr const char* kNoPointColors =
    "the points carry neither colours nor an intensity: the picture tells filled holes instead";

/// Red, green and blue of points, or their intensity as grey where there are no colours. What the
/// numbers are scaled by follows from all points together, whatever their order.
class PointColors {
 public:
  explicit PointColors(const PointSchema& schema);

  /// Whether the points carry colours or an intensity.
  bool any() const { return colors_.has_value() || intensity_.has_value(); }
  /// Whether the scale is still to be learnt from the points.
  bool needs_survey() const;
  /// Takes notice of points; all of them once, in any order and batches.
  void survey(const PointCloud& points);
  /// After the last survey.
  void finish();
  /// The colour of a point. The cloud has the schema given at the beginning.
  Rgb of(const PointCloud& points, std::size_t i) const;
  /// What the colours are.
  LegendEntry legend() const;

 private:
  using Channels = std::array<NamedAttribute, 3>;

  void survey_intensity(const PointCloud& points);
  float intensity_at_share(double share) const;

  std::optional<Channels> colors_;
  std::optional<NamedAttribute> intensity_;
  double largest_ = 0.0;                   ///< of all channels
  double darkest_ = 0.0, lightest_ = 0.0;  ///< intensities that are drawn so
  std::vector<std::uint64_t> counts_;      ///< of intensities, by the front of their bits
};

}  // namespace orbweave
