#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/mesh_formats.h"

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

std::string one_word(std::string name) {
  for (char& c : name)
    if (c <= ' ' || c > '~') c = '_';
  return name.empty() ? "_" : name;
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

template <class Real>
void put_vectors(const std::vector<Vec3>& vectors, std::size_t row_bytes, std::byte* at) {
  for (const Vec3& v : vectors) {
    put(put(put(at, static_cast<Real>(v.x)), static_cast<Real>(v.y)), static_cast<Real>(v.z));
    at += row_bytes;
  }
}

void put_vectors(ScalarType type, const std::vector<Vec3>& vectors, std::size_t row_bytes,
                 std::byte* at) {
  if (type == ScalarType::kFloat32)
    put_vectors<float>(vectors, row_bytes, at);
  else
    put_vectors<double>(vectors, row_bytes, at);
}

class PlyWriter final : public IndependentWriter {
 public:
  PlyWriter(std::unique_ptr<ByteSink> sink, const MeshHeader& header,
            const MeshWriterOptions& options)
      : IndependentWriter(std::move(sink), header),
        header_(header),
        binary_(options.binary),
        position_type_(options.float_positions ? ScalarType::kFloat32 : ScalarType::kFloat64),
        attribute_bytes_(header.schema.attribute_bytes()) {
    if (!header.is_cloud && header.vertices > std::uint64_t{1} << 32)
      throw_usage("PLY has no type for the indices of so many vertices",
                  {.found = std::to_string(header.vertices), .expected = "at most 4294967296"});
    // Readers take `int` for granted; beyond its range only `uint` will do.
    wide_index_ = header.vertices > std::numeric_limits<std::int32_t>::max();
    vertex_bytes_ = 3 * size_of(position_type_) + attribute_bytes_ +
                    (header.schema.has_normals ? 3 * size_of(header.schema.normal_type) : 0);
    this->sink().write(header_text(options.comments));
  }

  std::vector<std::byte> encode_vertices(const PointCloud& batch) const override {
    check_schema(batch);
    return binary_ ? binary_vertices(batch) : text_vertices(batch);
  }
  std::vector<std::byte> encode_triangles(std::span<const Triangle64> batch,
                                          std::span<const std::int32_t> hole) const override {
    if (header_.has_hole != !hole.empty() && !batch.empty())
      throw std::logic_error("hole ids do not fit the mesh header");
    if (!hole.empty() && hole.size() != batch.size())
      throw std::logic_error("one hole id per triangle, please");
    return binary_ ? binary_triangles(batch, hole) : text_triangles(batch, hole);
  }

 private:
  std::string header_text(const std::vector<std::string>& comments) const {
    std::string text = "ply\nformat ";
    text += binary_ ? "binary_little_endian" : "ascii";
    text += " 1.0\n";
    for (const std::string& comment : comments) text += "comment " + one_line(comment) + "\n";
    text += "element vertex " + std::to_string(header_.vertices) + "\n";
    const auto add_properties = [&](ScalarType type, std::initializer_list<const char*> names) {
      for (const char* name : names)
        text += std::string("property ") + ply_type(type) + " " + name + "\n";
    };
    add_properties(position_type_, {"x", "y", "z"});
    if (header_.schema.has_normals) add_properties(header_.schema.normal_type, {"nx", "ny", "nz"});
    for (const AttributeField& field : header_.schema.attributes)
      add_properties(field.type, {one_word(field.name).c_str()});
    if (!header_.is_cloud) {
      text += "element face " + std::to_string(header_.triangles) + "\n";
      text += std::string("property list uchar ") + (wide_index_ ? "uint" : "int") +
              " vertex_indices\n";
      if (header_.has_hole) text += "property int hole\n";
    }
    return text + "end_header\n";
  }

  void check_schema(const PointCloud& batch) const {
    if (batch.schema.attributes != header_.schema.attributes ||
        (header_.schema.has_normals && batch.normals.size() != batch.size()))
      throw std::logic_error("a batch does not have the mesh header's columns");
  }

  std::vector<std::byte> binary_vertices(const PointCloud& batch) const {
    std::vector<std::byte> bytes(batch.size() * vertex_bytes_);
    if (bytes.empty()) return bytes;
    std::byte* at = bytes.data();
    put_vectors(position_type_, batch.positions, vertex_bytes_, at);
    at += 3 * size_of(position_type_);
    if (header_.schema.has_normals) {
      put_vectors(header_.schema.normal_type, batch.normals, vertex_bytes_, at);
      at += 3 * size_of(header_.schema.normal_type);
    }
    if (attribute_bytes_ == 0) return bytes;
    const std::byte* from = batch.attributes.data();
    for (std::size_t i = 0; i < batch.size(); ++i) {
      std::memcpy(at, from, attribute_bytes_);
      at += vertex_bytes_;
      from += attribute_bytes_;
    }
    return bytes;
  }

  std::vector<std::byte> binary_triangles(std::span<const Triangle64> batch,
                                          std::span<const std::int32_t> hole) const {
    constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::uint32_t);
    const std::size_t row = kFaceBytes + (hole.empty() ? 0 : sizeof(std::int32_t));
    std::vector<std::byte> bytes(batch.size() * row);
    std::byte* at = bytes.data();
    for (std::size_t i = 0; i < batch.size(); ++i) {
      at = put(at, std::uint8_t{3});
      for (const std::uint64_t corner : batch[i]) at = put(at, static_cast<std::uint32_t>(corner));
      if (!hole.empty()) at = put(at, hole[i]);
    }
    return bytes;
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

  std::vector<std::byte> text_vertices(const PointCloud& batch) const {
    TextBuilder text;
    text.reserve(batch.size() * 3 * vertex_bytes_);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      add_vector(text, position_type_, batch.positions[i]);
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

  static std::vector<std::byte> text_triangles(std::span<const Triangle64> batch,
                                               std::span<const std::int32_t> hole) {
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
      text.add('\n');
    }
    return text.take();
  }

  MeshHeader header_;
  bool binary_;
  ScalarType position_type_;
  std::size_t attribute_bytes_;
  bool wide_index_ = false;
  std::size_t vertex_bytes_ = 0;
};

}  // namespace

std::unique_ptr<MeshWriter> make_ply_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options) {
  return std::make_unique<PlyWriter>(std::move(sink), header, options);
}

}  // namespace orbweave
