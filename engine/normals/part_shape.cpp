#include "engine/normals/part_shape.h"

#include <array>
#include <cmath>
#include <limits>

#include "engine/geometry/symmetric_eigen.h"
#include "io/box.h"

namespace orbweave {
namespace {

/// Sums over the patches of a part.
struct Sums {
  Box bounds;
  SymmetricMatrix enclosed;  // symmetric part of outer products of area vectors and places
  double level = 0.0;        // area of nearly level patches
  // Of nearly upright patches: the fourth power of the horizontal normal as a complex number, by
  // area. Normals at right angles to each other add up.
  double four_x = 0.0, four_y = 0.0;

  Vec3 center() const { return bounds.min + 0.5 * (bounds.max - bounds.min); }
};

/// A sheet whose area vector is this many times its flux per diagonal of the bounds is no shell:
/// which side bulges says little.
constexpr double kSheet = 20.0;
/// So much of a landscape's area adds up to an area vector, and that stands so upright; whatever
/// grows on it encloses next to nothing. A closed surface's adds up to nothing.
constexpr double kOpen = 0.15;
constexpr double kUpright = 0.7;

PartKind kind_of(const PartShape& shape, double diagonal) {
  const double open = norm(shape.area_normal);
  if (open > kOpen * shape.area && std::abs(shape.area_normal.z) > kUpright * open)
    return PartKind::kLandscape;
  return open * diagonal > kSheet * std::abs(shape.flux) ? PartKind::kSheet : PartKind::kShell;
}

void add_direction(const PatchSum& patch, Sums& sums) {
  constexpr double kAlong = 0.985, kAcross = 0.17;  // 10 degrees
  // Patches at corners have no direction.
  const double area = surface_area(patch);
  if (!(area > 0.0)) return;
  const Vec3 n = normalized(patch.area_normal);
  if (std::abs(n.z) > kAlong) sums.level += area;
  const double flat = n.x * n.x + n.y * n.y;
  if (std::abs(n.z) > kAcross) return;
  const double x2 = (n.x * n.x - n.y * n.y) / flat, y2 = 2.0 * n.x * n.y / flat;
  sums.four_x += area * (x2 * x2 - y2 * y2);
  sums.four_y += area * 2.0 * x2 * y2;
}

/// Of a closed surface, whatever its shape, the integral of the outer product of normal and place
/// is the volume along every axis (divergence theorem). What is open at both ends lacks the axis
/// through them; what is open at one end lacks about half of it.
bool is_tube(const Sums& sums) {
  constexpr double kOpenAtBothEnds = 0.4, kRound = 0.5;
  std::array<double, 3> volumes = eigen_of(sums.enclosed).values;
  if (volumes[0] + volumes[1] + volumes[2] < 0.0) volumes = {-volumes[2], -volumes[1], -volumes[0]};
  return volumes[0] < kOpenAtBothEnds * volumes[1] && volumes[1] > kRound * volumes[2];
}

bool is_box(const Sums& sums, double area) {
  // Patches near edges lean towards both of their sides.
  constexpr double kBox = 0.6, kMostLevel = 0.9;
  const double upright = std::hypot(sums.four_x, sums.four_y);
  return area > 0.0 && sums.level + upright > kBox * area && sums.level < kMostLevel * area &&
         upright < kMostLevel * area;
}

/// Upward, or to the back, or to the right where a sheet stands upright.
bool points_down(Vec3 area_normal) {
  for (const double component : {area_normal.z, area_normal.y, area_normal.x})
    if (std::abs(component) > 0.1 * norm(area_normal)) return component < 0.0;
  return false;
}

/// The symmetric part of the outer product.
SymmetricMatrix symmetric_product(Vec3 a, Vec3 b) {
  return {a.x * b.x, 0.5 * (a.x * b.y + a.y * b.x), 0.5 * (a.x * b.z + a.z * b.x),
          a.y * b.y, 0.5 * (a.y * b.z + a.z * b.y), a.z * b.z};
}

void finish(const Sums& sums, PartShape& shape) {
  const double diagonal = norm(sums.bounds.max - sums.bounds.min);
  shape.kind = kind_of(shape, diagonal);
  if (!(shape.area > 0.0)) return;
  shape.openness = norm(shape.area_normal) / shape.area;
  if (diagonal > 0.0) shape.bulge = 2.0 * shape.flux / (shape.area * diagonal);
  shape.is_tube = is_tube(sums);
  shape.is_box = is_box(sums, shape.surface);
}

}  // namespace

std::vector<PartShape> shapes_of_parts(std::span<const PatchSum> sums, const SignedParts& parts) {
  constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> row_of(sums.size(), kNone);
  std::vector<PartShape> shapes;
  std::vector<Sums> of;
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    if (parts.part[v] == v) {
      row_of[v] = static_cast<std::uint32_t>(shapes.size());
      shapes.emplace_back().first = v;
      of.emplace_back();
    }
    Sums& part = of[row_of[parts.part[v]]];
    part.bounds.extend(sums[v].lowest);
    part.bounds.extend(sums[v].highest);
    add_direction(sums[v], part);
  }
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    const std::uint32_t row = row_of[parts.part[v]];
    PartShape& shape = shapes[row];
    shape.center = of[row].center();
    const double sign = parts.turn[v] ? -1.0 : 1.0;
    const Vec3 normal = sign * sums[v].area_normal;
    of[row].enclosed += symmetric_product(normal, center_of(sums[v]) - shape.center);
    shape.area_normal = shape.area_normal + normal;
    shape.area += norm(sums[v].area_normal);
    shape.surface += surface_area(sums[v]);
    shape.flux +=
        sign * (sums[v].flux + dot(sums[v].area_normal, sums[v].flux_origin - shape.center));
  }
  for (std::size_t row = 0; row < shapes.size(); ++row) finish(of[row], shapes[row]);
  return shapes;
}

bool shows_wrong_side(const PartShape& shape, bool inward) {
  if (shape.kind == PartKind::kLandscape) return shape.area_normal.z < 0.0;
  if (shape.kind == PartKind::kSheet) return points_down(shape.area_normal);
  return inward ? shape.flux > 0.0 : shape.flux < 0.0;
}

}  // namespace orbweave
