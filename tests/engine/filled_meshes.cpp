#include "tests/engine/filled_meshes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/validation/mesh_facts.h"
#include "tests/support/meshes.h"

namespace orbweave::test {

void require_sound(const TriangleMesh& before, const FilledMesh& filled) {
  const TriangleMesh& mesh = filled.mesh;
  REQUIRE(validate_mesh(mesh).empty());
  REQUIRE(mesh.vertices.size() >= before.vertices.size());
  REQUIRE(std::equal(before.vertices.positions.begin(), before.vertices.positions.end(),
                     mesh.vertices.positions.begin()));
  REQUIRE(mesh.triangles.size() >= before.triangles.size());
  REQUIRE(std::equal(before.triangles.begin(), before.triangles.end(), mesh.triangles.begin()));
  REQUIRE(mesh.hole.size() == mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    REQUIRE((mesh.hole[t] == 0) == (t < before.triangles.size()));
  }
  const MeshFacts facts = mesh_facts(mesh);
  REQUIRE(facts.nonmanifold_edges == 0);
  REQUIRE(facts.inconsistent_edges == 0);
  REQUIRE(facts.nonmanifold_vertices == 0);
}

void require_closed(const TriangleMesh& before, const FilledMesh& filled) {
  require_sound(before, filled);
  const MeshFacts facts = mesh_facts(filled.mesh);
  REQUIRE(facts.boundary_edges == 0);
  REQUIRE(facts.watertight);
}

std::size_t count_filled(const FilledMesh& filled) {
  return static_cast<std::size_t>(std::count_if(filled.holes.begin(), filled.holes.end(),
                                                [](const HoleFacts& hole) { return hole.filled; }));
}

double farthest_new_vertex(const TriangleMesh& before, const FilledMesh& filled,
                           const std::function<double(Vec3)>& distance) {
  double farthest = 0.0;
  for (std::size_t v = before.vertices.size(); v < filled.mesh.vertices.size(); ++v) {
    farthest = std::max(farthest, std::abs(distance(filled.mesh.vertices.positions[v])));
  }
  return farthest;
}

double off_sphere(Vec3 p) { return norm(p) - 1.0; }

TriangleMesh tube(double length) {
  return grid_mesh(48, static_cast<std::size_t>(48.0 * length / 2.0 / std::numbers::pi) + 1, true,
                   [&](double u, double v) {
                     const double angle = 2.0 * std::numbers::pi * u;
                     return Vec3{std::cos(angle), std::sin(angle), length * v};
                   });
}

}  // namespace orbweave::test
