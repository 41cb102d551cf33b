#include "io/report/picture_up.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "io/text/file_format.h"

namespace orbweave {
namespace {

bool has_heights_in_z(const std::string& file) {
  const std::optional<NamedFormat> named = format_of_name(file);
  if (!named) return false;
  const FileFormat format = named->facts.format;
  return format == FileFormat::kLas || format == FileFormat::kLaz || format == FileFormat::kE57 ||
         format == FileFormat::kPtx;
}

/// Scanners of poses of a job file stand at the origins of their scans.
bool has_places(const InputOptions& input) {
  return !input.pose.empty() || !input.scanners.empty() || !input.trajectory.empty() ||
         (input.scanner && !input.scanner->is_direction);
}

bool has_scanners(const std::string& file) {
  const std::optional<NamedFormat> named = format_of_name(file);
  return named &&
         (named->facts.format == FileFormat::kE57 || named->facts.format == FileFormat::kPtx);
}

/// Whether normals, or those of the ground, point to the side of z where no other direction is
/// given.
bool turns_to_z(Orientation orientation) {
  return orientation == Orientation::kGround || orientation == Orientation::kUp;
}

/// kAuto for a direction that points against its nearest axis: normals of a ceiling are oriented
/// downwards, and a ceiling is not drawn upside down.
UpAxis nearest_axis(Vec3 direction) {
  int nearest = 2;
  for (const int axis : {1, 0})
    if (std::abs(direction[axis]) > std::abs(direction[nearest])) nearest = axis;
  if (!(direction[nearest] > 0.0)) return UpAxis::kAuto;
  return static_cast<UpAxis>(static_cast<int>(UpAxis::kX) + nearest);
}

}  // namespace

UpAxis up_axis_of_scans(std::span<const std::string> files, const std::string& coordinate_system) {
  const bool z_is_up = !coordinate_system.empty() || std::ranges::any_of(files, has_heights_in_z);
  return z_is_up ? UpAxis::kZ : UpAxis::kAuto;
}

bool may_be_interior(const Job& job, std::span<const std::string> files) {
  return job.normals.orientation == Orientation::kInward || has_places(job.input) ||
         std::ranges::any_of(files, has_scanners);
}

UpAxis picture_up(const Job& job, std::span<const std::string> files,
                  const std::string& coordinate_system) {
  if (job.output.picture_up != UpAxis::kAuto) return job.output.picture_up;
  if (job.normals.up) {
    const UpAxis nearest = nearest_axis(*job.normals.up);
    if (nearest != UpAxis::kAuto) return nearest;
  }
  if (!job.normals.up && turns_to_z(job.normals.orientation)) return UpAxis::kZ;
  const UpAxis implied = up_axis_of_scans(files, coordinate_system);
  if (implied != UpAxis::kAuto) return implied;
  if (has_places(job.input)) return UpAxis::kZ;  // tripods stand upright
  return job.input.poses.empty() ? UpAxis::kAuto : UpAxis::kY;
}

}  // namespace orbweave
