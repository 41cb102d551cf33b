#include "io/points/scan_pose.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "io/byte_order_mark.h"
#include "io/error.h"
#include "io/text/counted_noun.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

/// How far a matrix of rounded decimals may be from a rotation.
constexpr double kTolerance = 1e-4;

double determinant(const std::array<Vec3, 3>& rows) {
  return dot(rows[0], cross(rows[1], rows[2]));
}

void require_rotation(const std::array<Vec3, 3>& rows) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      const double wanted = i == j ? 1.0 : 0.0;
      if (!(std::abs(dot(rows[i], rows[j]) - wanted) <= kTolerance))
        throw std::invalid_argument("its rows are not of length one and at right angles");
    }
  }
  if (determinant(rows) < 0.0) throw std::invalid_argument("it mirrors");
}

ScanPose stanford_pose(const std::vector<std::string_view>& words) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = finite_number(words[i + 2]);
  // The conjugate: these quaternions turn row vectors.
  return {std::string(words[1]),
          motion_of_quaternion({-v[3], -v[4], -v[5], v[6]}, {v[0], v[1], v[2]})};
}

/// Nothing of a quaternion without length.
std::optional<std::array<double, 4>> of_length_one(std::array<double, 4> quaternion) {
  double largest = 0.0;
  for (const double part : quaternion) {
    if (!std::isfinite(part)) return std::nullopt;
    largest = std::max(largest, std::abs(part));
  }
  if (largest == 0.0) return std::nullopt;
  // By a power of two, which rounds nothing: squares neither vanish nor overflow.
  const int exponent = std::ilogb(largest);
  double length = 0.0;
  for (double& part : quaternion) {
    part = std::scalbn(part, -exponent);
    length += part * part;
  }
  length = std::sqrt(length);
  for (double& part : quaternion) part /= length;
  return quaternion;
}

}  // namespace

RigidMotion motion_of_quaternion(const std::array<double, 4>& quaternion, Vec3 translation) {
  const std::optional<std::array<double, 4>> unit = of_length_one(quaternion);
  if (!unit || !is_finite(translation))
    throw std::invalid_argument("it is no quaternion with a length and a translation");
  const auto [x, y, z, w] = *unit;
  return {{Vec3{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
           Vec3{2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
           Vec3{2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}},
          translation};
}

RigidMotion motion_of_matrix(const std::array<double, 16>& matrix) {
  RigidMotion motion;
  for (int row = 0; row < 3; ++row) {
    const double* at = matrix.data() + 4 * row;
    motion.rows[row] = {at[0], at[1], at[2]};
    motion.translation[row] = at[3];
  }
  if (matrix[12] != 0.0 || matrix[13] != 0.0 || matrix[14] != 0.0 || matrix[15] != 1.0)
    throw std::invalid_argument("its last row is not 0 0 0 1");
  if (!is_finite(motion.translation)) throw std::invalid_argument("it is not finite");
  require_rotation(motion.rows);
  return motion;
}

ScanPose parse_pose(std::string_view text) {
  const std::vector<std::string_view> words = words_of(text);
  constexpr std::size_t kQuaternion = 7;
  constexpr std::size_t kMatrix = 16;
  if (words.size() != 1 + kQuaternion && words.size() != 1 + kMatrix)
    throw std::invalid_argument("it has " + counted_noun(words.size(), "word", "words"));
  std::array<double, kMatrix> v{};
  for (std::size_t i = 1; i < words.size(); ++i) v[i - 1] = finite_number(words[i]);
  const std::string file(words[0]);
  if (words.size() == 1 + kMatrix) return {file, motion_of_matrix(v)};
  return {file, motion_of_quaternion({v[3], v[4], v[5], v[6]}, {v[0], v[1], v[2]})};
}

std::vector<ScanPose> parse_stanford_poses(std::string_view text, const std::string& name) {
  constexpr std::size_t kWords = 9;
  std::vector<ScanPose> poses;
  text = without_byte_order_mark(text);
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::vector<std::string_view> words = words_of(text.substr(begin, end - begin));
    begin = end + 1;
    ++line_number;
    // Others (camera, mesh) say nothing about scans.
    if (words.empty() || words[0] != "bmesh") continue;
    const ErrorParts where{.file = name,
                           .place = "line " + std::to_string(line_number),
                           .found = counted_noun(words.size(), "word", "words"),
                           .expected = "bmesh FILE tx ty tz qx qy qz qw"};
    if (words.size() != kWords) throw_bad_input("not the pose of a scan", where);
    try {
      poses.push_back(stanford_pose(words));
    } catch (const std::invalid_argument& problem) {
      throw_bad_input("not the pose of a scan",
                      {where.file, where.place, problem.what(), where.expected, {}});
    }
  }
  if (poses.empty())
    throw_bad_input("no pose of any scan",
                    {.file = name, .expected = "lines such as: bmesh FILE tx ty tz qx qy qz qw"});
  return poses;
}

std::vector<ScanPose> read_stanford_poses(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code ignored;
  if (!file || std::filesystem::is_directory(path, ignored))
    throw_bad_input("cannot open the file of poses", {.file = path.string()});
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (file.bad()) throw_bad_input("cannot read the file of poses", {.file = path.string()});
  return parse_stanford_poses(text, path.string());
}

RigidMotion pose_of_scan(const std::vector<ScanPose>& poses, const std::filesystem::path& scan) {
  if (poses.empty()) return {};
  const ScanPose* found = nullptr;
  // A whole path says more than a name.
  for (const bool by_path : {true, false}) {
    for (const ScanPose& pose : poses) {
      const std::filesystem::path named(pose.file);
      const bool fits = by_path ? named == scan : named.filename() == scan.filename();
      if (!fits) continue;
      if (found != nullptr && found->motion != pose.motion)
        throw_bad_input(
            "two poses for one scan",
            {.file = scan.string(), .expected = "one", .advice = "Name it by its path."});
      found = &pose;
    }
    if (found != nullptr) return found->motion;
  }
  throw_bad_input(
      "no pose for this scan",
      {.file = scan.string(),
       .found = counted_noun(poses.size(), "pose of another scan", "poses of other scans"),
       .expected = "a line for " + scan.filename().string(),
       .advice = "Add its pose, or leave the scan out."});
}

}  // namespace orbweave
