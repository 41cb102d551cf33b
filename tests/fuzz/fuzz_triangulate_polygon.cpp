// Any polygon with any points: triangulated as promised, or refused for a reason. The first byte
// tells how many corners there are, the second whether coordinates are one byte or four.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <set>
#include <vector>

#include "engine/holes/patch/patch_mesh.h"
#include "tests/engine/plane_polygons.h"

namespace {

using orbweave::CornerTriangle;
using orbweave::PlanePoint;
using orbweave::test::Polygon;

void require(bool holds) {
  if (!holds) std::abort();
}

Polygon points_of(const std::uint8_t* data, std::size_t size, bool wide) {
  Polygon points;
  const std::size_t step = wide ? 8 : 2;
  for (; size >= step; data += step, size -= step) {
    PlanePoint p;
    if (wide) {
      std::int32_t xy[2];
      std::memcpy(xy, data, sizeof xy);
      p = {xy[0] / 4, xy[1] / 4};  // some are out of the extent
    } else {
      p = {static_cast<std::int8_t>(data[0]), static_cast<std::int8_t>(data[1])};
    }
    points.push_back(p);
  }
  return points;
}

void require_delaunay(const Polygon& points, const std::vector<CornerTriangle>& triangles) {
  orbweave::HalfEdges mesh;
  require(mesh.assign(triangles, static_cast<std::uint32_t>(points.size())));
  for (std::uint32_t h = 0; h < mesh.size(); ++h) {
    if (mesh.twin[h] == orbweave::kNone32) continue;
    require(orbweave::side_of_circle(points[mesh.origin[h]], points[mesh.target(h)],
                                     points[mesh.apex(h)], points[mesh.apex(mesh.twin[h])]) <= 0);
  }
}

void require_sound(const Polygon& points, std::uint32_t corners,
                   const std::vector<CornerTriangle>& triangles) {
  std::int64_t area = 0;
  std::set<std::uint32_t> interior;
  for (const CornerTriangle& t : triangles) {
    const std::int64_t turn = orbweave::orientation(points[t[0]], points[t[1]], points[t[2]]);
    require(turn > 0);
    area += turn;
    for (const std::uint32_t v : t) {
      if (v >= corners) interior.insert(v);
    }
  }
  require(area == orbweave::test::doubled_area({points.begin(), points.begin() + corners}));
  require(triangles.size() == corners - 2 + 2 * interior.size());
  std::vector<std::uint32_t> vertices(corners);
  for (std::uint32_t i = 0; i < corners; ++i) vertices[i] = i;
  const std::vector<orbweave::Vec3> positions(points.size());
  require(orbweave::PatchMesh(positions, vertices, triangles, {}).defect().empty());
  require_delaunay(points, triangles);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  constexpr std::size_t kMostCorners = 24;
  const bool wide = data[1] % 4 == 0;
  const Polygon points = points_of(data + 2, size - 2, wide);
  const std::size_t corners = std::min<std::size_t>(data[0] % kMostCorners, points.size());
  const Polygon polygon(points.begin(), points.begin() + corners);
  const bool simple = orbweave::is_weakly_simple(polygon);
  if (!wide) require(simple == orbweave::test::is_weakly_simple_by_trial(polygon));
  const auto count = static_cast<std::uint32_t>(corners);
  require(simple == !orbweave::triangulate_polygon(polygon, count).empty());
  const auto triangles = orbweave::triangulate_polygon(points, count);
  if (!triangles.empty()) require_sound(points, count, triangles);
  if (!wide) require(simple == !triangles.empty());
  return 0;
}
