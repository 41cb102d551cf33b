// What the points of an E57 file become: one schema for all scans, and for each scan which of its
// fields feed what.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/clouds/e57/e57_document.h"
#include "io/point_cloud.h"

namespace orbweave {

/// How one attribute of one scan is made: value = (field's value - from) * scale + to, clamped to
/// the type; integers that are neither moved nor scaled stay integers all the way.
struct E57Attribute {
  std::optional<std::size_t> field;  ///< of the scan; empty: it lacks one, and its points get 0
  ScalarType type = ScalarType::kFloat32;
  double from = 0.0;
  double scale = 1.0;
  double to = 0.0;
  bool is_plain() const { return from == 0.0 && scale == 1.0 && to == 0.0; }
};

/// What to decode of one scan.
struct E57ScanLayout {
  std::array<std::size_t, 3> position{};  ///< x, y, z, or range, azimuth, elevation
  bool is_spherical = false;
  std::optional<std::size_t> invalid_state;  ///< not 0: the point has no position
  std::array<std::size_t, 3> normal{};       ///< used where the schema has normals
  std::vector<E57Attribute> attributes;      ///< in the schema's order
  /// The scanner stood at the origin of the scan's coordinates.
  bool has_scanner = false;
};

struct E57Layout {
  PointSchema schema;
  std::vector<E57ScanLayout> scans;  ///< as many as scans
};

/// Attributes are those that any scan has, normals are there where all scans have them; each is of
/// a type that fits all. Throws Error (bad input) for a scan whose points have no position; `file`
/// is used in its message.
E57Layout plan_e57_layout(const std::vector<E57Scan>& scans, const std::string& file);

}  // namespace orbweave
