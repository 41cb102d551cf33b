#include "engine/pipeline/points/point_doubts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/stage/scan_units.h"
#include "engine/spacing/automatic_radii.h"
#include "engine/spacing/coordinate_step.h"
#include "engine/spacing/site_points.h"
#include "io/job/setting.h"
#include "io/points/coordinate_system.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/reasons.h"
#include "io/shown_text.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// Of a spacing that no scanner has: the unit is probably another one.
std::string objection_to_units(const ResolvedJob& job, const Partition& partition) {
  constexpr double kLeastMeters = 1e-7;
  constexpr double kMostMeters = 1e3;
  const double known = meters_per_unit(job, partition);
  const double units_per_meter = known > 0.0 ? 1.0 / known : 1.0;
  const double meters = partition.spacing / units_per_meter;
  if (!(partition.spacing > 0.0) || (meters >= kLeastMeters && meters <= kMostMeters)) return {};
  return "the points lie " + format_number(meters) + " m apart by " +
         setting(job, "input.units_per_meter", format_exact(units_per_meter)) + ": check the units";
}

/// Whether x and y are degrees of longitude and latitude by their size, and z is a height: nothing
/// that is scanned is so much higher than wide, far from the origin as well.
bool look_like_degrees(const Box& bounds) {
  constexpr double kMostLongitude = 180.0, kMostLatitude = 90.0;
  constexpr double kHeightsPerWidth = 200.0;
  const Vec3 extent = bounds.extent();
  const double width = std::max(extent.x, extent.y);
  const double longitude = std::max(std::abs(bounds.min.x), std::abs(bounds.max.x));
  const double latitude = std::max(std::abs(bounds.min.y), std::abs(bounds.max.y));
  return longitude <= kMostLongitude && latitude <= kMostLatitude && extent.x > 0.0 &&
         extent.y > 0.0 && width < std::max(longitude, latitude) &&
         extent.z > kHeightsPerWidth * width;
}

/// Angles beside lengths give no shape.
std::string objection_to_degrees(const Partition& partition) {
  const std::string& system = partition.coordinate_system;
  const std::optional<CoordinateSystem> known =
      system.empty() ? std::nullopt : known_coordinate_system(system);
  if (known ? !known->is_geographic : !look_like_degrees(partition.bounds)) return {};
  const Vec3 extent = partition.bounds.extent();
  return std::string("x and y ") + (known ? "are" : "look like") +
         " degrees of longitude and latitude beside heights: the points lie within " +
         format_number(extent.x) + " x " + format_number(extent.y) + " x " +
         format_number(extent.z) +
         ", and the mesh follows these numbers; project the scans to a system in metres first";
}

/// The setting that says where the scanner was; empty: none does.
std::string setting_of_scanner(const Job& job) {
  if (job.input.scanner) return setting_name(job, "input.scanner");
  if (!job.input.scanners.empty()) return setting_name(job, "input.scanners");
  if (!job.input.trajectory.empty()) return setting_name(job, "input.trajectory");
  return "";
}

/// The setting that would decide the side of estimated normals; empty: none does so alone. A ground
/// is asked for by job files that are for scans with and without normals.
std::string setting_of_side(const Job& job) {
  if (std::string scanner = setting_of_scanner(job); !scanner.empty()) return scanner;
  if (job.normals.viewpoint) return setting_name(job, "normals.viewpoint");
  const Orientation rule = job.normals.orientation;
  const bool is_asked_for =
      rule != Orientation::kAuto && rule != Orientation::kGround && rule != Orientation::kNone;
  return is_asked_for ? setting_name(job, "normals.orientation") : "";
}

/// The orientation that the job asks for is another one than that by the scanner.
std::string objection_to_scanner(const ResolvedJob& job) {
  const std::string scanner = setting_of_scanner(job);
  if (scanner.empty() || !job.estimates_normals || job.wants_view()) return {};
  return scanner + " decides nothing: " +
         setting(job, "normals.orientation", text_of(job.normals.orientation)) +
         " decides the side of the normals; " + setting(job, "normals.orientation", "auto") +
         " goes by the scanner";
}

/// Normals of the file keep their side, whatever the job says about the scanner.
std::string objection_to_side(const ResolvedJob& job, const Partition& partition) {
  if (partition.normals.source != NormalSource::kFile) return objection_to_scanner(job);
  const std::string setting_of = setting_of_side(job);
  if (setting_of.empty()) return {};
  return setting_of +
         " decides nothing: the scans have normals of their own, which are taken as they are; "
         "to have normals estimated and turned, " +
         setting(job, "normals.source", "estimate");
}

/// Balls of a given number of levels that are too small for a tenth of the surface: it falls apart
/// there, and what is left of it has borders that look like those of open sheets.
std::string objection_to_levels(const ResolvedJob& job, const Partition& partition) {
  const ReconstructOptions& options = job.reconstruct;
  if (is_in_core(options.method) || options.levels == 0 || !options.ball_radii.empty()) return {};
  if (partition.automatic_radii.empty()) return {};
  const double largest = partition.automatic_radii.back();
  // Balls of two thirds of the distance to the nearest neighbours lose half of an even surface.
  if (!(partition.spacing_by_area > kRadiusGrowth * largest)) return {};
  const double unit = meters_per_unit(job, partition);
  const auto length = [&](double value) {
    const Length shown = readable_length(value, unit);
    return short_text(shown.value) + shown.unit;
  };
  return "a tenth of the surface or more has points " + length(partition.spacing_by_area) +
         " or farther from their neighbours, and the largest ball radius is " + length(largest) +
         " by " + setting(job, "reconstruct.levels", std::to_string(options.levels)) +
         ": it may stay open; " + setting(job, "reconstruct.levels", "auto") +
         " takes larger radii as well";
}

/// What is wrong with the coordinate system that the scans name, as far as that can be known.
std::vector<std::string> objections_to_system(const Partition& partition) {
  const std::string& system = partition.coordinate_system;
  if (system.empty()) return {};
  const std::optional<CoordinateSystem> known = known_coordinate_system(system);
  const std::string name = known ? known->name : shown(system.substr(0, 60));
  const std::string about = "the coordinate system of the scans, " + name;
  const WrittenSystem written = written_system(system);
  std::vector<std::string> objections;
  if (!written.problem.empty()) objections.push_back(about + ": " + written.problem);
  const std::string objection = objection_to_coordinates(system, partition.bounds);
  if (!objection.empty())
    objections.push_back(about + ", hardly fits their coordinates: " + objection + "; check it");
  return objections;
}

}  // namespace

std::string objection_to_chunks(const ResolvedJob& job, std::uint64_t points) {
  constexpr std::uint64_t kSmall = 1'000, kMany = 1'000;
  const std::uint64_t most = job.partition.chunk_points;
  if (most == 0 || most >= kSmall || points / most < kMany) return {};
  return setting(job, "partition.chunk_points", std::to_string(most)) + " cuts " +
         format_count(points) + " points into " + format_count(points / most) +
         " chunks or more, and each of them works on the points around its own as well; " +
         setting(job, "partition.chunk_points", "auto") + " is faster" +
         (job.reconstruct.method == ReconstructionMethod::kBallPivoting ? " and makes the same mesh"
                                                                        : "");
}

std::vector<std::string> objections_to_points(const ResolvedJob& job, const Partition& partition) {
  std::vector<std::string> objections = {objection_to_units(job, partition)};
  for (std::string& objection : objections_to_system(partition))
    objections.push_back(std::move(objection));
  objections.push_back(objection_to_degrees(partition));
  objections.push_back(objection_to_side(job, partition));
  objections.push_back(objection_to_levels(job, partition));
  std::erase(objections, "");
  return objections;
}

std::string objection_to_steps(const ResolvedJob& job, const Partition& scans,
                               const CleaningOptions& cleaning) {
  std::string objection = objection_to_step(scans.coordinate_step, scans.spacing);
  if (!objection.empty()) return objection;
  constexpr double kRounded = 1e-3;  // of the spacing: the advice has four digits
  const double wanted = spacing_for_step(scans.common_step);
  objection = objection_to_common_step(scans.common_step, scans.spacing);
  if (objection.empty() || cleaning.thin_to_spacing >= (1.0 - kRounded) * wanted) return {};
  return objection +
         ", or thin them: " + setting(job, "cleaning.thin_to_spacing", short_text(wanted));
}

}  // namespace orbweave
