#include "engine/pipeline/surface/radii_choice.h"

#include <array>
#include <charconv>
#include <utility>

#include "engine/spacing/automatic_radii.h"
#include "io/ball_radii.h"
#include "io/error.h"

namespace orbweave {
namespace {

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

namespace {

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
                                   .place = "reconstruct.ball_radii",
                                   .found = reason,
                                   .expected = objection->expected});
}

}  // namespace

BallRadii radii_of_job(const ResolvedJob& job, const Partition& partition) {
  const ReconstructOptions& options = job.reconstruct;
  std::vector<double> radii = options.ball_radii;
  std::string reason = compare_with_spacing(radii, partition.spacing);
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
                 .place = "reconstruct.ball_radii",
                 .found = short_number(radii.back()),
                 .expected = "at most " + short_number(kMostSpacingsPerRadius * partition.spacing),
                 .advice = "Radii of one to five spacings close a surface; try radii = \"auto\""});
  }
  require_usable(job, radii, reason);
  return {std::move(radii), std::move(reason)};
}

}  // namespace orbweave
