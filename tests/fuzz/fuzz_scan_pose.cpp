// Any bytes as poses: a Stanford .conf, or "=" and the pose of one scan as an option has it. What
// is read turns and moves, and does nothing else.
#include "io/points/scan_pose.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

#include "io/error.h"

namespace {

/// Matrices of rounded decimals are taken as they are.
constexpr double kTolerance = 1e-4;

void require(bool holds) {
  if (!holds) std::abort();
}

void check_motion(const orbweave::RigidMotion& motion) {
  require(orbweave::is_finite(motion.translation));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      require(std::abs(orbweave::dot(motion.rows[i], motion.rows[j]) - (i == j)) <= kTolerance);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    if (text.starts_with('=')) {
      check_motion(orbweave::parse_pose(text.substr(1)).motion);
      return 0;
    }
    const auto poses = orbweave::parse_stanford_poses(text, "input");
    require(!poses.empty());
    for (const orbweave::ScanPose& pose : poses) {
      check_motion(pose.motion);
      require(orbweave::pose_of_scan({pose}, pose.file) == pose.motion);
    }
  } catch (const orbweave::Error& error) {
    require(error.kind() == orbweave::ErrorKind::kBadInput);
  } catch (const std::invalid_argument&) {
    require(text.starts_with('='));
  }
  return 0;
}
