#include "engine/pipeline/radii_choice.h"

#include <array>
#include <charconv>

#include "io/error.h"

namespace orbweave {
namespace {

/// A ball of that many spacings holds some 50,000 points of a surface.
constexpr double kLargestInSpacings = 64.0;

std::string short_number(double value) {
  std::array<char, 40> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 3)
          .ptr;
  return {text.data(), end};
}

}  // namespace

std::string compare_with_spacing(const std::vector<double>& radii, double spacing) {
  std::string text;
  for (const double ball_radius : radii) {
    if (!text.empty()) text += ", ";
    text += "rho = " + short_number(ball_radius);
    if (spacing > 0.0) {
      text += " is " + short_number(ball_radius / spacing) + " times the point spacing " +
              short_number(spacing);
    }
  }
  return text;
}

std::vector<double> radii_of_job(JobContext& context, const Partition& partition) {
  const ReconstructOptions& options = context.job.reconstruct;
  std::vector<double> radii = options.ball_radii;
  std::string reason = compare_with_spacing(radii, partition.spacing);
  if (radii.empty()) {
    radii = partition.automatic_radii;
    reason = partition.radii_reason;
    if (radii.empty()) {
      throw_bad_input("no triangle can be formed: no ball radius can be chosen",
                      {.file = context.files.front(), .place = {}, .found = reason});
    }
  } else if (partition.spacing > 0.0 && radii.back() > kLargestInSpacings * partition.spacing) {
    throw_usage("the ball radius is too large: " + reason,
                {.file = {},
                 .place = "reconstruct.ball_radii",
                 .found = short_number(radii.back()),
                 .expected = "at most " + short_number(kLargestInSpacings * partition.spacing),
                 .advice = "Radii of one to five spacings close a surface; try radii = \"auto\""});
  }
  context.report.radii = radii;
  context.report.radii_reason = reason;
  context.note("ball radii: " + reason);
  return radii;
}

}  // namespace orbweave
