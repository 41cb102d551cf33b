#include "tests/support/meshes.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace orbweave::test {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

void drop_unused(TriangleMesh& mesh) {
  std::vector<std::uint32_t> number(mesh.vertices.size(), 0xffffffffu);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t vertex : t) number[vertex] = 0;
  }
  PointCloud kept;
  kept.schema = mesh.vertices.schema;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] != 0) continue;
    number[v] = static_cast<std::uint32_t>(kept.size());
    kept.append(mesh.vertices, v);
  }
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& vertex : t) vertex = number[vertex];
  }
  mesh.vertices = std::move(kept);
}

/// Joins vertices at the same place.
void weld(TriangleMesh& mesh) {
  std::map<std::array<double, 3>, std::uint32_t> place;
  std::vector<std::uint32_t> first;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3 p = mesh.vertices.positions[v];
    first.push_back(place.try_emplace({p.x, p.y, p.z}, v).first->second);
  }
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& vertex : t) vertex = first[vertex];
  }
  drop_unused(mesh);
}

}  // namespace

TriangleMesh grid_mesh(std::size_t columns, std::size_t rows, bool wrapped,
                       const std::function<Vec3(double, double)>& place) {
  TriangleMesh mesh;
  const std::size_t width = wrapped ? columns : columns + 1;
  for (std::size_t r = 0; r <= rows; ++r) {
    for (std::size_t c = 0; c < width; ++c) {
      mesh.vertices.positions.push_back(place(static_cast<double>(c) / static_cast<double>(columns),
                                              static_cast<double>(r) / static_cast<double>(rows)));
    }
  }
  const auto at = [&](std::size_t c, std::size_t r) {
    return static_cast<std::uint32_t>(r * width + c % width);
  };
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      mesh.triangles.push_back({at(c, r), at(c + 1, r), at(c + 1, r + 1)});
      mesh.triangles.push_back({at(c, r), at(c + 1, r + 1), at(c, r + 1)});
    }
  }
  return mesh;
}

TriangleMesh square_mesh(std::size_t side) {
  return grid_mesh(side, side, false, [](double u, double v) { return Vec3{u, v, 0.0}; });
}

TriangleMesh torus_mesh(std::size_t vertices) {
  const auto rows =
      static_cast<std::size_t>(std::lround(std::sqrt(0.4 * static_cast<double>(vertices))));
  const std::size_t columns = vertices / rows;
  TriangleMesh mesh = grid_mesh(columns, rows, true, [&](double u, double v) {
    // The last row lies on the first bit by bit, so that they can be joined.
    const double angle = v == 1.0 ? 0.0 : kTurn * v;
    const double from_axis = 1.0 + 0.4 * std::cos(angle);
    return Vec3{from_axis * std::cos(kTurn * u), from_axis * std::sin(kTurn * u),
                0.4 * std::sin(angle)};
  });
  weld(mesh);
  return mesh;
}

TriangleMesh sphere_mesh(int levels) {
  TriangleMesh mesh;
  mesh.vertices.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> middle;
    std::vector<Vec3>& at = mesh.vertices.positions;
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
      const auto next = static_cast<std::uint32_t>(at.size());
      const auto [entry, is_new] = middle.try_emplace({std::min(a, b), std::max(a, b)}, next);
      if (is_new) at.push_back(normalized(at[a] + at[b]));
      return entry->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

TriangleMesh cube_mesh(std::size_t side) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double level : {0.0, 1.0}) {
      TriangleMesh face = grid_mesh(side, side, false, [&](double u, double v) {
        Vec3 p;
        p[axis] = level;
        p[(axis + 1) % 3] = u;
        p[(axis + 2) % 3] = v;
        return p;
      });
      mesh = joined(mesh, level == 1.0 ? face : flipped(face));
    }
  }
  weld(mesh);
  return mesh;
}

void cut(TriangleMesh& mesh, const std::function<bool(Vec3)>& gone) {
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const std::vector<Vec3>& at = mesh.vertices.positions;
    return gone((at[t[0]] + at[t[1]] + at[t[2]]) / 3.0);
  });
  drop_unused(mesh);
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh both = a;
  const auto base = static_cast<std::uint32_t>(a.vertices.size());
  both.vertices.append(b.vertices);
  for (const Triangle& t : b.triangles) {
    both.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
  return both;
}

TriangleMesh flipped(TriangleMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const std::function<Vec3(Vec3)>& to) {
  for (Vec3& p : mesh.vertices.positions) p = to(p);
  return mesh;
}

}  // namespace orbweave::test
