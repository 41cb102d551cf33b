#include "tests/engine/hole_problems.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "engine/holes/hole_pass.h"
#include "engine/holes/loops/mesh_surface.h"
#include "engine/holes/loops/neighborhood.h"
#include "tests/support/meshes.h"

namespace orbweave::test {

TriangleMesh without(TriangleMesh mesh, const std::function<bool(Vec3)>& gone) {
  cut(mesh, gone);
  return mesh;
}

TriangleMesh transformed(TriangleMesh mesh, double scale, Vec3 offset) {
  return moved(std::move(mesh), [&](Vec3 p) { return scale * p + offset; });
}

TriangleMesh open_tube(std::size_t around, std::size_t rows) {
  const double step = 2.0 * std::numbers::pi / static_cast<double>(around);
  const double length = step * static_cast<double>(rows);
  TriangleMesh mesh = grid_mesh(around, rows, true, [&](double u, double v) {
    const double angle = 2.0 * std::numbers::pi * u;
    return Vec3{std::cos(angle), std::sin(angle), length * (v - 1.0)};
  });
  const auto bottom = static_cast<std::uint32_t>(mesh.vertices.positions.size());
  mesh.vertices.positions.push_back({0.0, 0.0, -length});
  for (std::uint32_t i = 0; i < around; ++i) {
    mesh.triangles.push_back({(i + 1) % static_cast<std::uint32_t>(around), i, bottom});
  }
  return mesh;
}

TriangleMesh height_field(std::size_t side, const std::function<double(double, double)>& height) {
  return grid_mesh(side, side, false, [&](double u, double v) {
    const double x = 2.0 * u - 1.0, y = 2.0 * v - 1.0;
    return Vec3{x, y, height(x, y)};
  });
}

std::vector<HoleProblem> problems_of(const TriangleMesh& mesh, double radius_factor) {
  const MeshSurface surface(mesh);
  const MeshComponents components = find_components(mesh, surface);
  MeshBoundary boundary = find_boundary(mesh, surface, components.of_triangle);
  const std::vector<BoundaryLoop> loops = trace_loops(std::move(boundary.fans), boundary.vertices);
  const SharedVertices shared(loops);
  NeighborhoodOptions options;
  options.radius_factor = radius_factor;
  std::vector<HoleProblem> problems;
  for (std::uint32_t l = 0; l < loops.size(); ++l) {
    const auto apart = shared.groups_on(loops[l], l);
    problems.push_back(gather_hole(surface, loops[l], apart, options).problem);
  }
  return problems;
}

HoleProblem only_problem_of(const TriangleMesh& mesh, double radius_factor) {
  std::vector<HoleProblem> problems = problems_of(mesh, radius_factor);
  if (problems.size() != 1) throw std::logic_error("not one hole");
  return std::move(problems[0]);
}

HoleProblem inner_problem_of(const TriangleMesh& mesh) {
  std::vector<HoleProblem> problems = problems_of(mesh);
  if (problems.size() != 2) throw std::logic_error("not one hole and a border");
  const bool second = problems[1].loop.size() < problems[0].loop.size();
  return std::move(problems[second ? 1 : 0]);
}

void set_values(HoleProblem& problem, const std::function<std::vector<double>(Vec3)>& values_at) {
  problem.channels = static_cast<std::uint32_t>(values_at({}).size());
  problem.values_of = [positions = problem.positions,
                       values_at](std::span<const std::uint32_t> vertices) {
    std::vector<double> rows;
    for (const std::uint32_t v : vertices)
      for (const double value : values_at(positions[v])) rows.push_back(value);
    return rows;
  };
}

TriangleMesh pasted(const HoleProblem& problem, const HolePatch& patch) {
  TriangleMesh mesh;
  mesh.vertices.positions = problem.positions;
  mesh.vertices.positions.insert(mesh.vertices.positions.end(), patch.positions.begin(),
                                 patch.positions.end());
  mesh.triangles = problem.sheet;
  mesh.triangles.insert(mesh.triangles.end(), patch.triangles.begin(), patch.triangles.end());
  return mesh;
}

}  // namespace orbweave::test
