#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/error.h"
#include "io/meshes/mesh_parsers.h"
#include "io/text/quantity.h"
#include "io/text/text_fields.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

constexpr const char* kNoVertexThere = "a face names a vertex that is not there";
constexpr const char* kNoNormalThere = "a face names a normal that is not there";
constexpr std::uint32_t kNoNormal = std::numeric_limits<std::uint32_t>::max();

/// What stands in a file and is not read: the words that lines begin with, and what they are.
constexpr std::array<std::pair<std::string_view, const char*>, 4> kUnread = {
    {{"vt", "texture coordinates"}, {"usemtl", "materials"}, {"l", "lines"}, {"p", "points"}}};

/// Words of a file that has vertices, or of one that was written of a scene without any.
bool is_obj_word(std::string_view word) {
  constexpr std::array<std::string_view, 9> kWords = {"v", "vn", "f",      "vt",    "g",
                                                      "o", "s",  "mtllib", "usemtl"};
  return word.starts_with('#') || std::ranges::find(kWords, word) != kWords.end();
}

/// Wavefront OBJ: positions (v), with colours where all have them, normals (vn) and faces (f);
/// everything else is passed over.
class ObjParser {
 public:
  explicit ObjParser(ByteReader reader) : reader_(std::move(reader)) {
    mesh_.vertices.schema.normal_type = ScalarType::kFloat64;
  }

  TriangleMesh parse() {
    skip_byte_order_mark(reader_);
    std::string_view line;
    while (next_line(line)) {
      const auto keyword = take_field(line, ' ');
      if (!keyword) continue;
      if (mesh_.vertices.empty() && foreign_line_ == 0 && !is_obj_word(*keyword)) {
        foreign_line_ = reader_.line_number();
        foreign_word_ = excerpt(*keyword);
      }
      if (*keyword == "v") parse_vertex(line);
      if (*keyword == "vn") normals_.push_back(parse_vector(line));
      if (*keyword == "f") parse_face(line);
      for (std::size_t i = 0; i < kUnread.size(); ++i)
        if (*keyword == kUnread[i].first) has_unread_[i] = true;
    }
    // An empty mesh has comments alone. Anything else may be another format under this name.
    if (mesh_.vertices.empty() && foreign_line_ != 0)
      throw_bad_input("the OBJ file has no vertices",
                      {.file = reader_.name(),
                       .place = "line " + std::to_string(foreign_line_),
                       .found = foreign_word_,
                       .expected = "lines that begin with v and f"});
    check_corners();
    if (mesh_.vertices.empty()) return std::move(mesh_);
    assign_normals();
    assign_colors();
    mesh_schema_ = mesh_.vertices.schema;
    return std::move(mesh_);
  }

  /// Once the file is read.
  std::vector<std::string> left_out() const {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < kUnread.size(); ++i)
      if (has_unread_[i]) all.emplace_back(kUnread[i].second);
    const PointSchema& schema = mesh_schema_;
    if (!colors_.empty() && schema.attributes.empty())
      all.emplace_back("colours, which not all vertices have");
    if (!normals_.empty() && !schema.has_normals)
      all.emplace_back("normals, which not all vertices have");
    return all;
  }

 private:
  [[noreturn]] void fail(const std::string& problem, std::string found,
                         std::string expected) const {
    throw_bad_input(problem, {.file = reader_.name(),
                              .place = reader_.line_place(),
                              .found = std::move(found),
                              .expected = std::move(expected)});
  }

  /// A line with those that continue it: all but the last end in a backslash.
  bool next_line(std::string_view& line) {
    if (!reader_.next_line(line)) return false;
    // Comments may end in the name of a folder.
    if (!line.ends_with('\\') || trimmed(line).starts_with('#')) return true;
    joined_.clear();
    while (line.ends_with('\\')) {
      line.remove_suffix(1);
      joined_.append(line).push_back(' ');
      line = {};
      if (!reader_.next_line(line)) break;
    }
    joined_.append(line);
    line = joined_;
    return true;
  }

  /// "v x y z", "v x y z w" or, as many programs write, "v x y z red green blue".
  void parse_vertex(std::string_view line) {
    mesh_.vertices.positions.push_back(parse_vector(line));
    check_further(line);
    std::array<float, 3> color{};
    for (float& channel : color) {
      const std::string_view text = take_field(line, ' ').value_or("");
      const char* const last = text.data() + text.size();
      if (text.empty() || parse_number(text.data(), last, channel) != last) return;
    }
    const auto wrong = std::ranges::find_if(
        color, [](float value) { return !(value >= 0.0F && value <= 255.0F); });
    if (wrong != color.end())
      fail("three values behind the coordinates are no colour", format_number(*wrong),
           "red, green and blue from 0 to 1, or from 0 to 255");
    colors_.push_back(color);
  }

  /// Values behind the coordinates are numbers, whatever they mean; a comment may follow.
  void check_further(std::string_view line) const {
    while (const auto field = take_field(line, ' ')) {
      if (field->starts_with('#')) return;
      double ignored = 0.0;
      const char* const last = field->data() + field->size();
      if (parse_number(field->data(), last, ignored) != last)
        fail("a value behind the coordinates is no number", excerpt(*field),
             "x y z, and perhaps w or a colour");
    }
  }

  /// Takes the vector from the front of the line.
  Vec3 parse_vector(std::string_view& line) const {
    Vec3 v;
    for (int axis = 0; axis < 3; ++axis) {
      const auto field = take_field(line, ' ');
      const std::string_view text = field.value_or("");
      const char* const last = text.data() + text.size();
      if (text.empty() || parse_number(text.data(), last, v[axis]) != last)
        fail("a coordinate is no number", excerpt(text), "three numbers");
    }
    return v;
  }

  /// One index of a corner, from zero; OBJ counts from one, or backwards from the last of `count`
  /// so far. `problem`: with an index of nothing.
  std::uint32_t parse_index(std::string_view text, std::size_t count, const char* problem) const {
    std::array<std::byte, 8> bytes{};
    if (parse_value(text, ScalarType::kInt64, bytes.data()) != ParseOutcome::kNumber)
      fail("a face's corner is no index", excerpt(text), "an integer");
    std::int64_t index = 0;
    std::memcpy(&index, bytes.data(), sizeof index);
    if (index < 0 && -(index + 1) < static_cast<std::int64_t>(count))
      index += static_cast<std::int64_t>(count) + 1;
    if (index <= 0 || index >= std::int64_t{kNoNormal})
      fail(problem, excerpt(text),
           count == 0 ? "indices from 1"
                      : "indices from 1, or from -1 down to -" + std::to_string(count));
    return static_cast<std::uint32_t>(index - 1);
  }

  /// "7", "7/2", "7//3" or "7/2/3": vertex, texture, normal. "7/", "7//" and "7/2/" name no more.
  void parse_face(std::string_view line) {
    polygon_.clear();
    while (const auto field = take_field(line, ' ')) {
      if (field->starts_with('#')) break;
      const std::size_t slash = std::min(field->find('/'), field->size());
      const std::uint32_t vertex =
          parse_index(field->substr(0, slash), mesh_.vertices.positions.size(), kNoVertexThere);
      const std::size_t second = field->find('/', std::min(slash + 1, field->size()));
      check_texture(field->substr(slash, std::min(second, field->size()) - slash));
      const std::string_view third = field->substr(std::min(second, field->size() - 1) + 1);
      const std::uint32_t normal =
          third.empty() ? kNoNormal : parse_index(third, normals_.size(), kNoNormalThere);
      polygon_.push_back(vertex);
      if (normal != kNoNormal) uses_.push_back({vertex, normal});
      if (normal != kNoNormal && normal >= largest_normal_) {
        largest_normal_ = normal;
        normal_line_ = reader_.line_number();
      }
    }
    if (polygon_.size() < 3)
      fail("a face has fewer than three corners", std::to_string(polygon_.size()), "3 or more");
    for (std::size_t i = 2; i < polygon_.size(); ++i)
      mesh_.triangles.push_back({polygon_[0], polygon_[i - 1], polygon_[i]});
    // Faces may come before the vertices they name, so this is judged at the end.
    const std::uint32_t largest = *std::max_element(polygon_.begin(), polygon_.end());
    if (largest >= largest_corner_) {
      largest_corner_ = largest;
      largest_line_ = reader_.line_number();
    }
  }

  /// "/7" or "/": a texture's place, which is not used.
  void check_texture(std::string_view text) const {
    std::array<std::byte, 8> ignored{};
    if (text.size() > 1 &&
        parse_value(text.substr(1), ScalarType::kInt64, ignored.data()) != ParseOutcome::kNumber)
      fail("a face's corner is no index", excerpt(text.substr(1)), "an integer");
  }

  void check_corners() const {
    if (mesh_.triangles.empty()) return;
    check_named(kNoVertexThere, largest_corner_, largest_line_, mesh_.vertices.size());
    // A file without any normals loses nothing by faces that name them.
    if (!uses_.empty() && !normals_.empty())
      check_named(kNoNormalThere, largest_normal_, normal_line_, normals_.size());
  }

  void check_named(const char* problem, std::uint32_t largest, std::uint64_t line,
                   std::size_t count) const {
    if (largest < count) return;
    throw_bad_input(problem, {.file = reader_.name(),
                              .place = "line " + std::to_string(line),
                              .found = std::to_string(std::uint64_t{largest} + 1),
                              .expected = "1 to " + std::to_string(count)});
  }

  /// A vertex takes the normal of the first corner that names one; without corners that do,
  /// normals and vertices that are equal in number go together. All vertices or none.
  void assign_normals() {
    PointCloud& cloud = mesh_.vertices;
    std::vector<std::uint32_t> normal_of(cloud.size(), kNoNormal);
    for (const auto& [vertex, normal] : uses_)
      if (normal < normals_.size() && normal_of[vertex] == kNoNormal) normal_of[vertex] = normal;
    if (uses_.empty() && normals_.size() == cloud.size())
      for (std::size_t i = 0; i < normal_of.size(); ++i)
        normal_of[i] = static_cast<std::uint32_t>(i);
    if (std::find(normal_of.begin(), normal_of.end(), kNoNormal) != normal_of.end()) return;
    cloud.schema.has_normals = true;
    for (const std::uint32_t i : normal_of) cloud.normals.push_back(normals_[i]);
  }

  /// From 0 to 1, or, of some programs, from 0 to 255. Fractions that were computed may exceed 1 a
  /// little.
  void assign_colors() {
    PointCloud& cloud = mesh_.vertices;
    if (colors_.size() != cloud.size()) return;
    const bool are_bytes = std::ranges::any_of(
        colors_, [](const auto& color) { return *std::ranges::max_element(color) >= 2.0F; });
    const float scale = are_bytes ? 1.0F : 255.0F;
    for (const char* name : {"red", "green", "blue"})
      cloud.schema.attributes.push_back({name, ScalarType::kUint8});
    cloud.attributes.reserve(3 * cloud.size());
    for (const std::array<float, 3>& color : colors_)
      for (const float channel : color)
        cloud.attributes.push_back(
            static_cast<std::byte>(std::min(std::round(channel * scale), 255.0F)));
  }

  struct NormalUse {
    std::uint32_t vertex;
    std::uint32_t normal;
  };

  ByteReader reader_;
  std::string joined_;  ///< lines that continue each other
  TriangleMesh mesh_;
  std::vector<Vec3> normals_;
  std::vector<std::array<float, 3>> colors_;  ///< of the vertices that have one
  std::array<bool, kUnread.size()> has_unread_{};
  std::uint64_t foreign_line_ =
      0;  ///< before the first vertex: the first of another format; 0: none
  std::string foreign_word_;
  PointSchema mesh_schema_;  ///< of the mesh, once it is handed on
  std::vector<NormalUse> uses_;
  std::vector<std::uint32_t> polygon_;
  std::uint32_t largest_corner_ = 0;
  std::uint64_t largest_line_ = 0;
  std::uint32_t largest_normal_ = 0;
  std::uint64_t normal_line_ = 0;
};

}  // namespace

TriangleMesh read_obj_mesh(ByteReader reader, std::vector<std::string>* left_out) {
  ObjParser parser(std::move(reader));
  TriangleMesh mesh = parser.parse();
  if (left_out != nullptr) *left_out = parser.left_out();
  return mesh;
}

}  // namespace orbweave
