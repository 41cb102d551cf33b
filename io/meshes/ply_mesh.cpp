#include "io/meshes/ply_mesh.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/ply/ply_vertices.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchRows = std::size_t{1} << 14;

bool is_integer(ScalarType type) {
  return type != ScalarType::kFloat32 && type != ScalarType::kFloat64;
}

/// The face property "hole", where there is one of an integer type.
const RowColumn* find_hole(const std::vector<RowColumn>& columns) {
  const auto at = std::find_if(columns.begin(), columns.end(), [](const RowColumn& column) {
    return column.name == "hole" && is_integer(column.type);
  });
  return at == columns.end() ? nullptr : &*at;
}

/// Appends faces to a mesh, as triangles.
class FaceReader {
 public:
  FaceReader(ByteReader& reader, const PlyHeader& header, const PlyElement& faces,
             std::size_t corner_list, std::uint64_t vertices, TriangleMesh& mesh)
      : reader_(reader),
        faces_(faces),
        vertices_(vertices),
        mesh_(mesh),
        rows_(reader, header, faces, corner_list),
        hole_(find_hole(rows_.columns())) {}

  void read_all() {
    while (const std::size_t count = rows_.next(kBatchRows)) {
      const std::int64_t* corners = rows_.list_values().data();
      for (std::size_t row = 0; row < count; ++row) {
        const std::uint32_t size = rows_.list_sizes()[row];
        add_face(corners, size, count - row);
        if (hole_ != nullptr && size > 2)
          mesh_.hole.insert(mesh_.hole.end(), size - 2, hole_of(rows_.rows(), row));
        corners += size;
      }
    }
  }

 private:
  void add_face(const std::int64_t* corners, std::uint32_t size, std::size_t rows_behind) {
    for (std::uint32_t i = 0; i < size; ++i) {
      if (corners[i] < 0 || static_cast<std::uint64_t>(corners[i]) >= vertices_)
        throw_bad_input(
            "a face names a vertex that is not there",
            {.file = reader_.name(),
             .place = "face " + std::to_string(faces_.count - rows_.rows_left() - rows_behind),
             .found = "vertex " + std::to_string(corners[i]),
             .expected = "0 to " + std::to_string(vertices_) + " (excluded)"});
    }
    const auto corner = [&](std::uint32_t i) { return static_cast<std::uint32_t>(corners[i]); };
    for (std::uint32_t i = 2; i < size; ++i)
      mesh_.triangles.push_back({corner(0), corner(i - 1), corner(i)});
  }

  std::int32_t hole_of(const std::byte* rows, std::size_t row) const {
    const std::byte* at = rows + row * rows_.row_bytes() + hole_->offset;
    return static_cast<std::int32_t>(ply_integer(hole_->type, at, rows_.swapped()));
  }

  ByteReader& reader_;
  const PlyElement& faces_;
  std::uint64_t vertices_;
  TriangleMesh& mesh_;
  PlyRowReader rows_;
  const RowColumn* hole_;
};

void read_vertices(ByteReader& reader, const PlyHeader& header, const PlyElement& element,
                   PointCloud& vertices) {
  PlyVertexReader rows(reader, header, element);
  vertices.schema = rows.schema();
  PointCloud batch;
  while (rows.read(batch, kBatchRows)) vertices.append(batch);
}

}  // namespace

TriangleMesh read_ply_mesh(ByteReader reader) {
  const PlyHeader header = read_ply_header(reader);
  const PlyElement* vertices = header.find("vertex");
  if (vertices == nullptr)
    throw_bad_input("the PLY header has no vertices",
                    {.file = reader.name(), .expected = "an element \"vertex\""});
  if (vertices->count > std::numeric_limits<std::uint32_t>::max())
    throw_bad_input("too many vertices for a mesh in memory",
                    {.file = reader.name(),
                     .found = std::to_string(vertices->count),
                     .expected = "at most 4294967295"});
  check_ply_length(reader, header);
  TriangleMesh mesh;
  for (const PlyElement& element : header.elements) {
    const auto corners = element.name == "face" ? find_corner_list(element) : std::nullopt;
    if (&element == vertices)
      read_vertices(reader, header, element, mesh.vertices);
    else if (corners)
      FaceReader(reader, header, element, *corners, vertices->count, mesh).read_all();
    else
      PlyRowReader(reader, header, element).skip();
  }
  check_ply_end(reader, header.elements.back());
  return mesh;
}

bool ply_holds_faces(ByteReader reader) {
  const PlyHeader header = read_ply_header(reader);
  const PlyElement* faces = header.find("face");
  return faces != nullptr && faces->count != 0 && find_corner_list(*faces).has_value();
}

}  // namespace orbweave
