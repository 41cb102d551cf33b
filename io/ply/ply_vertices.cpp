#include "io/ply/ply_vertices.h"

#include <string_view>

#include "io/error.h"

namespace orbweave {

PlyVertexReader::PlyVertexReader(ByteReader& reader, const PlyHeader& header,
                                 const PlyElement& vertices)
    : rows_(reader, header, vertices),
      layout_(rows_.columns(), rows_.row_bytes(), rows_.swapped()) {
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
  if (!reader.ensure(kMagic.size() + 1)) return false;
  const std::string_view front(reinterpret_cast<const char*>(reader.data()), kMagic.size() + 1);
  return front.substr(0, kMagic.size()) == kMagic && front.back() <= ' ';
}

}  // namespace orbweave
