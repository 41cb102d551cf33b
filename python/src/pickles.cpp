#include "python/src/pickles.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "io/error.h"

namespace py = pybind11;

namespace orbweave::python {
namespace {

[[noreturn]] void throw_damaged() { throw_usage("a pickle is damaged or of another version"); }

template <class Row>
py::bytes bytes_of_rows(const std::vector<Row>& rows) {
  return {reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(Row)};
}

template <class Row>
std::vector<Row> rows_of_bytes(const py::handle& value) {
  const auto bytes = value.cast<py::bytes>();
  const std::string_view text = bytes;
  if (text.size() % sizeof(Row) != 0) throw_damaged();
  std::vector<Row> rows(text.size() / sizeof(Row));
  if (!rows.empty()) std::memcpy(rows.data(), text.data(), text.size());
  return rows;
}

py::tuple state_of_schema(const PointSchema& schema) {
  py::list fields;
  for (const AttributeField& field : schema.attributes)
    fields.append(py::make_tuple(py::bytes(field.name), static_cast<int>(field.type)));
  return py::make_tuple(schema.has_normals, static_cast<int>(schema.position_type),
                        static_cast<int>(schema.normal_type), fields);
}

ScalarType type_of_state(const py::handle& value) {
  const int type = value.cast<int>();
  if (type < 0 || type > static_cast<int>(ScalarType::kFloat64)) throw_damaged();
  return static_cast<ScalarType>(type);
}

PointSchema schema_of_state(const py::tuple& state) {
  PointSchema schema;
  schema.has_normals = state[0].cast<bool>();
  schema.position_type = type_of_state(state[1]);
  schema.normal_type = type_of_state(state[2]);
  for (const py::handle field : state[3].cast<py::list>()) {
    const auto parts = field.cast<py::tuple>();
    schema.attributes.push_back({parts[0].cast<std::string>(), type_of_state(parts[1])});
  }
  return schema;
}

py::tuple state_of_points(const PointCloud& cloud) {
  return py::make_tuple(state_of_schema(cloud.schema), bytes_of_rows(cloud.positions),
                        bytes_of_rows(cloud.normals), bytes_of_rows(cloud.attributes));
}

PointCloud points_of_state(const py::tuple& state) {
  PointCloud cloud;
  cloud.schema = schema_of_state(state[0]);
  cloud.positions = rows_of_bytes<Vec3>(state[1]);
  cloud.normals = rows_of_bytes<Vec3>(state[2]);
  cloud.attributes = rows_of_bytes<std::byte>(state[3]);
  const bool has_normals = cloud.normals.empty() || cloud.normals.size() == cloud.size();
  if (!has_normals || cloud.attributes.size() != cloud.size() * cloud.schema.attribute_bytes())
    throw_damaged();
  return cloud;
}

/// All members of a hole, in their order, to read and to write.
template <class Hole>
auto members_of(Hole& hole) {
  return std::tie(hole.id, hole.first_vertex, hole.edges, hole.perimeter, hole.diameter,
                  hole.center.x, hole.center.y, hole.center.z, hole.chunks, hole.filled,
                  hole.joined_to, hole.method, hole.reason, hole.sites, hole.points_added,
                  hole.triangles_added, hole.area, hole.open_edges, hole.residual, hole.condition,
                  hole.rim_dihedral_deg, hole.rim_mean_deg, hole.confidence, hole.seconds);
}

}  // namespace

py::tuple state_of(const HoleFacts& hole) {
  const py::object members = py::cast(members_of(hole));
  return py::make_tuple(members, static_cast<int>(hole.open));
}

namespace {

/// Puts the values of a state into the members, whose types it has to have.
template <class... Member>
void put_members(std::tuple<Member&...> members, const py::handle& values) {
  members = values.cast<std::tuple<Member...>>();
}

}  // namespace

HoleFacts hole_of_state(const py::tuple& state) {
  HoleFacts hole;
  put_members(members_of(hole), state[0]);
  hole.open = static_cast<OpenReason>(state[1].cast<int>());
  return hole;
}

py::tuple state_of(const CloudObject& object) {
  return py::make_tuple(state_of_points(object.cloud), py::bytes(object.coordinate_system));
}

CloudObject cloud_of_state(const py::tuple& state) {
  return {points_of_state(state[0]), state[1].cast<std::string>()};
}

py::tuple state_of(const MeshObject& object) {
  return py::make_tuple(state_of_points(object.mesh.vertices), bytes_of_rows(object.mesh.triangles),
                        bytes_of_rows(object.mesh.hole), object.holes, object.ball_radii,
                        object.dropped, py::bytes(object.coordinate_system));
}

namespace {

void check_mesh(const TriangleMesh& mesh) {
  if (!mesh.hole.empty() && mesh.hole.size() != mesh.triangles.size()) throw_damaged();
  for (const Triangle& triangle : mesh.triangles)
    if (*std::ranges::max_element(triangle) >= mesh.vertices.size()) throw_damaged();
}

}  // namespace

MeshObject mesh_of_state(const py::tuple& state) {
  MeshObject object;
  object.mesh.vertices = points_of_state(state[0]);
  object.mesh.triangles = rows_of_bytes<Triangle>(state[1]);
  object.mesh.hole = rows_of_bytes<std::int32_t>(state[2]);
  check_mesh(object.mesh);
  object.holes = state[3].cast<std::vector<HoleFacts>>();
  object.ball_radii = state[4].cast<std::vector<double>>();
  object.dropped = state[5].cast<DroppedPoints>();
  object.coordinate_system = state[6].cast<std::string>();
  return object;
}

}  // namespace orbweave::python
