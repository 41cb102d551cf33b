#include "io/points/scan_pose.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>

#include "io/byte_order_mark.h"
#include "io/error.h"
#include "io/system/file_descriptor.h"
#include "io/system/small_file.h"
#include "io/text/counted_noun.h"
#include "io/text/text_number.h"
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

constexpr std::size_t kQuaternion = 7;  ///< numbers, with the translation
constexpr std::size_t kMatrix = 16;

bool is_number(std::string_view word) {
  double number = 0.0;
  const char* end = word.data() + word.size();
  return parse_number(word.data(), end, number) == end && std::isfinite(number);
}

struct NamedNumbers {
  std::string name;
  std::vector<double> numbers;
};

/// The name of a scan, which may hold blanks, and as many numbers behind it as one of `counts`
/// says. Throws std::invalid_argument, saying why.
NamedNumbers named_numbers(std::string_view text, std::span<const std::size_t> counts) {
  const std::vector<std::string_view> words = words_of(text);
  const auto numbers_begin = std::find_if_not(words.rbegin(), words.rend(), is_number).base();
  const auto numbers = static_cast<std::size_t>(words.end() - numbers_begin);
  for (const std::size_t count : counts) {
    if (words.size() <= count || (words.size() != count + 1 && numbers != count)) continue;
    const std::string_view last = words[words.size() - count - 1];
    NamedNumbers named{{words[0].data(), last.data() + last.size()}, {}};
    for (const std::string_view word : std::span(words).last(count))
      named.numbers.push_back(finite_number(word));
    return named;
  }
  throw std::invalid_argument("it has " + counted_noun(words.size(), "word", "words"));
}

/// Of "FILE tx ty tz qx qy qz qw", behind its keyword.
ScanPose stanford_pose(std::string_view text) {
  const auto [name, v] = named_numbers(text, std::array{kQuaternion});
  // The conjugate: these quaternions turn row vectors.
  return {name, motion_of_quaternion({-v[3], -v[4], -v[5], v[6]}, {v[0], v[1], v[2]})};
}

/// The folders of a path and its file, without what leads to another place first.
std::vector<std::filesystem::path> names_in(const std::filesystem::path& path) {
  const std::filesystem::path normal = path.lexically_normal();
  const auto leads_elsewhere = [](const std::filesystem::path& name) { return name == ".."; };
  return {std::find_if_not(normal.begin(), normal.end(), leads_elsewhere), normal.end()};
}

/// How well the name of a scan fits one. A file of poses is written in one folder and read from
/// another, so a name may lack folders in front, or have more of them.
struct NameFit {
  bool is_same = false;
  bool is_end = false;    ///< all of one is the end of the other
  std::size_t names = 0;  ///< of files and folders that agree, from the end
  friend auto operator<=>(const NameFit&, const NameFit&) = default;
};

NameFit fit_of(const std::vector<std::filesystem::path>& a,
               const std::vector<std::filesystem::path>& b) {
  const auto differ = std::mismatch(a.rbegin(), a.rend(), b.rbegin(), b.rend()).first;
  const auto names = static_cast<std::size_t>(differ - a.rbegin());
  return {a == b, names == std::min(a.size(), b.size()), names};
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
  const auto [name, v] = named_numbers(text, std::array{kQuaternion, kMatrix});
  if (v.size() == kQuaternion)
    return {name, motion_of_quaternion({v[3], v[4], v[5], v[6]}, {v[0], v[1], v[2]})};
  std::array<double, kMatrix> matrix{};
  std::ranges::copy(v, matrix.begin());
  return {name, motion_of_matrix(matrix)};
}

std::vector<ScanPose> parse_stanford_poses(std::string_view text, const std::string& name) {
  constexpr std::string_view kKeyword = "bmesh";
  std::vector<ScanPose> poses;
  text = without_byte_order_mark(text);
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    const std::vector<std::string_view> words = words_of(line);
    begin = end + 1;
    ++line_number;
    // Others (camera, mesh) say nothing about scans.
    if (words.empty() || words[0] != kKeyword) continue;
    try {
      poses.push_back(stanford_pose(line.substr(line.find(kKeyword) + kKeyword.size())));
    } catch (const std::invalid_argument& problem) {
      throw_bad_input("not the pose of a scan", {.file = name,
                                                 .place = "line " + std::to_string(line_number),
                                                 .found = problem.what(),
                                                 .expected = "bmesh FILE tx ty tz qx qy qz qw"});
    }
  }
  if (poses.empty())
    throw_bad_input("no pose of any scan",
                    {.file = name, .expected = "lines such as: bmesh FILE tx ty tz qx qy qz qw"});
  return poses;
}

std::vector<ScanPose> read_stanford_poses(const std::filesystem::path& path) {
  const std::optional<std::string> text = small_file_text(path);
  if (!text) throw_unread("cannot open the file of poses", {.file = path.string()}, errno);
  return parse_stanford_poses(*text, path.string());
}

namespace {

/// Precondition: there are poses.
const ScanPose& own_pose(const std::vector<ScanPose>& poses, const std::filesystem::path& scan) {
  const std::vector<std::filesystem::path> place = names_in(scan);
  const ScanPose* found = nullptr;
  NameFit best;
  bool is_one = true;
  for (const ScanPose& pose : poses) {
    const NameFit fit = fit_of(names_in(pose.file), place);
    if ((fit.names == 0 && !fit.is_same) || fit < best) continue;
    is_one = fit > best || (is_one && pose.motion == found->motion);
    best = fit;
    found = &pose;
  }
  if (!is_one)
    throw_bad_input("two poses for one scan",
                    {.file = scan.string(), .expected = "one", .advice = "Name it by its path."});
  if (found != nullptr) return *found;
  throw_bad_input(
      "no pose for this scan",
      {.file = scan.string(),
       .found = counted_noun(poses.size(), "pose of another scan", "poses of other scans"),
       .expected = "a line for " + scan.filename().string(),
       .advice = "Add its pose, or leave the scan out."});
}

}  // namespace

RigidMotion pose_of_scan(const std::vector<ScanPose>& poses, const std::filesystem::path& scan) {
  return poses.empty() ? RigidMotion{} : own_pose(poses, scan).motion;
}

void require_own_poses(const std::vector<ScanPose>& poses, std::span<const std::string> scans) {
  if (poses.empty()) return;
  std::map<const ScanPose*, std::string> scan_of;
  for (const std::string& scan : scans) {
    const ScanPose& pose = own_pose(poses, scan);
    const auto [known, is_first] = scan_of.try_emplace(&pose, scan);
    const std::filesystem::path path = scan, first = known->second;
    if (is_first || path.lexically_normal() == first.lexically_normal()) continue;
    throw_bad_input("two scans for one pose",
                    {.file = scan,
                     .found = "the pose of " + pose.file + ", which " + known->second + " has",
                     .expected = "a pose of its own",
                     .advice = "Name both by their paths."});
  }
}

}  // namespace orbweave
