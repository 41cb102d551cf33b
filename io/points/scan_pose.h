// Rigid motions of scans, and where they are written.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/vec3.h"

namespace orbweave {

/// world = linear * p + translation; `linear` is a rotation, row by row.
struct RigidMotion {
  std::array<Vec3, 3> rows = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 translation;

  Vec3 direction(Vec3 v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
  Vec3 point(Vec3 p) const { return direction(p) + translation; }
  friend bool operator==(const RigidMotion&, const RigidMotion&) = default;
};

/// The pose of one scan.
struct ScanPose {
  std::string file;  ///< path of the scan, or its file name alone
  RigidMotion motion;
  friend bool operator==(const ScanPose&, const ScanPose&) = default;
};

/// The rotation of a quaternion x, y, z, w of any length but zero, which turns p into q p q*.
/// Throws std::invalid_argument for a quaternion without length.
RigidMotion motion_of_quaternion(const std::array<double, 4>& quaternion, Vec3 translation);

/// The motion of a 4x4 matrix, row by row, that is applied to column vectors. Throws
/// std::invalid_argument, saying why, where it is no rigid motion (to 1e-4 of its scale).
RigidMotion motion_of_matrix(const std::array<double, 16>& matrix);

/// "FILE tx ty tz qx qy qz qw" or "FILE" and the sixteen numbers of a matrix, as for the functions
/// above. FILE may hold blanks. Throws std::invalid_argument, saying why.
ScanPose parse_pose(std::string_view text);

/// Reads the `bmesh FILE tx ty tz qx qy qz qw` lines of a Stanford .conf. Its quaternions turn row
/// vectors: world = conjugate rotation + translation. Throws Error (bad input) with file and line.
std::vector<ScanPose> read_stanford_poses(const std::filesystem::path& path);
std::vector<ScanPose> parse_stanford_poses(std::string_view text, const std::string& name);

/// The pose of a scan: the one whose name agrees with most of the scan's path from its end, at
/// least with its file name; the identity where there are no poses at all. Throws Error (bad
/// input) where there are poses but none, or two, for the scan.
RigidMotion pose_of_scan(const std::vector<ScanPose>& poses, const std::filesystem::path& scan);

/// Throws Error (bad input) where two scans take one pose: files of one name in several folders, of
/// which the pose names one or none by its path. One file by two names is one scan.
void require_own_poses(const std::vector<ScanPose>& poses, std::span<const std::string> scans);

}  // namespace orbweave
