#include "io/ply/ply_vertices.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "io/byte_order_mark.h"
#include "io/error.h"
#include "io/ply/intensity_name.h"
#include "io/points/column_roles.h"

namespace orbweave {
namespace {

/// Under the names of their roles, and those that the attributes had before they were written.
std::vector<RowColumn> with_own_names(std::vector<RowColumn> columns) {
  name_by_roles(columns);
  const auto named = [&](const char* name) {
    return std::ranges::find(columns, name, &RowColumn::name);
  };
  const auto intensity = named(kScalarIntensity);
  if (intensity != columns.end() && named(kIntensity) == columns.end())
    intensity->name = kIntensity;
  return columns;
}

}  // namespace

PlyVertexReader::PlyVertexReader(ByteReader& reader, const PlyHeader& header,
                                 const PlyElement& vertices)
    : rows_(reader, header, vertices),
      layout_(with_own_names(rows_.columns()), rows_.row_bytes(), rows_.swapped()) {
  if (!layout_.missing().empty())
    throw_bad_input(
        "the vertices have no property " + layout_.missing(),
        {.file = reader.name(), .place = "element vertex", .expected = "properties x, y and z"});
}

bool PlyVertexReader::read(PointCloud& batch, std::size_t capacity) {
  batch.clear();
  batch.schema = layout_.schema();
  while (batch.size() < capacity) {
    const std::size_t count = rows_.next(capacity - batch.size());
    if (count == 0) break;
    layout_.append(rows_.rows(), count, batch);
  }
  return !batch.empty();
}

bool looks_like_ply(ByteReader& reader) {
  constexpr std::string_view kMagic = "ply";
  const std::size_t most = kByteOrderMark.size() + kMagic.size() + 1;
  reader.ensure(most);
  const std::string_view front = without_byte_order_mark(
      {reinterpret_cast<const char*>(reader.data()), std::min(reader.available(), most)});
  return front.size() > kMagic.size() && front.starts_with(kMagic) && front[kMagic.size()] <= ' ';
}

}  // namespace orbweave
