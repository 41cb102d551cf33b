#include "io/meshes/mesh_stream.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/ply_mesh.h"
#include "io/meshes/shift_file.h"
#include "io/ply/ply_left_out.h"
#include "io/ply/ply_vertices.h"
#include "io/streams/byte_source.h"

namespace orbweave {
namespace {

[[noreturn]] void refuse_cloud(const std::filesystem::path& path) {
  require_read_format(path);
  throw_bad_input("is no mesh: it has no faces",
                  {.file = path.string(),
                   .expected = "a .ply, .obj, .stl or .glb file with faces",
                   .advice = "'orbweave reconstruct' makes a mesh of a cloud."});
}

/// A mesh in memory.
class HeldMesh final : public MeshStream {
 public:
  explicit HeldMesh(const std::filesystem::path& path) : mesh_(read_mesh(path, &left_out_)) {}
  const PointSchema& schema() const override { return mesh_.vertices.schema; }
  std::uint64_t vertices() const override { return mesh_.vertices.size(); }
  std::uint64_t faces() const override { return mesh_.triangles.size(); }

  bool read_vertices(PointCloud& batch, std::size_t capacity) override {
    batch.clear();
    batch.schema = schema();
    for (; batch.size() < capacity && vertex_ < vertices(); ++vertex_)
      batch.append(mesh_.vertices, vertex_);
    return !batch.empty();
  }
  bool read_triangles(std::vector<Triangle64>& batch, std::size_t capacity) override {
    batch.clear();
    patches_.clear();
    for (; batch.size() < capacity && triangle_ < faces(); ++triangle_) {
      const Triangle& t = mesh_.triangles[triangle_];
      batch.push_back({t[0], t[1], t[2]});
      if (has_holes()) patches_.push_back({mesh_.hole[triangle_], 1.0F});
    }
    return !batch.empty();
  }
  bool has_holes() const override { return !mesh_.hole.empty(); }
  std::span<const FacePatch> patches() const override { return patches_; }
  std::vector<std::string> left_out() const override { return left_out_; }

 private:
  std::vector<std::string> left_out_;
  TriangleMesh mesh_;
  std::vector<FacePatch> patches_;
  std::size_t vertex_ = 0;
  std::size_t triangle_ = 0;
};

/// The places of a PLY file's vertices and faces among its elements, where they come in this order.
struct PlyMeshElements {
  std::size_t vertex = 0;
  std::size_t face = 0;
  std::size_t corner_list = 0;
};

std::optional<PlyMeshElements> streamed_elements(const PlyHeader& header) {
  std::optional<PlyMeshElements> found;
  std::optional<std::size_t> vertex;
  for (std::size_t i = 0; i < header.elements.size(); ++i) {
    const PlyElement& element = header.elements[i];
    if (element.name == "vertex" && !vertex) vertex = i;
    const auto corners = find_corner_list(element);
    if (!corners || element.count == 0) continue;
    // Strips are held whole by their rows; one element of faces is what is streamed.
    if (!vertex || found || are_strips(element)) return std::nullopt;
    found = PlyMeshElements{*vertex, i, *corners};
  }
  return found;
}

/// The properties of faces that tell of patches.
class PatchColumns {
 public:
  PatchColumns() = default;
  explicit PatchColumns(const std::vector<RowColumn>& columns) {
    for (const RowColumn& column : columns) {
      if (column.name == "hole" && !is_real(column.type)) hole_ = column;
      if (column.name == "confidence" && is_real(column.type)) confidence_ = column;
    }
  }
  bool has_holes() const { return hole_.has_value(); }
  bool has_confidence() const { return has_holes() && confidence_.has_value(); }

  /// Of a packed row. What is no number from 0 to 1 counts as not known. `file`, `face`: for the
  /// message about an id that is too large.
  FacePatch of(const std::byte* row, bool is_swapped, const std::string& file,
               std::uint64_t face) const {
    FacePatch patch;
    patch.hole = ply_hole(hole_->type, row + hole_->offset, is_swapped, file, face);
    if (has_confidence()) {
      const double value = real(confidence_->type, row + confidence_->offset, is_swapped);
      if (value >= 0.0 && value <= 1.0) patch.confidence = static_cast<float>(value);
    }
    return patch;
  }

 private:
  static bool is_real(ScalarType type) {
    return type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
  }
  static double real(ScalarType type, const std::byte* at, bool is_swapped) {
    if (type == ScalarType::kFloat64)
      return std::bit_cast<double>(ply_integer(ScalarType::kInt64, at, is_swapped));
    const std::int64_t bits = ply_integer(ScalarType::kUint32, at, is_swapped);
    return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
  }

  std::optional<RowColumn> hole_;
  std::optional<RowColumn> confidence_;
};

PatchColumns patch_columns_of(const PlyElement& faces) {
  std::vector<RowColumn> columns;
  for (const PlyProperty& property : faces.properties)
    if (!property.is_list) columns.push_back({property.name, property.type, 0});
  return PatchColumns(columns);
}

/// The vertices and faces of a PLY file whose faces come after its vertices.
class PlyMeshStream final : public MeshStream {
 public:
  /// The reader stands behind the header.
  PlyMeshStream(ByteReader reader, PlyHeader header, const PlyMeshElements& at, Vec3 origin)
      : reader_(std::move(reader)), header_(std::move(header)), at_(at), origin_(origin) {
    check_ply_length(reader_, header_);
    for (std::size_t i = 0; i < at_.vertex; ++i) skip(i);
    vertex_rows_.emplace(reader_, header_, header_.elements[at_.vertex]);
    schema_ = vertex_rows_->schema();
    if (origin != Vec3{}) schema_.position_type = ScalarType::kFloat64;
    patch_columns_ = patch_columns_of(header_.elements[at_.face]);
  }
  const PointSchema& schema() const override { return schema_; }
  std::uint64_t vertices() const override { return header_.elements[at_.vertex].count; }
  std::uint64_t faces() const override { return header_.elements[at_.face].count; }

  bool read_vertices(PointCloud& batch, std::size_t capacity) override {
    const bool any = vertex_rows_->read(batch, capacity);
    add_origin(origin_, batch);
    return any;
  }
  bool read_triangles(std::vector<Triangle64>& batch, std::size_t capacity) override {
    batch.clear();
    patches_.clear();
    if (!face_rows_) begin_faces();
    while (batch.empty()) {
      const std::size_t count = face_rows_->next(capacity);
      if (count == 0) return finish();
      add_faces(count, batch);
    }
    return true;
  }
  bool has_holes() const override { return patch_columns_.has_holes(); }
  bool has_confidence() const override { return patch_columns_.has_confidence(); }
  std::span<const FacePatch> patches() const override { return patches_; }
  std::vector<std::string> left_out() const override {
    std::vector<std::string> all = left_out_of_ply(header_, true);
    for (std::string& faces : left_out_faces(faces_left_out_)) all.push_back(std::move(faces));
    return all;
  }

 private:
  void skip(std::size_t element) {
    PlyRowReader(reader_, header_, header_.elements[element]).skip();
  }
  void begin_faces() {
    for (std::size_t i = at_.vertex + 1; i < at_.face; ++i) skip(i);
    face_rows_.emplace(reader_, header_, header_.elements[at_.face], at_.corner_list);
    patch_columns_ = PatchColumns(face_rows_->columns());
  }
  bool finish() {
    if (std::exchange(is_finished_, true)) return false;
    for (std::size_t i = at_.face + 1; i < header_.elements.size(); ++i) skip(i);
    check_ply_end(reader_, header_.elements.back());
    return false;
  }
  void add_faces(std::size_t count, std::vector<Triangle64>& batch) {
    const std::int64_t* corners = face_rows_->list_values().data();
    for (std::size_t row = 0; row < count; ++row) {
      const std::uint32_t size = face_rows_->list_sizes()[row];
      check(std::span(corners, size), row, count);
      const auto corner = [&](std::uint32_t i) { return static_cast<std::uint64_t>(corners[i]); };
      for (std::uint32_t i = 2; i < size; ++i)
        batch.push_back({corner(0), corner(i - 1), corner(i)});
      if (size < 3) ++faces_left_out_;
      if (has_holes() && size > 2)
        patches_.insert(
            patches_.end(), size - 2,
            patch_columns_.of(face_rows_->rows() + row * face_rows_->row_bytes(),
                              face_rows_->swapped(), reader_.name(), number_of(row, count)));
      corners += size;
    }
  }
  void check(std::span<const std::int64_t> corners, std::size_t row, std::size_t count) const {
    for (const std::int64_t corner : corners) {
      if (corner >= 0 && static_cast<std::uint64_t>(corner) < vertices()) continue;
      throw_bad_input("a face names a vertex that is not there",
                      {.file = reader_.name(),
                       .place = "face " + std::to_string(number_of(row, count)),
                       .found = "vertex " + std::to_string(corner),
                       .expected = "0 to " + std::to_string(vertices()) + " (excluded)"});
    }
  }

  /// Of a row among the `count` rows that were read last.
  std::uint64_t number_of(std::size_t row, std::size_t count) const {
    return faces() - face_rows_->rows_left() - count + row;
  }

  ByteReader reader_;
  PlyHeader header_;
  PlyMeshElements at_;
  Vec3 origin_;
  PointSchema schema_;
  std::optional<PlyVertexReader> vertex_rows_;
  std::optional<PlyRowReader> face_rows_;
  PatchColumns patch_columns_;
  std::vector<FacePatch> patches_;
  std::uint64_t faces_left_out_ = 0;
  bool is_finished_ = false;
};

/// Null where the file is no PLY file that can be streamed.
std::unique_ptr<MeshStream> streamed(const std::filesystem::path& path) {
  ByteReader reader(open_byte_source(path));
  return looks_like_ply(reader) ? ply_mesh_stream(std::move(reader), origin_beside(path)) : nullptr;
}

}  // namespace

std::unique_ptr<MeshStream> ply_mesh_stream(ByteReader reader, Vec3 origin) {
  PlyHeader header = read_ply_header(reader);
  const std::optional<PlyMeshElements> at = streamed_elements(header);
  if (!at) return nullptr;
  return std::make_unique<PlyMeshStream>(std::move(reader), std::move(header), *at, origin);
}

std::unique_ptr<MeshStream> open_mesh_stream(const std::filesystem::path& path) {
  if (!holds_faces(path)) refuse_cloud(path);
  if (std::unique_ptr<MeshStream> stream = streamed(path)) return stream;
  return std::make_unique<HeldMesh>(path);
}

namespace {

/// Hands over what each triangle tells of its patch; nothing where faces have no confidence.
template <class Take>
void read_patches(const std::filesystem::path& path, const Take& take) {
  constexpr std::size_t kBatch = std::size_t{1} << 16;
  const auto stream = open_mesh_stream(path);
  if (!stream->has_confidence()) return;
  for (PointCloud batch; stream->read_vertices(batch, kBatch);) {
  }
  for (std::vector<Triangle64> batch; stream->read_triangles(batch, kBatch);)
    for (const FacePatch& patch : stream->patches()) take(patch);
}

}  // namespace

std::vector<float> face_confidence(const std::filesystem::path& path) {
  std::vector<float> confidence;
  read_patches(path, [&](const FacePatch& patch) { confidence.push_back(patch.confidence); });
  return confidence;
}

std::map<std::int32_t, float> hole_confidence(const std::filesystem::path& path) {
  std::map<std::int32_t, float> confidence;
  read_patches(path, [&](const FacePatch& patch) {
    if (patch.hole > 0) confidence[patch.hole] = patch.confidence;
  });
  return confidence;
}

}  // namespace orbweave
