#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "io/meshes/attribute_names.h"
#include "io/meshes/mesh_formats.h"
#include "io/text/column_name.h"

namespace orbweave {
namespace {

/// A cloud, one line per point: position, normal, attributes; in front what the columns are.
class TextCloudWriter final : public MeshWriter {
 public:
  TextCloudWriter(std::unique_ptr<ByteSink> sink, const MeshHeader& header,
                  const MeshWriterOptions& options, char separator)
      : sink_(std::move(sink)),
        header_(header),
        origin_(options.origin),
        separator_(separator),
        counter_(header) {
    if (separator == ',' || !are_known_by_place()) sink_->write(names());
  }

  bool encodes_independently() const override { return true; }
  std::vector<std::byte> encode_vertices(const PointCloud& batch) const override {
    constexpr std::size_t kTypicalLine = 64;
    TextBuilder text;
    text.reserve(batch.size() * kTypicalLine);
    const std::size_t attribute_bytes = header_.schema.attribute_bytes();
    for (std::size_t i = 0; i < batch.size(); ++i) {
      add_vector(text, batch.positions[i] - origin_);
      if (header_.schema.has_normals) {
        text.add(separator_);
        add_normal(text, batch.normals[i]);
      }
      const std::byte* from = batch.attributes.data() + i * attribute_bytes;
      for (const AttributeField& field : header_.schema.attributes) {
        text.add(separator_);
        text.add_value(field.type, from);
        from += size_of(field.type);
      }
      text.add('\n');
    }
    return text.take();
  }
  void write_vertices(const PointCloud& batch) override {
    write_encoded_vertices(encode_vertices(batch), batch.size());
  }
  void write_encoded_vertices(std::span<const std::byte> bytes, std::uint64_t vertices) override {
    counter_.vertices(vertices);
    sink_->write(bytes);
  }
  void write_triangles(std::span<const Triangle64> batch, std::span<const std::int32_t>) override {
    counter_.triangles(batch.size());
  }
  void finish() override {
    counter_.finish();
    sink_->finish();
  }
  std::uint64_t bytes_written() const override { return sink_->bytes_written(); }

 private:
  /// Whether bare numbers say what they are, as every program reads them: coordinates, normals and
  /// colours. Some programs read nothing else.
  bool are_known_by_place() const {
    const std::vector<AttributeField>& fields = header_.schema.attributes;
    constexpr std::array<const char*, 3> kColor = {"red", "green", "blue"};
    return fields.empty() ||
           std::ranges::equal(fields, kColor, [](const AttributeField& field, const char* name) {
             return field.name == name && field.type == ScalarType::kUint8;
           });
  }
  /// A table begins with names. Between blanks they are a comment: without one, integers such as
  /// classes would be taken for colours.
  std::string names() const {
    std::string line = separator_ == ',' ? "x" : "# x";
    const auto add = [&](const std::string& name) { line += separator_ + name; };
    for (const char* name : {"y", "z"}) add(name);
    if (header_.schema.has_normals)
      for (const char* name : {"nx", "ny", "nz"}) add(name);
    const auto plain = separator_ == ',' ? name_in_table : name_in_comment;
    for (const std::string& name : attribute_names(header_.schema, plain, canonical_column_name))
      add(name);
    return line + "\n";
  }
  static bool is_control(char c) { return static_cast<unsigned char>(c) < ' '; }
  /// A semicolon would be taken for the separator of the line, and a name of blanks for none.
  static std::string name_in_table(std::string name) {
    for (char& c : name)
      if (c == ',' || c == ';' || is_control(c)) c = '_';
    return name.find_first_not_of(' ') == name.npos ? "_" : name;
  }
  static std::string name_in_comment(std::string name) {
    for (char& c : name)
      if (c == ' ' || c == '"' || is_control(c)) c = '_';
    return name.empty() ? "_" : name;
  }
  void add_vector(TextBuilder& text, Vec3 v) const {
    text.add_number(v.x);
    text.add(separator_);
    text.add_number(v.y);
    text.add(separator_);
    text.add_number(v.z);
  }
  /// At its own width: the shortest text of a float is far shorter than that of its double.
  void add_normal(TextBuilder& text, Vec3 n) const {
    if (header_.schema.normal_type == ScalarType::kFloat64) return add_vector(text, n);
    text.add_number(static_cast<float>(n.x));
    text.add(separator_);
    text.add_number(static_cast<float>(n.y));
    text.add(separator_);
    text.add_number(static_cast<float>(n.z));
  }

  std::unique_ptr<ByteSink> sink_;
  MeshHeader header_;
  Vec3 origin_;
  char separator_;
  RowCounter counter_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_text_writer(std::unique_ptr<ByteSink> sink,
                                             const MeshHeader& header,
                                             const MeshWriterOptions& options, char separator) {
  return std::make_unique<TextCloudWriter>(std::move(sink), header, options, separator);
}

}  // namespace orbweave
