#include "engine/pipeline/surface/radii_choice.h"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/stage/scan_units.h"
#include "engine/spacing/automatic_radii.h"
#include "engine/spacing/site_points.h"
#include "io/ball_radii.h"
#include "io/error.h"
#include "io/job/setting.h"

namespace orbweave {
namespace {

std::string short_number(double value) {
  const bool is_large = value >= 999.5;
  std::array<char, 40> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), is_large ? std::round(value) : value,
                    std::chars_format::general, is_large ? 6 : 3)
          .ptr;
  return {text.data(), end};
}

/// `meters_per_unit`: as for readable_length.
std::string compare_with_spacing(const std::vector<double>& radii, double spacing,
                                 double meters_per_unit) {
  if (radii.empty()) return {};
  const auto range = [&](const auto& text_of) {
    const std::string first = text_of(radii.front());
    return radii.size() == 1 ? first : first + " to " + text_of(radii.back());
  };
  const auto length = [&](double value) {
    const Length shown = readable_length(value, meters_per_unit);
    return short_number(shown.value) + shown.unit;
  };
  std::string text = (radii.size() == 1 ? "ball radius " : "ball radii ") + range(length);
  if (radii.size() > 1) text += " (" + std::to_string(radii.size()) + " levels)";
  if (spacing > 0.0)
    text += ", " + range([&](double radius) { return short_number(radius / spacing); }) +
            " times the point spacing " + length(spacing);
  return text;
}

/// Throws where ball pivoting cannot work with the radii.
void require_usable(const ResolvedJob& job, const std::vector<double>& radii,
                    const std::string& reason) {
  const auto objection = objection_to_radii(radii);
  if (!objection) return;
  if (job.reconstruct.ball_radii.empty())
    throw_bad_input(
        "no ball radius can be chosen: " + objection->problem,
        {.file = job.files.front(), .place = {}, .found = reason, .expected = objection->expected});
  throw_usage(objection->problem, {.file = {},
                                   .place = setting_name(job, "reconstruct.ball_radii"),
                                   .found = reason,
                                   .expected = objection->expected});
}

/// Lengths that stand for ball radii where the method has none: what looks for triangles near a
/// place reaches twice as far.
BallRadii reach_without_balls(const ResolvedJob& job, const Partition& partition) {
  const double extent = partition.bounds.largest_extent();
  double reach = partition.spacing > 0.0 ? 3.0 * partition.spacing : extent;
  if (!partition.automatic_radii.empty()) reach = partition.automatic_radii.back();
  // Across chunks, no triangle of a Cocone is larger.
  constexpr double kAcrossChunks = 2.0;
  if (is_super_cocone(job, partition)) reach *= kAcrossChunks;
  return {{reach > 0.0 ? reach : 1.0}, "not used by " + method_name(job)};
}

}  // namespace

BallRadii radii_of_job(const ResolvedJob& job, const Partition& partition) {
  const ReconstructOptions& options = job.reconstruct;
  if (is_in_core(options.method)) return reach_without_balls(job, partition);
  std::vector<double> radii = options.ball_radii;
  std::string reason = compare_with_spacing(radii, partition.spacing, 0.0);
  if (radii.empty()) {
    radii = partition.automatic_radii;
    reason = partition.radii_reason;
    if (radii.empty()) {
      throw_bad_input("no triangle can be formed: no ball radius can be chosen",
                      {.file = job.files.front(), .place = {}, .found = reason});
    }
  } else if (partition.spacing > 0.0 && radii.back() > kMostSpacingsPerRadius * partition.spacing) {
    throw_usage("the ball radius is too large: " + reason,
                {.file = {},
                 .place = setting_name(job, "reconstruct.ball_radii"),
                 .found = short_number(radii.back()),
                 .expected = "at most " + short_number(kMostSpacingsPerRadius * partition.spacing),
                 .advice = "Radii of one to five spacings close a surface; try " +
                           setting(job, "reconstruct.ball_radii", "auto")});
  }
  require_usable(job, radii, reason);
  return {std::move(radii), std::move(reason)};
}

std::string short_radii(const ResolvedJob& job, const Partition& partition,
                        const std::vector<double>& radii) {
  return compare_with_spacing(radii, partition.spacing, meters_per_unit(job, partition));
}

}  // namespace orbweave
