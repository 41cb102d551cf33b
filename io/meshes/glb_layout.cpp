#include "io/meshes/glb_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "io/text/json_dump.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

// Numbers of the specification.
constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"
constexpr int kFloat = 5126;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr std::size_t kFileHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;

constexpr std::size_t kVectorBytes = 3 * sizeof(float);
constexpr std::size_t kColorBytes = 4 * sizeof(std::uint16_t);

void append_word(std::string& bytes, std::uint32_t word) {
  bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

std::array<float, 3> floats_of(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// The exact value of a float, or the longest text that one can have.
Json bound_of(double value, bool is_known) {
  constexpr double kLongest = -1.1754943508222875e-38;  // the smallest normal float: 24 characters
  return is_known ? static_cast<double>(static_cast<float>(value)) : kLongest;
}

Json vector_of(Vec3 v, bool is_known) {
  return {bound_of(v.x, is_known), bound_of(v.y, is_known), bound_of(v.z, is_known)};
}

/// Column by column: turns the axis that is upright to y, then moves the origin to its place.
Json node_matrix(int up_axis, Vec3 origin) {
  using Row = std::array<double, 3>;
  std::array<Row, 3> rows = {Row{1, 0, 0}, Row{0, 1, 0}, Row{0, 0, 1}};
  if (up_axis == 0) rows = {Row{0, -1, 0}, Row{1, 0, 0}, Row{0, 0, 1}};
  if (up_axis == 2) rows = {Row{1, 0, 0}, Row{0, 0, 1}, Row{0, -1, 0}};
  Json matrix = Json::array();
  for (std::size_t column = 0; column < 3; ++column) {
    for (const Row& row : rows) matrix.push_back(row[column]);
    matrix.push_back(0.0);
  }
  for (const Row& row : rows) {
    // Adding zero makes 0 of -0.
    matrix.push_back(row[0] * origin.x + row[1] * origin.y + row[2] * origin.z + 0.0);
  }
  matrix.push_back(1.0);
  return matrix;
}

/// Light of an sRGB value, IEC 61966-2-1, as a fraction of 65535.
std::uint16_t linear_fraction(double srgb) {
  const double linear = srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
  return static_cast<std::uint16_t>(std::lround(linear * 65535.0));
}

std::uint16_t linear_fraction(VertexColors::Channel channel) {
  static const auto kOfBytes = [] {
    std::array<std::uint16_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i)
      table[i] = linear_fraction(static_cast<double>(i) / 255.0);
    return table;
  }();
  return channel.most == 255 ? kOfBytes[channel.value]
                             : linear_fraction(static_cast<double>(channel.value) / 65535.0);
}

/// Of unit length, as glTF asks for; a point without a direction gets +z. Starts from the floats
/// that a PLY file has, so that a job and a conversion of its PLY file write the same bytes.
Vec3 unit_normal(Vec3 normal, ScalarType type) {
  if (type == ScalarType::kFloat32) {
    const std::array<float, 3> narrow = floats_of(normal);
    normal = {narrow[0], narrow[1], narrow[2]};
  }
  const double length = norm(normal);
  const bool has_direction = length > 0.0 && std::isfinite(length);
  return has_direction ? (1.0 / length) * normal : Vec3{0.0, 0.0, 1.0};
}

Json accessor(int view, int component_type, const char* type, std::uint64_t count) {
  return {
      {"bufferView", view}, {"componentType", component_type}, {"count", count}, {"type", type}};
}

Json at_byte(Json accessor, std::size_t offset) {
  if (offset > 0) accessor["byteOffset"] = offset;
  return accessor;
}

constexpr const char* kPacking = "EXT_meshopt_compression";
constexpr std::size_t kAlignment = 4;

std::size_t aligned(std::size_t bytes) {
  return bytes + (kAlignment - bytes % kAlignment) % kAlignment;
}

/// The views are of a second buffer that is in no file, and have the place of their compressed
/// bytes in the first one.
void pack_views(Json& json, const PackedRows& rows, std::uint64_t vertices, std::uint64_t corners) {
  json["extensionsUsed"] = {kPacking};
  json["extensionsRequired"] = {kPacking};
  const std::size_t at_triangles = aligned(rows.vertices.size());
  Json& of_vertices = json["bufferViews"][0];
  Json& of_triangles = json["bufferViews"][1];
  of_vertices["buffer"] = 1;
  of_triangles["buffer"] = 1;
  of_vertices["extensions"][kPacking] = {{"buffer", 0},
                                         {"byteLength", rows.vertices.size()},
                                         {"byteStride", of_vertices["byteStride"]},
                                         {"count", vertices},
                                         {"mode", "ATTRIBUTES"}};
  of_triangles["extensions"][kPacking] = {{"buffer", 0},
                                          {"byteOffset", at_triangles},
                                          {"byteLength", rows.triangles.size()},
                                          {"byteStride", sizeof(std::uint32_t)},
                                          {"count", corners},
                                          {"mode", "TRIANGLES"}};
  Json unpacked = json["buffers"][0];
  unpacked["extensions"][kPacking] = {{"fallback", true}};
  json["buffers"][0]["byteLength"] = at_triangles + aligned(rows.triangles.size());
  json["buffers"].push_back(unpacked);
}

/// The front of a file: its header, the document and the header of the binary part.
std::string front_of(std::string document, std::size_t binary_bytes) {
  document.resize(aligned(document.size()), ' ');
  std::string bytes;
  append_word(bytes, kMagic);
  append_word(bytes, 2);
  append_word(bytes, static_cast<std::uint32_t>(kFileHeaderBytes + 2 * kChunkHeaderBytes +
                                                document.size() + binary_bytes));
  append_word(bytes, static_cast<std::uint32_t>(document.size()));
  append_word(bytes, kJsonChunk);
  bytes += document;
  append_word(bytes, static_cast<std::uint32_t>(binary_bytes));
  append_word(bytes, kBinChunk);
  return bytes;
}

}  // namespace

GlbLayout::GlbLayout(const MeshHeader& header, const MeshWriterOptions& options)
    : header_(header),
      options_(options),
      colors_(header.schema),
      vertex_bytes_(kVectorBytes + (header.schema.has_normals ? kVectorBytes : 0) +
                    (colors_.all_are_there() ? kColorBytes : 0)) {
  find_own_attributes();
  vertex_bytes_ += own_.size() * sizeof(float);
  document_bytes_ = aligned(document({}).size());
}

void GlbLayout::find_own_attributes() {
  std::size_t offset = 0;
  for (const AttributeField& field : header_.schema.attributes) {
    const bool is_own =
        field.type == ScalarType::kFloat32 &&
        std::ranges::find(options_.glb_attributes, field.name) != options_.glb_attributes.end();
    if (is_own) {
      OwnAttribute own{"_", offset};
      for (const char letter : field.name)
        own.name += letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter;
      own_.push_back(own);
    }
    offset += size_of(field.type);
  }
}

std::uint64_t GlbLayout::rows_bytes() const {
  return header_.vertices * vertex_bytes_ + header_.triangles * triangle_bytes();
}

std::uint64_t GlbLayout::file_bytes() const {
  return kFileHeaderBytes + 2 * kChunkHeaderBytes + document_bytes_ + rows_bytes();
}

std::string GlbLayout::document(const Box& bounds, const PackedRows* packed) const {
  const bool is_known = !bounds.empty();
  const std::uint64_t vertex_part = header_.vertices * vertex_bytes_;
  Json json;
  json["asset"] = {{"version", "2.0"}, {"generator", "orbweave"}};
  json["scene"] = 0;
  json["scenes"] = Json::array({{{"nodes", {0}}}});
  json["nodes"] = Json::array(
      {{{"mesh", 0},
        {"matrix", node_matrix(options_.up_axis, options_.origin + options_.node_offset)}}});
  Json primitive = {{"attributes", {{"POSITION", 1}}}, {"indices", 0}, {"material", 0}};
  Json accessors = Json::array({accessor(1, kUnsignedInt, "SCALAR", 3 * header_.triangles)});
  Json positions = accessor(0, kFloat, "VEC3", header_.vertices);
  positions["min"] = vector_of(bounds.min - options_.origin, is_known);
  positions["max"] = vector_of(bounds.max - options_.origin, is_known);
  accessors.push_back(positions);
  std::size_t offset = kVectorBytes;
  if (header_.schema.has_normals) {
    primitive["attributes"]["NORMAL"] = accessors.size();
    accessors.push_back(at_byte(accessor(0, kFloat, "VEC3", header_.vertices), offset));
    offset += kVectorBytes;
  }
  if (colors_.all_are_there()) {
    primitive["attributes"]["COLOR_0"] = accessors.size();
    accessors.push_back(at_byte(accessor(0, kUnsignedShort, "VEC4", header_.vertices), offset));
    accessors.back()["normalized"] = true;
    offset += kColorBytes;
  }
  for (const OwnAttribute& own : own_) {
    primitive["attributes"][own.name] = accessors.size();
    accessors.push_back(at_byte(accessor(0, kFloat, "SCALAR", header_.vertices), offset));
    offset += sizeof(float);
  }
  json["meshes"] = Json::array({{{"primitives", Json::array({primitive})}}});
  const std::vector<std::string> dropped =
      columns_without_place_in_glb(header_.schema, options_.glb_attributes);
  if (!dropped.empty()) json["meshes"][0]["extras"] = {{"attributes_left_out", dropped}};
  // Neither metal nor mirror; scans are seen from both sides.
  json["materials"] =
      Json::array({{{"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
                    {"doubleSided", true}}});
  json["accessors"] = accessors;
  json["bufferViews"] = Json::array({{{"buffer", 0},
                                      {"byteLength", vertex_part},
                                      {"byteStride", vertex_bytes_},
                                      {"target", kArrayBuffer}},
                                     {{"buffer", 0},
                                      {"byteOffset", vertex_part},
                                      {"byteLength", header_.triangles * triangle_bytes()},
                                      {"target", kElementArrayBuffer}}});
  json["buffers"] = Json::array({{{"byteLength", rows_bytes()}}});
  if (packed) pack_views(json, *packed, header_.vertices, 3 * header_.triangles);
  return json_dump(json);
}

std::string GlbLayout::front(const Box& bounds) const {
  std::string text = document(bounds);
  if (text.size() > document_bytes_)
    throw std::logic_error("the document of a GLB file is longer than its place");
  text.resize(document_bytes_, ' ');
  return front_of(std::move(text), rows_bytes());
}

std::string GlbLayout::packed_file(const Box& bounds, const PackedRows& rows) const {
  std::string binary = rows.vertices;
  binary.resize(aligned(binary.size()));
  binary += rows.triangles;
  binary.resize(aligned(binary.size()));
  return front_of(document(bounds, &rows), binary.size()) + binary;
}

void GlbLayout::put_vertices(const PointCloud& batch, std::byte* out) const {
  if (header_.schema.has_normals && batch.normals.size() != batch.size())
    throw std::logic_error("a batch does not have the mesh header's normals");
  const std::size_t attribute_bytes = header_.schema.attribute_bytes();
  const auto put_vector = [&](Vec3 v) {
    const std::array<float, 3> narrow = floats_of(v);
    std::memcpy(out, narrow.data(), sizeof narrow);
    out += sizeof narrow;
  };
  for (std::size_t i = 0; i < batch.size(); ++i) {
    put_vector(batch.positions[i] - options_.origin);
    if (header_.schema.has_normals)
      put_vector(unit_normal(batch.normals[i], header_.schema.normal_type));
    if (colors_.all_are_there()) {
      const std::array<VertexColors::Channel, 3> color = colors_.of(batch, i);
      const std::array<std::uint16_t, 4> linear = {
          linear_fraction(color[0]), linear_fraction(color[1]), linear_fraction(color[2]), 65535};
      std::memcpy(out, linear.data(), sizeof linear);
      out += sizeof linear;
    }
    for (const OwnAttribute& own : own_) {
      std::memcpy(out, batch.attributes.data() + i * attribute_bytes + own.offset, sizeof(float));
      out += sizeof(float);
    }
  }
}

void GlbLayout::put_triangles(std::span<const Triangle64> batch, std::span<const std::int32_t>,
                              std::byte* out) const {
  for (const Triangle64& triangle : batch) {
    for (const std::uint64_t corner : triangle) {
      const auto narrow = static_cast<std::uint32_t>(corner);
      std::memcpy(out, &narrow, sizeof narrow);
      out += sizeof narrow;
    }
  }
}

std::vector<std::string> columns_without_place_in_glb(const PointSchema& schema,
                                                      std::span<const std::string> own) {
  const bool keeps_colors = VertexColors(schema).all_are_there();
  std::vector<std::string> names;
  for (const AttributeField& field : schema.attributes)
    if ((!keeps_colors || !is_color_channel(field)) &&
        std::ranges::find(own, field.name) == own.end())
      names.push_back(field.name);
  return names;
}

}  // namespace orbweave
