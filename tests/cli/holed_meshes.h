// Meshes with holes, made of the surfaces that `generate` knows.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave::test {

/// The exact mesh of a shape, about as fine as `points` points.
inline TriangleMesh shape_mesh(const ScratchDirectory& in, const std::string& shape,
                               int points = 4000) {
  const auto made = run_program({"generate", shape, "--points", std::to_string(points), "-o",
                                 "shape-cloud.ply", "--truth", "shape.ply"},
                                {.directory = in.path()});
  if (made.status != 0) return {};
  TriangleMesh mesh = read_mesh(in / "shape.ply");
  std::filesystem::remove(in / "shape.ply");
  std::filesystem::remove(in / "shape-cloud.ply");
  return mesh;
}

/// Without the triangles that have a corner within `radius` of `center`, and without the vertices
/// that no triangle uses then.
inline TriangleMesh with_hole(const TriangleMesh& mesh, Vec3 center, double radius) {
  TriangleMesh left;
  left.vertices.schema = mesh.vertices.schema;
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
  for (const Triangle& t : mesh.triangles) {
    bool outside = true;
    for (const std::uint32_t v : t)
      outside = outside && norm(mesh.vertices.positions[v] - center) > radius;
    if (!outside) continue;
    Triangle kept = t;
    for (std::uint32_t& v : kept) {
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(left.vertices.size());
        left.vertices.append(mesh.vertices, v);
      }
      v = number[v];
    }
    left.triangles.push_back(kept);
  }
  return left;
}

}  // namespace orbweave::test
