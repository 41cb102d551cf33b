// The direction from a point to its scanner, as attributes of a cloud that never leave the program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave {

/// The direction to the scanner in two attributes of 16 bits.
/// Cigolle et al.: A Survey of Efficient Representations for Independent Unit Vectors, 2014.
struct ViewCode {
  std::int16_t u = kUnknown;
  std::int16_t v = kUnknown;
  static constexpr std::int16_t kUnknown = -32768;
  bool known() const { return u != kUnknown; }
};
const std::vector<AttributeField>& view_fields();
ViewCode encode_view(Vec3 direction);
/// Within 1e-4 of the unit vector encoded. Precondition: known.
Vec3 decode_view(ViewCode code);
/// Byte offset of the view in an attribute row; nothing where the schema has none.
std::optional<std::size_t> view_offset(const PointSchema& schema);
/// The schema without the view, which its last two attributes hold.
PointSchema without_view(PointSchema schema);

/// Appends the views of a cloud's points to their attributes. Precondition: as many as points.
void add_views(std::span<const ViewCode> views, PointCloud& cloud);
/// Removes the views from the attributes of a cloud that has them.
void drop_views(PointCloud& cloud);
/// The view of a point, `offset` bytes behind the begin of its row.
ViewCode view_of(const PointCloud& cloud, std::size_t point, std::size_t offset);
/// The direction of that view; zero where the scanner is not known.
Vec3 direction_to_scanner(const PointCloud& cloud, std::size_t point, std::size_t offset);
/// Points whose scanner is not known: all of a cloud without views.
std::uint64_t count_without_view(const PointCloud& cloud);

}  // namespace orbweave
