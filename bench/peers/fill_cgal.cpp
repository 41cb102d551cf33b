#include "bench/peers/fill_cgal.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include <chrono>
#include <limits>
#include <map>

namespace orbweave::bench {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
namespace pmp = CGAL::Polygon_mesh_processing;

Point point(Vec3 p) { return {p.x, p.y, p.z}; }

/// Faces keep their order. Vertices with several fans are doubled; false where edges have more
/// than two faces.
bool make_mesh(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
               SurfaceMesh& mesh) {
  std::vector<Point> points;
  for (const Vec3 p : positions) points.push_back(point(p));
  std::vector<std::vector<std::size_t>> polygons;
  for (const Triangle& t : triangles) polygons.push_back({t[0], t[1], t[2]});
  if (!pmp::is_polygon_soup_a_polygon_mesh(polygons)) {
    const std::size_t given = points.size();
    pmp::orient_polygon_soup(points, polygons);
    if (!pmp::is_polygon_soup_a_polygon_mesh(polygons)) return false;
    if (points.size() < given) return false;
  }
  pmp::polygon_soup_to_polygon_mesh(points, polygons, mesh);
  return true;
}

/// The border halfedge from a to b.
SurfaceMesh::Halfedge_index border_edge(const SurfaceMesh& mesh, std::uint32_t a, std::uint32_t b) {
  const auto edge = mesh.halfedge(SurfaceMesh::Vertex_index(a), SurfaceMesh::Vertex_index(b));
  return mesh.is_valid(edge) && mesh.is_border(edge) ? edge : SurfaceMesh::null_halfedge();
}

}  // namespace

Patch fill_by_cgal(const MeshIndex& index, const Disc& disc, const Cut& around,
                   unsigned continuity) {
  Patch patch;
  patch.method = "cgal";
  SurfaceMesh mesh;
  if (!make_mesh(around.mesh.vertices.positions, around.mesh.triangles, mesh)) {
    patch.reason = "the part of the mesh is no manifold";
    return patch;
  }
  const auto border =
      border_edge(mesh, around.number_of(disc.rim[0]), around.number_of(disc.rim[1]));
  if (border == SurfaceMesh::null_halfedge()) {
    patch.reason = "the loop was not found";
    return patch;
  }
  std::vector<SurfaceMesh::Face_index> faces;
  std::vector<SurfaceMesh::Vertex_index> vertices;
  const auto begin = std::chrono::steady_clock::now();
  const bool is_faired = std::get<0>(pmp::triangulate_refine_and_fair_hole(
      mesh, border, std::back_inserter(faces), std::back_inserter(vertices),
      CGAL::parameters::fairing_continuity(continuity)));
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
  patch.seconds = spent.count();
  patch.filled = !faces.empty();
  if (!is_faired) patch.reason = "not faired";
  std::map<SurfaceMesh::Vertex_index, std::uint32_t> numbers;
  for (const auto v : vertices) {
    const auto whole = static_cast<std::uint32_t>(index.mesh().vertices.size());
    numbers[v] = whole + static_cast<std::uint32_t>(patch.positions.size());
    const Point p = mesh.point(v);
    patch.positions.push_back({p.x(), p.y(), p.z()});
  }
  for (const auto f : faces) {
    Triangle t;
    int k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
      const auto at = numbers.find(v);
      t[k++] = at != numbers.end() ? at->second : around.vertices[v];
    }
    patch.triangles.push_back(t);
  }
  return patch;
}

std::uint64_t count_self_intersections(const MeshIndex& index, const Cut& around,
                                       const Patch& patch) {
  const auto whole = static_cast<std::uint32_t>(index.mesh().vertices.size());
  const auto given = static_cast<std::uint32_t>(around.vertices.size());
  std::vector<Vec3> positions = around.mesh.vertices.positions;
  positions.insert(positions.end(), patch.positions.begin(), patch.positions.end());
  std::vector<Triangle> triangles = around.mesh.triangles;
  for (Triangle t : patch.triangles) {
    for (std::uint32_t& v : t) v = v < whole ? around.number_of(v) : given + (v - whole);
    triangles.push_back(t);
  }
  SurfaceMesh mesh;
  if (!make_mesh(positions, triangles, mesh)) return std::numeric_limits<std::uint32_t>::max();
  std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
  pmp::self_intersections(mesh, std::back_inserter(pairs));
  std::uint64_t count = 0;
  for (const auto& [a, b] : pairs) {
    if (a >= around.mesh.triangles.size() || b >= around.mesh.triangles.size()) ++count;
  }
  return count;
}

struct NearestFace::Tree {
  using Triangles = std::vector<Kernel::Triangle_3>;
  using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
  Triangles triangles;
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree;
};

NearestFace::NearestFace(const TriangleMesh& mesh) : tree_(std::make_unique<Tree>()) {
  for (const Triangle& t : mesh.triangles) {
    tree_->triangles.emplace_back(point(mesh.vertices.positions[t[0]]),
                                  point(mesh.vertices.positions[t[1]]),
                                  point(mesh.vertices.positions[t[2]]));
  }
  tree_->tree.rebuild(tree_->triangles.begin(), tree_->triangles.end());
  tree_->tree.accelerate_distance_queries();
}

NearestFace::~NearestFace() = default;

NearestFace::Found NearestFace::operator()(Vec3 place) const {
  const auto [at, primitive] = tree_->tree.closest_point_and_primitive(point(place));
  return {CGAL::squared_distance(at, point(place)),
          static_cast<std::uint32_t>(primitive - tree_->triangles.begin())};
}

}  // namespace orbweave::bench
