#include "io/meshes/ply_mesh.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/ply/ply_left_out.h"
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
        hole_(find_hole(rows_.columns())) {
    if (hole_ != nullptr) mesh_.hole.resize(mesh_.triangles.size());  // strips tell of none
  }

  void read_all() {
    while (const std::size_t count = rows_.next(kBatchRows)) {
      const std::int64_t* corners = rows_.list_values().data();
      for (std::size_t row = 0; row < count; ++row) {
        const std::uint32_t size = rows_.list_sizes()[row];
        add_face(corners, size, count - row);
        if (size < 3) ++faces_left_out_;
        if (hole_ != nullptr && size > 2)
          mesh_.hole.insert(mesh_.hole.end(), size - 2, hole_of(row, count - row));
        corners += size;
      }
    }
  }
  /// Faces that are no surface.
  std::uint64_t faces_left_out() const { return faces_left_out_; }

 private:
  void add_face(const std::int64_t* corners, std::uint32_t size, std::size_t rows_behind) {
    for (std::uint32_t i = 0; i < size; ++i) {
      if (corners[i] < 0 || static_cast<std::uint64_t>(corners[i]) >= vertices_)
        throw_bad_input("a face names a vertex that is not there",
                        {.file = reader_.name(),
                         .place = "face " + std::to_string(number_of(rows_behind)),
                         .found = "vertex " + std::to_string(corners[i]),
                         .expected = "0 to " + std::to_string(vertices_) + " (excluded)"});
    }
    const auto corner = [&](std::uint32_t i) { return static_cast<std::uint32_t>(corners[i]); };
    for (std::uint32_t i = 2; i < size; ++i)
      mesh_.triangles.push_back({corner(0), corner(i - 1), corner(i)});
  }

  std::int32_t hole_of(std::size_t row, std::size_t rows_behind) const {
    const std::byte* at = rows_.rows() + row * rows_.row_bytes() + hole_->offset;
    return ply_hole(hole_->type, at, rows_.swapped(), reader_.name(), number_of(rows_behind));
  }

  std::uint64_t number_of(std::size_t rows_behind) const {
    return faces_.count - rows_.rows_left() - rows_behind;
  }

  ByteReader& reader_;
  const PlyElement& faces_;
  std::uint64_t vertices_;
  TriangleMesh& mesh_;
  PlyRowReader rows_;
  const RowColumn* hole_;
  std::uint64_t faces_left_out_ = 0;
};

/// Appends the triangles of strips to a mesh. Those with two equal corners lead from one strip to
/// the next and are no surface.
class StripReader {
 public:
  StripReader(ByteReader& reader, const PlyHeader& header, const PlyElement& strips,
              std::size_t corner_list, std::uint64_t vertices, TriangleMesh& mesh)
      : reader_(reader),
        vertices_(vertices),
        mesh_(mesh),
        rows_(reader, header, strips, corner_list) {}

  void read_all() {
    while (const std::size_t count = rows_.next(kBatchRows)) {
      std::span<const std::int64_t> corners = rows_.list_values();
      for (std::size_t row = 0; row < count; ++row) {
        const std::uint32_t size = rows_.list_sizes()[row];
        add_strips(corners.first(size));
        corners = corners.subspan(size);
      }
    }
  }

 private:
  void add_strips(std::span<const std::int64_t> corners) {
    constexpr std::int64_t kEndOfStrip = -1;
    std::size_t length = 0;  // of the strip so far
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (corners[i] == kEndOfStrip) {
        length = 0;
        continue;
      }
      check(corners[i]);
      if (++length > 2) add_triangle(corners.subspan(i - 2, 3), length % 2 == 0);
    }
  }

  void add_triangle(std::span<const std::int64_t> corners, bool turned_over) {
    Triangle t = {static_cast<std::uint32_t>(corners[0]), static_cast<std::uint32_t>(corners[1]),
                  static_cast<std::uint32_t>(corners[2])};
    if (t[0] == t[1] || t[1] == t[2] || t[0] == t[2]) return;
    if (turned_over) std::swap(t[0], t[1]);
    mesh_.triangles.push_back(t);
  }

  void check(std::int64_t corner) const {
    if (corner >= 0 && static_cast<std::uint64_t>(corner) < vertices_) return;
    throw_bad_input("a triangle strip names a vertex that is not there",
                    {.file = reader_.name(),
                     .place = "element tristrips",
                     .found = "vertex " + std::to_string(corner),
                     .expected = "0 to " + std::to_string(vertices_) +
                                 " (excluded), or -1 at the end of a strip"});
  }

  ByteReader& reader_;
  std::uint64_t vertices_;
  TriangleMesh& mesh_;
  PlyRowReader rows_;
};

void read_vertices(ByteReader& reader, const PlyHeader& header, const PlyElement& element,
                   PointCloud& vertices) {
  PlyVertexReader rows(reader, header, element);
  vertices.schema = rows.schema();
  PointCloud batch;
  while (rows.read(batch, kBatchRows)) vertices.append(batch);
}

/// Returns how many faces are no surface.
std::uint64_t read_faces(ByteReader& reader, const PlyHeader& header, const PlyElement& element,
                         std::size_t corner_list, std::uint64_t vertices, TriangleMesh& mesh) {
  FaceReader faces(reader, header, element, corner_list, vertices, mesh);
  faces.read_all();
  return faces.faces_left_out();
}

}  // namespace

std::int32_t ply_hole(ScalarType type, const std::byte* value, bool is_swapped,
                      const std::string& file, std::uint64_t face) {
  using Limits = std::numeric_limits<std::int32_t>;
  const std::int64_t hole = ply_integer(type, value, is_swapped);
  const bool wraps = type == ScalarType::kUint64 && hole < 0;
  if (hole >= Limits::min() && hole <= Limits::max() && !wraps)
    return static_cast<std::int32_t>(hole);
  throw_bad_input(
      "the id of a hole does not fit 32 bits",
      {.file = file,
       .place = "face " + std::to_string(face),
       .found = wraps ? std::to_string(static_cast<std::uint64_t>(hole)) : std::to_string(hole),
       .expected = "at most " + std::to_string(Limits::max()),
       .advice = "Write the mesh without the property hole, or with smaller ids."});
}

TriangleMesh read_ply_mesh(ByteReader reader, std::vector<std::string>* left_out) {
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
  std::uint64_t faces_left_out = 0;
  for (const PlyElement& element : header.elements) {
    const auto corners = find_corner_list(element);
    if (&element == vertices)
      read_vertices(reader, header, element, mesh.vertices);
    else if (corners && are_strips(element))
      StripReader(reader, header, element, *corners, vertices->count, mesh).read_all();
    else if (corners)
      faces_left_out += read_faces(reader, header, element, *corners, vertices->count, mesh);
    else
      PlyRowReader(reader, header, element).skip();
  }
  if (!mesh.hole.empty()) mesh.hole.resize(mesh.triangles.size());
  if (left_out != nullptr) {
    *left_out = left_out_of_ply(header, true);
    for (std::string& faces : left_out_faces(faces_left_out)) left_out->push_back(std::move(faces));
  }
  check_ply_end(reader, header.elements.back());
  return mesh;
}

bool ply_holds_faces(ByteReader reader) {
  const PlyHeader header = read_ply_header(reader);
  return std::ranges::any_of(header.elements, [](const PlyElement& element) {
    return element.count != 0 && find_corner_list(element).has_value();
  });
}

}  // namespace orbweave
