// A mesh from binary glTF 2.0: all triangles of the scene, moved to the places of their nodes.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/meshes/glb_document.h"
#include "io/meshes/mesh_parsers.h"
#include "io/text/lower_case.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;

constexpr int kFloat = 5126;
constexpr int kTriangles = 4;
constexpr const char* kApply =
    "Apply it in the program that made the file, and write triangles alone";

/// y = rows * x + origin, in doubles.
struct Placement {
  std::array<Vec3, 3> rows = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 origin{};

  Vec3 direction(Vec3 v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
  Vec3 place(Vec3 v) const { return direction(v) + origin; }
  Vec3 column(int axis) const { return {rows[0][axis], rows[1][axis], rows[2][axis]}; }
  double determinant() const { return dot(rows[0], cross(rows[1], rows[2])); }
  /// Of the directions of normals: the transposed inverse, times the determinant.
  Vec3 normal(Vec3 v) const {
    const Placement cofactors{
        {cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])}, {}};
    const Vec3 turned = cofactors.direction(v);
    return determinant() < 0.0 ? -turned : turned;
  }
  bool is_identity() const { return rows == Placement{}.rows && origin == Vec3{}; }
};

/// First `inner`, then `outer`.
Placement combined(const Placement& outer, const Placement& inner) {
  Placement both;
  const std::array<Vec3, 3> columns = {outer.direction(inner.column(0)),
                                       outer.direction(inner.column(1)),
                                       outer.direction(inner.column(2))};
  for (int axis = 0; axis < 3; ++axis)
    both.rows[static_cast<std::size_t>(axis)] = {columns[0][axis], columns[1][axis],
                                                 columns[2][axis]};
  both.origin = outer.place(inner.origin);
  return both;
}

Placement rotation(const std::array<double, 4>& q) {
  const auto [x, y, z, w] = q;
  return {{Vec3{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
           Vec3{2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
           Vec3{2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}},
          {}};
}

/// The value of sRGB, IEC 61966-2-1, from 0 to 255 of light from 0 to 1.
std::uint8_t srgb_byte(double light) {
  const double l = std::clamp(light, 0.0, 1.0);
  const double s = l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * s));
}

/// One list of triangles of the scene.
struct Part {
  const Json* primitive = nullptr;
  const Json* attributes = nullptr;
  std::string place;  ///< "meshes[0].primitives[1]"
  Placement placement;
  std::size_t node = 0;
};

/// The triangles of a scene, in the order of its nodes.
class SceneParts {
 public:
  explicit SceneParts(const GlbDocument& file) : file_(file) {}

  std::vector<Part> find() {
    for (const std::uint64_t root : roots()) add_tree(root);
    return std::move(parts_);
  }

 private:
  struct Waiting {
    std::uint64_t node = 0;
    std::string from;
    Placement parent;
  };

  std::vector<std::uint64_t> indices(const Json& object, const char* key,
                                     const std::string& place) const {
    std::vector<std::uint64_t> found;
    const Json* list = file_.array(object, key, place);
    if (list == nullptr) return found;
    for (const Json& index : *list) {
      if (!index.is_number_unsigned())
        file_.fail("a value has another type", place + "." + key, "no index", "whole numbers");
      found.push_back(index.get<std::uint64_t>());
    }
    return found;
  }

  /// Of the scene that is shown first; without scenes, the nodes that are no node's child.
  std::vector<std::uint64_t> roots() const {
    const Json* scenes = file_.array(file_.json(), "scenes", "the document");
    if (scenes != nullptr && !scenes->empty()) {
      const std::uint64_t shown = file_.number(file_.json(), "scene", "the document").value_or(0);
      return indices(file_.element("scenes", shown, "scene"), "nodes",
                     "scenes[" + std::to_string(shown) + "]");
    }
    const Json* nodes = file_.array(file_.json(), "nodes", "the document");
    std::vector<std::uint64_t> found;
    std::set<std::uint64_t> children;
    for (std::uint64_t i = 0; nodes != nullptr && i < nodes->size(); ++i)
      for (const std::uint64_t child :
           indices(file_.element("nodes", i, "nodes"), "children", place_of(i)))
        children.insert(child);
    for (std::uint64_t i = 0; nodes != nullptr && i < nodes->size(); ++i)
      if (!children.contains(i)) found.push_back(i);
    return found;
  }

  static std::string place_of(std::uint64_t node) { return "nodes[" + std::to_string(node) + "]"; }

  void add_tree(std::uint64_t root) {
    std::vector<Waiting> waiting = {{root, "scene", {}}};
    while (!waiting.empty()) {
      const Waiting next = std::move(waiting.back());
      waiting.pop_back();
      const Json& node = file_.element("nodes", next.node, next.from);
      const std::string place = place_of(next.node);
      if (!seen_.insert(next.node).second)
        file_.fail("a node is in the scene twice", place, "", "nodes that form trees");
      const Placement placement = combined(next.parent, placement_of(node, place));
      add_mesh(node, place, placement);
      const std::vector<std::uint64_t> children = indices(node, "children", place);
      for (auto child = children.rbegin(); child != children.rend(); ++child)
        waiting.push_back({*child, place, placement});
    }
  }

  template <std::size_t N>
  std::array<double, N> values(const Json& node, const char* key, const std::string& place,
                               std::array<double, N> otherwise) const {
    const Json* list = file_.array(node, key, place);
    if (list == nullptr) return otherwise;
    const bool is_right = list->size() == N &&
                          std::ranges::all_of(*list, [](const Json& v) { return v.is_number(); });
    if (!is_right)
      file_.fail("the place of a node is no list of numbers", place + "." + key,
                 std::to_string(list->size()) + " values", std::to_string(N) + " numbers");
    for (std::size_t i = 0; i < N; ++i) otherwise[i] = (*list)[i].get<double>();
    return otherwise;
  }

  Placement placement_of(const Json& node, const std::string& place) const {
    if (node.contains("matrix")) {
      const auto m = values<16>(node, "matrix", place, {});
      if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0)
        file_.fail("the matrix of a node is no affine map", place + ".matrix", "another last row",
                   "0, 0, 0, 1");
      return {{Vec3{m[0], m[4], m[8]}, Vec3{m[1], m[5], m[9]}, Vec3{m[2], m[6], m[10]}},
              {m[12], m[13], m[14]}};
    }
    const auto move = values<3>(node, "translation", place, {0, 0, 0});
    const auto scale = values<3>(node, "scale", place, {1, 1, 1});
    Placement placement = rotation(values<4>(node, "rotation", place, {0, 0, 0, 1}));
    for (Vec3& row : placement.rows) row = {row.x * scale[0], row.y * scale[1], row.z * scale[2]};
    placement.origin = {move[0], move[1], move[2]};
    return placement;
  }

  void add_mesh(const Json& node, const std::string& place, const Placement& placement) {
    for (const char* unknown : {"skin", "weights"})
      if (node.contains(unknown))
        file_.fail("moving surfaces are not read", place, unknown, "a mesh in one shape", kApply);
    const Json* extensions = file_.object(node, "extensions", place);
    if (extensions != nullptr && extensions->contains("EXT_mesh_gpu_instancing"))
      file_.fail("instances of a mesh are not read", place, "EXT_mesh_gpu_instancing",
                 "a node for each mesh", kApply);
    const auto mesh = file_.number(node, "mesh", place);
    if (!mesh) return;
    const std::string mesh_place = "meshes[" + std::to_string(*mesh) + "]";
    const Json* primitives =
        file_.array(file_.element("meshes", *mesh, place), "primitives", mesh_place);
    for (std::size_t i = 0; primitives != nullptr && i < primitives->size(); ++i)
      add_part((*primitives)[i], mesh_place + ".primitives[" + std::to_string(i) + "]", placement);
  }

  void add_part(const Json& primitive, const std::string& place, const Placement& placement) {
    if (!primitive.is_object())
      file_.fail("a value has another type", place, "no object", "an object");
    const std::uint64_t mode = file_.number(primitive, "mode", place).value_or(kTriangles);
    if (mode != kTriangles)
      file_.fail("only lists of triangles are read", place, "mode " + std::to_string(mode),
                 "mode 4", kApply);
    if (primitive.contains("targets"))
      file_.fail("morph targets are not read", place, "\"targets\"", "a mesh in one shape", kApply);
    const Json* extensions = file_.object(primitive, "extensions", place);
    if (extensions != nullptr && extensions->contains("KHR_draco_mesh_compression"))
      file_.fail("compressed meshes are not read", place, "KHR_draco_mesh_compression",
                 "a mesh without compression", kApply);
    const Json* attributes = file_.object(primitive, "attributes", place);
    if (attributes == nullptr || !attributes->contains("POSITION"))
      file_.fail("triangles without vertices", place, "no POSITION", "\"POSITION\"");
    parts_.push_back({&primitive, attributes, place, placement, seen_.size()});
  }

  const GlbDocument& file_;
  std::set<std::uint64_t> seen_;
  std::vector<Part> parts_;
};

/// Where a file of this program stands: the node turns the axis that is upright to y, and the turn
/// is taken back. Coordinates of other files are those of glTF.
Placement turned_back(const GlbDocument& file, Placement placement) {
  if (!file.is_own()) return placement;
  Placement back;  // the turn is a rotation: its transpose is its inverse
  for (int axis = 0; axis < 3; ++axis)
    back.rows[static_cast<std::size_t>(axis)] = placement.column(axis);
  const bool is_turn = combined(back, {placement.rows, {}}).is_identity();
  return is_turn ? combined(back, placement) : placement;
}

class SceneMesh {
 public:
  explicit SceneMesh(const GlbDocument& file) : file_(file), parts_(SceneParts(file).find()) {
    for (Part& part : parts_) part.placement = turned_back(file, part.placement);
  }

  TriangleMesh read() {
    choose_columns();
    for (const Part& part : parts_) add(part);
    take_holes();
    return std::move(mesh_);
  }

 private:
  bool all_have(const std::string& attribute) const {
    return !parts_.empty() && std::ranges::all_of(parts_, [&](const Part& part) {
      return part.attributes->contains(attribute);
    });
  }

  /// What all parts have.
  void choose_columns() {
    PointSchema& schema = mesh_.vertices.schema;
    const bool moves =
        std::ranges::any_of(parts_, [](const Part& part) { return !part.placement.is_identity(); });
    schema.position_type = moves ? ScalarType::kFloat64 : ScalarType::kFloat32;
    schema.has_normals = all_have("NORMAL");
    schema.normal_type = ScalarType::kFloat32;
    has_colors_ = all_have("COLOR_0");
    if (has_colors_)
      for (const char* channel : {"red", "green", "blue"})
        schema.attributes.push_back({channel, ScalarType::kUint8});
    if (parts_.empty()) return;
    for (const auto& [name, accessor] : parts_.front().attributes->items()) {
      // Of the application, such as _HOLE and _CONFIDENCE of tiles.
      if (name.size() < 2 || name.front() != '_' || !all_have(name) || !are_floats(name)) continue;
      own_.push_back(name);
      schema.attributes.push_back({lower_case(name.substr(1)), ScalarType::kFloat32});
    }
  }

  bool are_floats(const std::string& name) const {
    return std::ranges::all_of(parts_, [&](const Part& part) {
      const GlbNumbers numbers = attribute(part, name);
      return numbers.component_type == kFloat && numbers.components == 1;
    });
  }

  GlbNumbers attribute(const Part& part, const std::string& name) const {
    return file_.numbers(
        file_.required_number(*part.attributes, name.c_str(), part.place + ".attributes"),
        part.place);
  }

  void require(bool is_right, const GlbNumbers& numbers, const char* what,
               const std::string& expected) const {
    if (is_right) return;
    file_.fail(std::string("these ") + what + " are not read", numbers.place,
               std::to_string(numbers.count) + " elements of " +
                   std::to_string(numbers.components) + " components of type " +
                   std::to_string(numbers.component_type),
               expected);
  }

  void add(const Part& part) {
    // Parts with the same vertices at the same place, such as one for each material.
    const std::pair key(part.node, part.attributes->dump());
    const auto [known, is_new] = first_vertex_.try_emplace(key, mesh_.vertices.size());
    const GlbNumbers positions = attribute(part, "POSITION");
    if (is_new) {
      check_size(part, mesh_.vertices.size() + positions.count, "vertices");
      add_vertices(part, positions);
    }
    add_triangles(part, known->second, positions.count);
  }

  /// Nodes may show one mesh again and again: a small file would fill the memory.
  void check_size(const Part& part, std::uint64_t rows, const char* what) const {
    constexpr std::uint64_t kMostTimes = 16;
    const std::uint64_t most = std::min<std::uint64_t>(kMostTimes * file_.data_bytes(),
                                                       std::numeric_limits<std::uint32_t>::max());
    if (rows > most)
      file_.fail("the scene is too large for its file", part.place,
                 std::to_string(rows) + " " + what, "at most " + std::to_string(most), kApply);
  }

  void add_vertices(const Part& part, const GlbNumbers& positions) {
    require(positions.components == 3, positions, "positions", "VEC3");
    PointCloud& vertices = mesh_.vertices;
    for (std::uint64_t i = 0; i < positions.count; ++i)
      vertices.positions.push_back(part.placement.place(vector_at(positions, i)));
    if (vertices.schema.has_normals) add_normals(part, positions.count);
    add_attributes(part, positions.count);
  }

  static Vec3 vector_at(const GlbNumbers& numbers, std::uint64_t i) {
    return {numbers.value(i, 0), numbers.value(i, 1), numbers.value(i, 2)};
  }

  void add_normals(const Part& part, std::uint64_t count) {
    const GlbNumbers normals = attribute(part, "NORMAL");
    require(normals.components == 3 && normals.count == count, normals, "normals",
            std::to_string(count) + " of VEC3");
    const bool turns = part.placement.rows != Placement{}.rows;
    for (std::uint64_t i = 0; i < count; ++i) {
      const Vec3 normal = vector_at(normals, i);
      const Vec3 turned = turns ? part.placement.normal(normal) : normal;
      const double length = norm(turned);
      mesh_.vertices.normals.push_back(turns && length > 0.0 ? turned / length : turned);
    }
  }

  void add_attributes(const Part& part, std::uint64_t count) {
    std::vector<GlbNumbers> own;
    for (const std::string& name : own_) {
      own.push_back(attribute(part, name));
      require(own.back().count == count, own.back(), "values of vertices", std::to_string(count));
    }
    GlbNumbers colors;
    if (has_colors_) {
      colors = attribute(part, "COLOR_0");
      const bool is_fraction = colors.component_type == kFloat || colors.is_normalized;
      require(colors.components >= 3 && is_fraction && colors.count == count, colors, "colours",
              std::to_string(count) + " of VEC3 or VEC4, float or normalized");
    }
    std::vector<std::byte>& bytes = mesh_.vertices.attributes;
    for (std::uint64_t i = 0; i < count; ++i) {
      for (int channel = 0; has_colors_ && channel < 3; ++channel)
        bytes.push_back(static_cast<std::byte>(srgb_byte(colors.value(i, channel))));
      for (const GlbNumbers& numbers : own) {
        const auto value = static_cast<float>(numbers.value(i, 0));
        const auto* from = reinterpret_cast<const std::byte*>(&value);
        bytes.insert(bytes.end(), from, from + sizeof value);
      }
    }
  }

  void add_triangles(const Part& part, std::size_t first, std::uint64_t vertices) {
    GlbNumbers indices;
    const auto accessor = file_.number(*part.primitive, "indices", part.place);
    if (accessor) {
      constexpr std::array kUnsigned = {5121, 5123, 5125};
      indices = file_.numbers(*accessor, part.place);
      require(indices.components == 1 &&
                  std::ranges::find(kUnsigned, indices.component_type) != kUnsigned.end(),
              indices, "indices", "SCALAR of type 5121, 5123 or 5125");
    }
    const std::uint64_t corners = accessor ? indices.count : vertices;
    if (corners % 3 != 0)
      file_.fail("the corners are not those of triangles", part.place, std::to_string(corners),
                 "a multiple of 3");
    check_size(part, mesh_.triangles.size() + corners / 3, "triangles");
    // A mirrored part shows its other side.
    const bool is_mirrored = part.placement.determinant() < 0.0;
    for (std::uint64_t corner = 0; corner < corners; corner += 3) {
      Triangle triangle;
      for (std::uint64_t k = 0; k < 3; ++k) {
        const std::uint64_t index = accessor ? indices.index(corner + k) : corner + k;
        if (index >= vertices) refuse_index(part, corner / 3, index, vertices);
        triangle[k] = static_cast<std::uint32_t>(first + index);
      }
      if (is_mirrored) std::swap(triangle[1], triangle[2]);
      mesh_.triangles.push_back(triangle);
    }
  }

  [[noreturn]] void refuse_index(const Part& part, std::uint64_t triangle, std::uint64_t index,
                                 std::uint64_t vertices) const {
    file_.fail("a face names a vertex that is not there",
               part.place + ", triangle " + std::to_string(triangle),
               "vertex " + std::to_string(index),
               "0 to " + std::to_string(vertices) + " (excluded)");
  }

  /// Of files with _HOLE: the hole of a triangle is that of its corners, where they agree.
  void take_holes() {
    const auto field = std::ranges::find(own_, "_HOLE");
    if (field == own_.end()) return;
    const std::size_t offset =
        (has_colors_ ? 3 : 0) + static_cast<std::size_t>(field - own_.begin()) * sizeof(float);
    const std::size_t width = mesh_.vertices.schema.attribute_bytes();
    const auto hole_of = [&](std::uint32_t vertex) {
      float value = 0.0F;
      std::copy_n(mesh_.vertices.attributes.data() + vertex * width + offset, sizeof value,
                  reinterpret_cast<std::byte*>(&value));
      const bool is_id = value > 0.0F && value < 2147483648.0F;
      return is_id ? static_cast<std::int32_t>(value) : 0;
    };
    for (const Triangle& t : mesh_.triangles) {
      const std::int32_t hole = hole_of(t[0]);
      const bool agree = hole == hole_of(t[1]) && hole == hole_of(t[2]);
      mesh_.hole.push_back(agree ? hole : 0);
    }
  }

  const GlbDocument& file_;
  std::vector<Part> parts_;
  bool has_colors_ = false;
  std::vector<std::string> own_;
  std::map<std::pair<std::size_t, std::string>, std::size_t> first_vertex_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh read_glb_mesh(ByteReader reader) {
  const GlbDocument file(std::move(reader));
  return SceneMesh(file).read();
}

}  // namespace orbweave
