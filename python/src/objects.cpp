#include "python/src/objects.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <memory>

#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/points/coordinate_system.h"
#include "io/report/report.h"
#include "io/text/quantity.h"
#include "python/src/arrays.h"
#include "python/src/pickles.h"
#include "python/src/texts.h"
#include "python/src/watched_call.h"

namespace py = pybind11;

namespace orbweave::python {
namespace {

/// As the system of a file is taken: what PROJ understands as a code or WKT, other words as they
/// are.
std::string system_of(const py::str& given) {
  const std::string text = bytes_of(given, "coordinate_system");
  const std::string known = text.empty() ? text : system_of_text(text);
  return known.empty() ? text : known;
}

std::unique_ptr<MeshObject> mesh_of(const py::object& vertices, const py::object& triangles,
                                    const py::object& normals, const py::object& attributes,
                                    const py::object& hole, const py::str& coordinate_system) {
  auto object = std::make_unique<MeshObject>();
  object->coordinate_system = system_of(coordinate_system);
  TriangleMesh& mesh = object->mesh;
  mesh.vertices = cloud_of(vertices, normals, attributes);
  mesh.triangles = triangles_of(triangles, mesh.vertices.size());
  if (!hole.is_none()) mesh.hole = holes_of(hole, mesh.triangles.size());
  return object;
}

py::object normals_view(const PointCloud& cloud, const py::object& owner) {
  if (cloud.normals.empty()) return py::none();
  return rows_view(cloud.normals, owner);
}

py::object facts_of(const MeshObject& object) {
  std::string text;
  WatchedCall call(py::none{});
  call.run([&] { text = mesh_facts_json(mesh_facts(object.mesh, &call.stop())); });
  return py::module_::import("json").attr("loads")(text);
}

/// What a subclass of Python has put into its object; nothing for the class itself.
py::dict more_of(const py::object& self) {
  return py::getattr(self, "__dict__", py::dict()).cast<py::dict>();
}

/// Lets objects of the class be pickled, with what subclasses add to them. The protocols 0 and 1,
/// which are older than classes such as these, would make objects of no type of C++: the form of
/// protocol 2 serves them as well.
template <class Object>
void add_pickle(py::class_<Object>& of, Object (*object_of_state)(const py::tuple&)) {
  of.def(py::pickle(
      [](const py::object& self) {
        const py::tuple state = state_of(self.cast<const Object&>());
        const py::dict more = more_of(self);
        return more.empty() ? state : py::tuple(state + py::make_tuple(more));
      },
      [object_of_state](const py::tuple& state) {
        py::dict more;
        if (!state.empty() && py::isinstance<py::dict>(state[state.size() - 1]))
          more = state[state.size() - 1].cast<py::dict>().attr("copy")();
        return std::make_pair(object_of_state(state), more);
      }));
  of.def("__reduce_ex__", [](const py::object& self, int protocol) {
    const py::object base = py::module_::import("builtins").attr("object");
    return base.attr("__reduce_ex__")(self, std::max(protocol, 2)).template cast<py::object>();
  });
}

py::object hole_text(const HoleFacts& hole) {
  return py::str("<Hole {}: {} edges, {}>")
      .format(hole.id, hole.edges, hole.filled ? "filled" : "open: " + hole.reason);
}

void add_holes(py::module_& module) {
  py::class_<HoleFacts> loop(module, "Hole", "A boundary loop and what became of it.");
  loop.def_readonly("id", &HoleFacts::id,
                    "Rank among all loops, from 1; Mesh.triangle_hole has it.")
      .def_readonly("first_vertex", &HoleFacts::first_vertex, "Smallest vertex of the loop.")
      .def_readonly("edges", &HoleFacts::edges, "Of the loop.")
      .def_readonly("perimeter", &HoleFacts::perimeter, "Length of the loop, world units.")
      .def_readonly("diameter", &HoleFacts::diameter,
                    "Of the ball around the loop's center, world units.")
      .def_property_readonly(
          "center",
          [](const HoleFacts& hole) {
            return py::make_tuple(hole.center.x, hole.center.y, hole.center.z);
          },
          "Mean of the vertices of the loop, (x, y, z) in world units.")
      .def_readonly("filled", &HoleFacts::filled, "Whether a patch closes it.")
      .def_readonly("joined_to", &HoleFacts::joined_to,
                    "Of an island: the hole whose patch it bounds as well; 0: none.")
      .def_readonly(
          "method", &HoleFacts::method,
          "\"direct\", \"plane\", \"implicit\" or \"creased\"; empty where it stays open.")
      .def_readonly("reason", &HoleFacts::reason,
                    "Why it stays open, or why a simpler method did not do.")
      .def_readonly("points_added", &HoleFacts::points_added,
                    "Vertices of the patch beside the loop.")
      .def_readonly("triangles_added", &HoleFacts::triangles_added, "Triangles of the patch.")
      .def_readonly("area", &HoleFacts::area, "Of the patch, square world units.")
      .def_readonly("open_edges", &HoleFacts::open_edges, "Edges at which a filled hole is open.")
      .def_readonly("rim_dihedral_deg", &HoleFacts::rim_dihedral_deg,
                    "Largest angle between a face of the patch and the face at the loop, degrees.")
      .def_readonly("rim_mean_deg", &HoleFacts::rim_mean_deg, "Mean of these angles, degrees.")
      .def_readonly("confidence", &HoleFacts::confidence,
                    "Of the patch, 0 to 1; below 0.5 it is doubtful.")
      .def("__repr__", hole_text);
  add_pickle(loop, &hole_of_state);
}

void add_cloud(py::module_& module) {
  py::class_<CloudObject> cloud(
      module, "PointCloud", "Points with normals and attributes. Its arrays are read-only views.");
  cloud
      .def(
          py::init([](const py::object& points, const py::object& normals,
                      const py::object& attributes, const py::str& coordinate_system) {
            return CloudObject{cloud_of(points, normals, attributes), system_of(coordinate_system)};
          }),
          py::arg("points"), py::arg("normals") = py::none(), py::kw_only(),
          py::arg("attributes") = py::none(), py::arg("coordinate_system") = "",
          "Copies the arrays. Normals of float32 keep that width, as in a file.")
      .def_property_readonly(
          "points",
          [](const py::object& self) {
            return rows_view(self.cast<CloudObject&>().cloud.positions, self);
          },
          "(N, 3) float64, world units.")
      .def_property_readonly(
          "normals",
          [](const py::object& self) {
            return normals_view(self.cast<CloudObject&>().cloud, self);
          },
          "(N, 3) float64, or None.")
      .def_property_readonly(
          "attributes",
          [](const py::object& self) {
            return attribute_views(self.cast<CloudObject&>().cloud, self);
          },
          "Name to array of N values.")
      .def_property_readonly(
          "coordinate_system",
          [](const CloudObject& self) { return text_of(self.coordinate_system); },
          "WKT or a code; empty where unknown.")
      .def("__len__", [](const CloudObject& self) { return self.cloud.size(); })
      .def("__repr__", [](const CloudObject& self) {
        return "<orbweave.PointCloud of " + format_count(self.cloud.size()) + " points>";
      });
  add_pickle(cloud, &cloud_of_state);
}

void add_mesh_arrays(py::class_<MeshObject>& mesh) {
  mesh.def_property_readonly(
          "vertices",
          [](const py::object& self) {
            return rows_view(self.cast<MeshObject&>().mesh.vertices.positions, self);
          },
          "(M, 3) float64: points of the scan, unmoved, then the vertices of patches.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) {
            return triangles_view(self.cast<MeshObject&>().mesh.triangles, self);
          },
          "(K, 3) uint32, counter-clockwise seen from outside.")
      .def_property_readonly(
          "normals",
          [](const py::object& self) {
            return normals_view(self.cast<MeshObject&>().mesh.vertices, self);
          },
          "(M, 3) float64, or None.")
      .def_property_readonly(
          "attributes",
          [](const py::object& self) {
            return attribute_views(self.cast<MeshObject&>().mesh.vertices, self);
          },
          "Name to array of M values.")
      .def_property_readonly(
          "triangle_hole",
          [](const py::object& self) -> py::object {
            const TriangleMesh& mesh_of_self = self.cast<MeshObject&>().mesh;
            if (mesh_of_self.hole.empty()) return py::none();
            return numbers_view(mesh_of_self.hole, self);
          },
          "(K,) int32: 0 for the scanned surface, else the number of the hole; None where not "
          "known.");
}

void add_mesh(py::module_& module) {
  py::class_<MeshObject> mesh(
      module, "Mesh",
      "A triangle mesh. Its arrays are read-only views of memory that the mesh owns.");
  mesh.def(py::init(&mesh_of), py::arg("vertices"), py::arg("triangles"),
           py::arg("normals") = py::none(), py::kw_only(), py::arg("attributes") = py::none(),
           py::arg("triangle_hole") = py::none(), py::arg("coordinate_system") = "",
           "Copies the arrays.");
  add_mesh_arrays(mesh);
  mesh.def_readonly("holes", &MeshObject::holes,
                    "Every boundary loop, filled or not; empty without the fill.")
      .def_readonly("ball_radii", &MeshObject::ball_radii, "The radii that were used, ascending.")
      .def_readonly("dropped", &MeshObject::dropped, "Points that were left out, by reason.")
      .def_property_readonly(
          "coordinate_system",
          [](const MeshObject& self) { return text_of(self.coordinate_system); },
          "WKT or a code; empty where unknown.")
      .def("facts", &facts_of, "What `orbweave inspect --json` counts, as a dictionary.")
      .def("__repr__", [](const MeshObject& self) {
        return "<orbweave.Mesh of " + format_count(self.mesh.vertices.size()) + " vertices and " +
               format_count(self.mesh.triangles.size()) + " triangles>";
      });
  add_pickle(mesh, &mesh_of_state);
}

}  // namespace

void add_objects(py::module_& module) {
  add_holes(module);
  add_cloud(module);
  add_mesh(module);
}

}  // namespace orbweave::python
