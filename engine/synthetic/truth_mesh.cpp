#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "engine/synthetic/plate.h"
#include "engine/synthetic/surfaces.h"
#include "engine/synthetic/synthetic_cloud.h"

namespace orbweave {
namespace {

using portable::sine_cosine;
using portable::SineCosine;
using synthetic::SurfacePoint;

struct MeshBuilder {
  TriangleMesh mesh;

  MeshBuilder() {
    mesh.vertices.schema.has_normals = true;
    mesh.vertices.schema.normal_type = ScalarType::kFloat64;
  }
  std::uint32_t add(SurfacePoint point) {
    mesh.vertices.positions.push_back(point.position);
    mesh.vertices.normals.push_back(point.normal);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  }
  void add_quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
};

using Surface = std::function<SurfacePoint(double u, double v)>;

/// Grid of columns x rows cells over the unit square, closed in both directions.
TriangleMesh closed_grid(std::uint32_t columns, std::uint32_t rows, const Surface& surface) {
  MeshBuilder builder;
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i)
      builder.add(surface(static_cast<double>(i) / columns, static_cast<double>(j) / rows));
  const auto at = [&](std::uint32_t i, std::uint32_t j) {
    return (j % rows) * columns + i % columns;
  };
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i)
      builder.add_quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  return builder.mesh;
}

/// Appends an open grid of cells; `flipped` turns the triangles over.
void append_open_grid(MeshBuilder& builder, std::uint32_t cells, bool flipped,
                      const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& vertex) {
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = vertex(i, j), b = vertex(i + 1, j);
      const std::uint32_t c = vertex(i + 1, j + 1), d = vertex(i, j + 1);
      flipped ? builder.add_quad(a, d, c, b) : builder.add_quad(a, b, c, d);
    }
}

void append_square(MeshBuilder& builder, std::uint32_t cells, double z, bool up) {
  const auto first = static_cast<std::uint32_t>(builder.mesh.vertices.size());
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i)
      builder.add({{static_cast<double>(i) / cells, static_cast<double>(j) / cells, z},
                   {0.0, 0.0, up ? 1.0 : -1.0}});
  append_open_grid(builder, cells, !up,
                   [&](std::uint32_t i, std::uint32_t j) { return first + j * (cells + 1) + i; });
}

TriangleMesh sphere_mesh(std::uint32_t columns) {
  const std::uint32_t rows = columns / 2;
  MeshBuilder builder;
  const std::uint32_t south = builder.add({{0, 0, -1}, {0, 0, -1}});
  for (std::uint32_t j = 1; j < rows; ++j) {
    const SineCosine b = sine_cosine(0.5 * j / rows - 0.25);
    for (std::uint32_t i = 0; i < columns; ++i) {
      const SineCosine a = sine_cosine(static_cast<double>(i) / columns);
      const Vec3 p{b.cosine * a.cosine, b.cosine * a.sine, b.sine};
      builder.add({p, normalized(p)});
    }
  }
  const std::uint32_t north = builder.add({{0, 0, 1}, {0, 0, 1}});
  const auto at = [&](std::uint32_t i, std::uint32_t j) {
    return 1 + (j - 1) * columns + i % columns;
  };
  for (std::uint32_t i = 0; i < columns; ++i) {
    builder.mesh.triangles.push_back({south, at(i + 1, 1), at(i, 1)});
    for (std::uint32_t j = 1; j + 1 < rows; ++j)
      builder.add_quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    builder.mesh.triangles.push_back({north, at(i, rows - 1), at(i + 1, rows - 1)});
  }
  return builder.mesh;
}

TriangleMesh cube_mesh(std::uint32_t cells) {
  MeshBuilder builder;
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> known;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const auto vertex = [&](std::uint32_t i, std::uint32_t j) {
      std::array<std::uint32_t, 3> key{};
      key[axis] = face % 2 == 1 ? cells : 0;
      key[(axis + 1) % 3] = i;
      key[(axis + 2) % 3] = j;
      const auto [entry, is_new] = known.try_emplace(key, 0);
      if (is_new) {
        const auto part = [&](int k) { return static_cast<double>(key[k]) / cells; };
        const Vec3 p{part(0), part(1), part(2)};
        entry->second = builder.add({p, synthetic::cube_normal(p)});
      }
      return entry->second;
    };
    append_open_grid(builder, cells, face % 2 == 0, vertex);
  }
  return builder.mesh;
}

TriangleMesh torus_mesh(std::uint32_t columns) {
  return closed_grid(columns, std::max(4u, columns / 3),
                     [](double u, double v) { return synthetic::torus_point(u, sine_cosine(v)); });
}

/// A flat side of the plate with three holes, in three sectors around the holes: vertices on lines
/// from each hole's border to the sector's border. Loops are counter-clockwise seen from above.
class PlateSide {
 public:
  PlateSide(MeshBuilder& builder, std::uint32_t cells, bool up)
      : builder_(builder), sheet_(up ? synthetic::kPlateTop : synthetic::kPlateBottom) {
    radial_ = std::max(3u, cells / 6);
    arc_ = std::max(4u, cells / 3);
    rings_ = std::max(2u, cells / 10);
    center_ = add(0.0, 0.0);
    for (int k = 0; k < synthetic::kPlateHoles; ++k) add_border(k);
    for (int k = 0; k < synthetic::kPlateHoles; ++k) fill_sector(k);
  }

  const std::vector<std::uint32_t>& outer() const { return outer_; }
  const std::vector<std::uint32_t>& hole(int k) const {
    return holes_[static_cast<std::size_t>(k)];
  }

 private:
  std::uint32_t add(double x, double y) {
    return builder_.add(synthetic::plate_side_point(sheet_, x, y));
  }
  std::uint32_t add_at(double from_center, double turns) {
    const SineCosine a = sine_cosine(turns);
    return add(from_center * a.cosine, from_center * a.sine);
  }

  /// The border from the plate's centre to its edge before sector k, and its arc of the edge.
  void add_border(int k) {
    const double turns = (static_cast<double>(k) - 0.5) / synthetic::kPlateHoles;
    auto& line = lines_[static_cast<std::size_t>(k)];
    line.push_back(center_);
    for (std::uint32_t i = 1; i <= radial_; ++i)
      line.push_back(add_at(synthetic::kPlateRadius * i / radial_, turns));
    outer_.push_back(line.back());
    for (std::uint32_t j = 1; j < arc_; ++j)
      outer_.push_back(add_at(synthetic::kPlateRadius,
                              turns + static_cast<double>(j) / (synthetic::kPlateHoles * arc_)));
  }

  void fill_sector(int k) {
    const auto sector = static_cast<std::uint32_t>(k);
    const auto& first = lines_[sector];
    const auto& last = lines_[(sector + 1) % lines_.size()];
    std::vector<std::uint32_t> border(first.begin(), first.end());
    for (std::uint32_t j = 1; j < arc_; ++j) border.push_back(outer_[sector * arc_ + j]);
    for (std::uint32_t i = radial_; i > 0; --i) border.push_back(last[i]);
    const Vec3 center = synthetic::plate_hole_center(k);
    for (std::uint32_t ring = 0; ring < rings_; ++ring) {
      std::vector<std::uint32_t> inner;
      for (const std::uint32_t vertex : border) {
        const Vec3 at = builder_.mesh.vertices.positions[vertex];
        const Vec3 offset{at.x - center.x, at.y - center.y, 0.0};
        const Vec3 rim = synthetic::kPlateHoleRadius * normalized(offset);
        const double part = 1.0 / (rings_ - ring);
        const Vec3 p = center + (1.0 - part) * offset + part * rim;
        inner.push_back(add(p.x, p.y));
      }
      for (std::size_t i = 0; i < border.size(); ++i) {
        const std::size_t j = (i + 1) % border.size();
        if (sheet_ == synthetic::kPlateTop)
          builder_.add_quad(border[i], border[j], inner[j], inner[i]);
        else
          builder_.add_quad(border[i], inner[i], inner[j], border[j]);
      }
      border = std::move(inner);
    }
    holes_.push_back(std::move(border));
  }

  MeshBuilder& builder_;
  synthetic::PlateSheet sheet_;
  std::uint32_t radial_ = 0, arc_ = 0, rings_ = 0, center_ = 0;
  std::array<std::vector<std::uint32_t>, synthetic::kPlateHoles> lines_;
  std::vector<std::uint32_t> outer_;
  std::vector<std::vector<std::uint32_t>> holes_;
};

/// The rim between two loops of the flat sides.
void append_plate_rim(MeshBuilder& builder, std::uint32_t rows, int sheet,
                      const std::vector<std::uint32_t>& top,
                      const std::vector<std::uint32_t>& bottom) {
  const Vec3 center = sheet == synthetic::kPlateRim
                          ? Vec3{}
                          : synthetic::plate_hole_center(sheet - synthetic::kPlateFirstHole);
  std::vector<std::uint32_t> upper = top;
  for (std::uint32_t row = 1; row <= rows; ++row) {
    std::vector<std::uint32_t> lower = bottom;
    for (std::size_t i = 0; row < rows && i < lower.size(); ++i) {
      const Vec3 at = builder.mesh.vertices.positions[top[i]] - center;
      const double radius = std::sqrt(at.x * at.x + at.y * at.y);
      lower[i] = builder.add(synthetic::plate_rim_point(
          sheet, SineCosine{at.y / radius, at.x / radius}, sine_cosine(0.25 - 0.5 * row / rows)));
    }
    for (std::size_t i = 0; i < upper.size(); ++i) {
      const std::size_t j = (i + 1) % upper.size();
      if (sheet == synthetic::kPlateRim)
        builder.add_quad(upper[i], lower[i], lower[j], upper[j]);
      else
        builder.add_quad(upper[i], upper[j], lower[j], lower[i]);
    }
    upper = std::move(lower);
  }
}

TriangleMesh plate_mesh(std::uint32_t cells) {
  MeshBuilder builder;
  const PlateSide top(builder, cells, true), bottom(builder, cells, false);
  const std::uint32_t rows = std::max(4u, cells / 8);
  append_plate_rim(builder, rows, synthetic::kPlateRim, top.outer(), bottom.outer());
  for (int k = 0; k < synthetic::kPlateHoles; ++k)
    append_plate_rim(builder, rows, synthetic::kPlateFirstHole + k, top.hole(k), bottom.hole(k));
  return builder.mesh;
}

/// The torus and the sphere above it, whose edges are about as long.
TriangleMesh two_components_mesh(std::uint32_t cells) {
  TriangleMesh mesh = torus_mesh(cells);
  const TriangleMesh sphere = sphere_mesh(std::max(8u, cells / 2));
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::size_t i = 0; i < sphere.vertices.size(); ++i) {
    const SurfacePoint point =
        synthetic::upper_sphere_point({sphere.vertices.positions[i], sphere.vertices.normals[i]});
    mesh.vertices.positions.push_back(point.position);
    mesh.vertices.normals.push_back(point.normal);
  }
  for (const Triangle& t : sphere.triangles)
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return mesh;
}

}  // namespace

TriangleMesh truth_mesh(const SyntheticOptions& options, std::uint32_t resolution) {
  const std::uint32_t cells = std::max(8u, resolution);
  MeshBuilder builder;
  switch (options.shape) {
    case Shape::kSphere:
      return sphere_mesh(cells);
    case Shape::kTorus:
      return torus_mesh(cells);
    case Shape::kBumpyTorus:
      return closed_grid(cells, std::max(4u, cells / 3), [](double u, double v) {
        return synthetic::bumpy_torus_point(u, v, sine_cosine(v));
      });
    case Shape::kPlane:
      append_square(builder, cells, 0.0, true);
      return builder.mesh;
    case Shape::kDoubleWall:
      append_square(builder, cells, 0.0, false);
      append_square(builder, cells, synthetic::kWallGap * spacing(options), true);
      return builder.mesh;
    case Shape::kCube:
      return cube_mesh(cells);
    case Shape::kTwoComponents:
      return two_components_mesh(cells);
    case Shape::kGenusThree:
      return plate_mesh(cells);
  }
  return builder.mesh;
}

}  // namespace orbweave
