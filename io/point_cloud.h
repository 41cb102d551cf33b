// What a point cloud is: positions, normals and any further per-point attributes, each at the
// width its file had. The same struct serves as a whole cloud, as one batch of a stream and as
// the content of a chunk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/box.h"
#include "io/scalar_types.h"
#include "io/vec3.h"

namespace orbweave {

/// One per-point attribute besides position and normal (colour channel, intensity, time, ...).
struct AttributeField {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  friend bool operator==(const AttributeField&, const AttributeField&) = default;
};

/// What every point of a cloud carries.
struct PointSchema {
  bool has_normals = false;
  ScalarType position_type = ScalarType::kFloat64;  ///< width in the file; kFloat32 or kFloat64
  ScalarType normal_type = ScalarType::kFloat32;    ///< width in the file; kFloat32 or kFloat64
  std::vector<AttributeField> attributes;           ///< in file order

  /// Bytes of one point's attributes, packed without padding in field order.
  std::size_t attribute_bytes() const;
  friend bool operator==(const PointSchema&, const PointSchema&) = default;
};

/// Points with normals and attributes, as parallel arrays.
/// Invariant: normals.size() is positions.size() or 0 (no normals);
/// attributes.size() == positions.size() * schema.attribute_bytes(), one row per point, packed in
/// field order without padding, in native byte order.
/// A plain value: many threads may read it, none while another one changes it.
struct PointCloud {
  PointSchema schema;
  std::vector<Vec3> positions;  ///< world units
  std::vector<Vec3> normals;    ///< as given (not normalised); exact doubles of the file's values
  std::vector<std::byte> attributes;

  std::size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }
  /// Keeps the schema, drops the points, keeps the capacity.
  void clear();
  void reserve(std::size_t points);
  std::span<const std::byte> attribute_row(std::size_t i) const;
  /// Appends point i of other. Both schemas must be equal.
  void append(const PointCloud& other, std::size_t i);
  void append(const PointCloud& other);
  Box bounds() const;
};

/// The points whose flag is not 0, in their order. There is a flag for every point.
PointCloud kept_points(PointCloud cloud, std::span<const std::uint8_t> kept);

/// Value of one attribute as a double, for display and for formats of one type.
double attribute_value(const PointCloud& cloud, std::size_t point, std::size_t field);

}  // namespace orbweave
