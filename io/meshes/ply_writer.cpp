#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/meshes/attribute_names.h"
#include "io/meshes/mesh_formats.h"
#include "io/ply/intensity_name.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

// "binary_little_endian" below is written as the machine holds it.
static_assert(std::endian::native == std::endian::little);

/// PLY's classic name of a type. It has none for 64-bit integers; "int64" and "uint64" are what
/// most readers that know them at all accept.
const char* ply_type(ScalarType type) {
  constexpr const char* kNames[] = {"char", "uchar", "short",  "ushort", "int",
                                    "uint", "int64", "uint64", "float",  "double"};
  return kNames[static_cast<std::size_t>(type)];
}

/// A name as a word of the header. All bytes stay but those that end a word or a line there.
std::string one_word(std::string name) {
  constexpr std::string_view kBreaks(" \t\n\v\f\r\0", 7);
  for (char& c : name)
    if (kBreaks.find(c) != std::string_view::npos) c = '_';
  return name.empty() ? "_" : name;
}

bool has_field(const std::vector<AttributeField>& attributes, std::string_view name) {
  return std::ranges::find(attributes, name, &AttributeField::name) != attributes.end();
}

/// Viewers take `intensity` for a grey that goes before colours: beside colours it gets a name that
/// is that of a scalar field to them.
PointSchema without_second_color(PointSchema schema) {
  std::vector<AttributeField>& attributes = schema.attributes;
  const bool has_colors = has_field(attributes, "red") && has_field(attributes, "green") &&
                          has_field(attributes, "blue");
  if (!has_colors || has_field(attributes, kScalarIntensity)) return schema;
  for (AttributeField& field : attributes)
    if (field.name == kIntensity) field.name = kScalarIntensity;
  return schema;
}

std::string one_line(std::string comment) {
  for (char& c : comment)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return comment;
}

template <class T>
std::byte* put(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof value);
  return at + sizeof value;
}

/// Counted from `origin`; from 0 numbers stay as they are, bit for bit.
template <class Real>
void put_vectors(const std::vector<Vec3>& vectors, Vec3 origin, std::size_t row_bytes,
                 std::byte* at) {
  for (const Vec3& vector : vectors) {
    const Vec3 v = vector - origin;
    put(put(put(at, static_cast<Real>(v.x)), static_cast<Real>(v.y)), static_cast<Real>(v.z));
    at += row_bytes;
  }
}

void put_vectors(ScalarType type, const std::vector<Vec3>& vectors, Vec3 origin,
                 std::size_t row_bytes, std::byte* at) {
  if (type == ScalarType::kFloat32)
    put_vectors<float>(vectors, origin, row_bytes, at);
  else
    put_vectors<double>(vectors, origin, row_bytes, at);
}

/// Type of a face's corners. Readers take `int` for granted and most know `uint`; beyond that only
/// 64 bits will do.
ScalarType index_type(std::uint64_t vertices) {
  if (vertices <= std::numeric_limits<std::int32_t>::max()) return ScalarType::kInt32;
  return vertices <= std::uint64_t{1} << 32 ? ScalarType::kUint32 : ScalarType::kInt64;
}

/// What a mesh looks like as PLY.
class PlyLayout {
 public:
  PlyLayout(const MeshHeader& header, const MeshWriterOptions& options)
      : header_(header),
        options_(options),
        position_type_(options.float_positions ? ScalarType::kFloat32 : ScalarType::kFloat64),
        index_type_(index_type(header.vertices)),
        attribute_bytes_(header.schema.attribute_bytes()),
        vertex_bytes_(3 * size_of(position_type_) + attribute_bytes_ +
                      (header.schema.has_normals ? 3 * size_of(header.schema.normal_type) : 0)) {}

  std::string front() const {
    std::string text = "ply\nformat ";
    text += options_.binary ? "binary_little_endian" : "ascii";
    text += " 1.0\n";
    for (const std::string& comment : options_.comments) {
      text += "comment " + one_line(comment) + "\n";
    }
    if (options_.origin != Vec3{}) text += "comment origin " + words_of_origin() + "\n";
    text += "element vertex " + std::to_string(header_.vertices) + "\n";
    const auto add_properties = [&](ScalarType type, std::initializer_list<const char*> names) {
      for (const char* name : names)
        text += std::string("property ") + ply_type(type) + " " + name + "\n";
    };
    add_properties(position_type_, {"x", "y", "z"});
    if (header_.schema.has_normals) add_properties(header_.schema.normal_type, {"nx", "ny", "nz"});
    const std::vector<std::string> names =
        attribute_names(without_second_color(header_.schema), one_word);
    for (std::size_t i = 0; i < names.size(); ++i)
      add_properties(header_.schema.attributes[i].type, {names[i].c_str()});
    if (!header_.is_cloud) {
      text += "element face " + std::to_string(header_.triangles) + "\n";
      text += std::string("property list ") + (has_short_faces() ? "uchar " : "int ") +
              ply_type(index_type_) + " vertex_indices\n";
      if (header_.has_hole) text += "property int hole\n";
      if (has_confidence()) text += "property float confidence\n";
    }
    return text + "end_header\n";
  }

  void check_vertices(const PointCloud& batch) const {
    if (batch.schema.attributes != header_.schema.attributes ||
        (header_.schema.has_normals && batch.normals.size() != batch.size()))
      throw std::logic_error("a batch does not have the mesh header's columns");
  }
  void check_triangles(std::size_t triangles, std::size_t holes) const {
    if (header_.has_hole != (holes != 0) && triangles != 0)
      throw std::logic_error("hole ids do not fit the mesh header");
    if (holes != 0 && holes != triangles)
      throw std::logic_error("one hole id per triangle, please");
  }

  std::size_t vertex_bytes() const { return vertex_bytes_; }
  std::size_t triangle_bytes() const {
    return 1 + 3 * size_of(index_type_) + (header_.has_hole ? sizeof(std::int32_t) : 0) +
           (has_confidence() ? sizeof(float) : 0);
  }

  void put_vertices(const PointCloud& batch, std::byte* at) const {
    put_vectors(position_type_, batch.positions, options_.origin, vertex_bytes_, at);
    at += 3 * size_of(position_type_);
    if (header_.schema.has_normals) {
      put_vectors(header_.schema.normal_type, batch.normals, {}, vertex_bytes_, at);
      at += 3 * size_of(header_.schema.normal_type);
    }
    if (attribute_bytes_ == 0) return;
    const std::byte* from = batch.attributes.data();
    for (std::size_t i = 0; i < batch.size(); ++i) {
      std::memcpy(at, from, attribute_bytes_);
      at += vertex_bytes_;
      from += attribute_bytes_;
    }
  }
  void put_triangles(std::span<const Triangle64> batch, std::span<const std::int32_t> hole,
                     std::byte* at) const {
    if (index_type_ == ScalarType::kInt64)
      put_faces<std::uint64_t>(batch, hole, at);
    else
      put_faces<std::uint32_t>(batch, hole, at);
  }

  std::vector<std::byte> text_vertices(const PointCloud& batch) const {
    TextBuilder text;
    text.reserve(batch.size() * 3 * vertex_bytes_);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      add_vector(text, position_type_, batch.positions[i] - options_.origin);
      if (header_.schema.has_normals) {
        text.add(' ');
        add_vector(text, header_.schema.normal_type, batch.normals[i]);
      }
      const std::byte* from = batch.attributes.data() + i * attribute_bytes_;
      for (const AttributeField& field : header_.schema.attributes) {
        text.add(' ');
        text.add_value(field.type, from);
        from += size_of(field.type);
      }
      text.add('\n');
    }
    return text.take();
  }

  std::vector<std::byte> polygons(const PolygonFaces& faces, std::size_t first,
                                  std::size_t end) const {
    const std::size_t corners = faces.begin[end] - faces.begin[first];
    const std::size_t count_bytes = has_short_faces() ? 1 : sizeof(std::int32_t);
    std::vector<std::byte> bytes((end - first) * count_bytes + corners * size_of(index_type_));
    std::byte* at = bytes.data();
    for (std::size_t face = first; face < end; ++face) {
      const auto polygon = faces.of(face);
      at = has_short_faces() ? put(at, static_cast<std::uint8_t>(polygon.size()))
                             : put(at, static_cast<std::int32_t>(polygon.size()));
      for (const std::uint32_t corner : polygon)
        at = index_type_ == ScalarType::kInt64 ? put(at, std::uint64_t{corner}) : put(at, corner);
    }
    return bytes;
  }

  std::vector<std::byte> text_polygons(const PolygonFaces& faces, std::size_t first,
                                       std::size_t end) const {
    TextBuilder text;
    for (std::size_t face = first; face < end; ++face) {
      const auto polygon = faces.of(face);
      text.add_number(polygon.size());
      for (const std::uint32_t corner : polygon) {
        text.add(' ');
        text.add_number(corner);
      }
      text.add('\n');
    }
    return text.take();
  }

  std::vector<std::byte> text_triangles(std::span<const Triangle64> batch,
                                        std::span<const std::int32_t> hole) const {
    TextBuilder text;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      text.add('3');
      for (const std::uint64_t corner : batch[i]) {
        text.add(' ');
        text.add_number(corner);
      }
      if (!hole.empty()) {
        text.add(' ');
        text.add_number(hole[i]);
      }
      if (has_confidence()) {
        const float confidence = confidence_of(hole[i]);
        text.add(' ');
        text.add_value(ScalarType::kFloat32, reinterpret_cast<const std::byte*>(&confidence));
      }
      text.add('\n');
    }
    return text.take();
  }

 private:
  std::string words_of_origin() const {
    const Vec3 o = options_.origin;
    return format_exact(o.x) + " " + format_exact(o.y) + " " + format_exact(o.z);
  }
  bool has_confidence() const { return options_.has_confidence && header_.has_hole; }
  bool has_short_faces() const {
    return header_.most_corners <= std::numeric_limits<std::uint8_t>::max();
  }
  /// Of the patch of a hole; of the scanned surface, which is hole 0, and of what is not known, 1.
  float confidence_of(std::int32_t hole) const {
    const std::vector<float>& known = options_.confidence;
    if (hole < 1 || static_cast<std::size_t>(hole) > known.size()) return 1.0F;
    return known[static_cast<std::size_t>(hole) - 1];
  }

  template <class Index>
  void put_faces(std::span<const Triangle64> batch, std::span<const std::int32_t> hole,
                 std::byte* at) const {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      at = put(at, std::uint8_t{3});
      for (const std::uint64_t corner : batch[i]) at = put(at, static_cast<Index>(corner));
      if (!hole.empty()) at = put(at, hole[i]);
      if (has_confidence()) at = put(at, confidence_of(hole[i]));
    }
  }

  static void add_vector(TextBuilder& text, ScalarType type, Vec3 v) {
    for (int axis = 0; axis < 3; ++axis) {
      if (axis != 0) text.add(' ');
      if (type == ScalarType::kFloat32)
        text.add_number(static_cast<float>(v[axis]));
      else
        text.add_number(v[axis]);
    }
  }

  MeshHeader header_;
  MeshWriterOptions options_;
  ScalarType position_type_;
  ScalarType index_type_;
  std::size_t attribute_bytes_;
  std::size_t vertex_bytes_;
};

class PlyRows final : public MeshRows {
 public:
  PlyRows(const MeshHeader& header, const MeshWriterOptions& options) : layout_(header, options) {}
  std::string front(const Box&) const override { return layout_.front(); }
  std::size_t vertex_bytes() const override { return layout_.vertex_bytes(); }
  std::size_t triangle_bytes() const override { return layout_.triangle_bytes(); }
  void put_vertices(const PointCloud& batch, std::byte* out) const override {
    layout_.check_vertices(batch);
    layout_.put_vertices(batch, out);
  }
  void put_triangles(std::span<const Triangle64> batch, std::span<const std::int32_t> hole,
                     std::byte* out) const override {
    layout_.check_triangles(batch.size(), hole.size());
    layout_.put_triangles(batch, hole, out);
  }

 private:
  PlyLayout layout_;
};

class PlyWriter final : public IndependentWriter {
 public:
  PlyWriter(std::unique_ptr<ByteSink> sink, const MeshHeader& header,
            const MeshWriterOptions& options)
      : IndependentWriter(std::move(sink), header),
        binary_(options.binary),
        layout_(header, options) {
    this->sink().write(layout_.front());
  }

  std::vector<std::byte> encode_vertices(const PointCloud& batch) const override {
    layout_.check_vertices(batch);
    if (!binary_) return layout_.text_vertices(batch);
    std::vector<std::byte> bytes(batch.size() * layout_.vertex_bytes());
    if (!bytes.empty()) layout_.put_vertices(batch, bytes.data());
    return bytes;
  }
  std::vector<std::byte> encode_triangles(std::span<const Triangle64> batch,
                                          std::span<const std::int32_t> hole) const override {
    layout_.check_triangles(batch.size(), hole.size());
    if (!binary_) return layout_.text_triangles(batch, hole);
    std::vector<std::byte> bytes(batch.size() * layout_.triangle_bytes());
    layout_.put_triangles(batch, hole, bytes.data());
    return bytes;
  }

 protected:
  std::vector<std::byte> encode_polygons(const PolygonFaces& faces, std::size_t first,
                                         std::size_t end) const override {
    return binary_ ? layout_.polygons(faces, first, end) : layout_.text_polygons(faces, first, end);
  }

 private:
  bool binary_;
  PlyLayout layout_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_ply_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options) {
  return std::make_unique<PlyWriter>(std::move(sink), header, options);
}

std::unique_ptr<MeshRows> make_ply_rows(const MeshHeader& header,
                                        const MeshWriterOptions& options) {
  return std::make_unique<PlyRows>(header, options);
}

}  // namespace orbweave
