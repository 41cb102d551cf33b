#include "engine/geometry/triangle_intersection.h"
#include "io/vec3_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace orbweave {
namespace {

/// Half the distance from 1 to the next double, Shewchuk's epsilon.
constexpr double kEpsilon = 0.5 * std::numeric_limits<double>::epsilon();

int sign_of(double value) { return value > 0.0 ? 1 : value < 0.0 ? -1 : 0; }

/// A sum of doubles without rounding: components do not overlap and grow in magnitude, zeros left
/// out. `Capacity` is what the largest one in side_of_plane can have.
class Expansion {
 public:
  static constexpr std::size_t kCapacity = 192;

  static Expansion difference(double a, double b) {
    Expansion result;
    result.add(a);
    result.add(-b);
    return result;
  }

  /// Grow-expansion, Shewchuk figure 6.
  void add(double b) {
    std::size_t kept = 0;
    double q = b;
    for (std::size_t i = 0; i < size_; ++i) {
      const double e = parts_[i];
      const double sum = q + e;
      const double of_e = sum - q;
      const double rest = (q - (sum - of_e)) + (e - of_e);
      q = sum;
      if (rest != 0.0) parts_[kept++] = rest;
    }
    if (q != 0.0) parts_[kept++] = q;
    size_ = kept;
  }
  void add(const Expansion& other) {
    for (std::size_t i = 0; i < other.size_; ++i) add(other.parts_[i]);
  }
  void subtract(const Expansion& other) {
    for (std::size_t i = 0; i < other.size_; ++i) add(-other.parts_[i]);
  }

  friend Expansion operator*(const Expansion& a, const Expansion& b) {
    Expansion result;
    for (std::size_t i = 0; i < a.size_; ++i) {
      for (std::size_t k = 0; k < b.size_; ++k) {
        const double product = a.parts_[i] * b.parts_[k];
        result.add(std::fma(a.parts_[i], b.parts_[k], -product));
        result.add(product);
      }
    }
    return result;
  }

  int sign() const { return size_ == 0 ? 0 : sign_of(parts_[size_ - 1]); }

 private:
  std::array<double, kCapacity> parts_{};
  std::size_t size_ = 0;
};

Expansion minor_of(const Expansion& a, const Expansion& b, const Expansion& c, const Expansion& d) {
  Expansion result = a * b;
  result.subtract(c * d);
  return result;
}

int exact_side_of_plane(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  using E = Expansion;
  const E ax = E::difference(a.x, d.x), ay = E::difference(a.y, d.y), az = E::difference(a.z, d.z);
  const E bx = E::difference(b.x, d.x), by = E::difference(b.y, d.y), bz = E::difference(b.z, d.z);
  const E cx = E::difference(c.x, d.x), cy = E::difference(c.y, d.y), cz = E::difference(c.z, d.z);
  E sum = minor_of(bx, cy, by, cx) * az;
  sum.add(minor_of(cx, ay, cy, ax) * bz);
  sum.add(minor_of(ax, by, ay, bx) * cz);
  return sum.sign();
}

/// 2 where doubles cannot tell.
int quick_side_of_plane(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  constexpr double kBound = (7.0 + 56.0 * kEpsilon) * kEpsilon;
  const Vec3 u = a - d, v = b - d, w = c - d;
  const double vx_wy = v.x * w.y, vy_wx = v.y * w.x;
  const double wx_uy = w.x * u.y, wy_ux = w.y * u.x;
  const double ux_vy = u.x * v.y, uy_vx = u.y * v.x;
  const double det = u.z * (vx_wy - vy_wx) + v.z * (wx_uy - wy_ux) + w.z * (ux_vy - uy_vx);
  const double size = (std::abs(vx_wy) + std::abs(vy_wx)) * std::abs(u.z) +
                      (std::abs(wx_uy) + std::abs(wy_ux)) * std::abs(v.z) +
                      (std::abs(ux_vy) + std::abs(uy_vx)) * std::abs(w.z);
  return std::abs(det) > kBound * size ? sign_of(det) : 2;
}

/// A point of a coordinate plane.
struct Point2 {
  double x = 0.0;
  double y = 0.0;
};

Point2 without_axis(Vec3 p, int axis) { return {p[(axis + 1) % 3], p[(axis + 2) % 3]}; }

/// Orientation of three points in a plane; 2 where doubles cannot tell.
int quick_turn(Point2 a, Point2 b, Point2 c) {
  constexpr double kBound = (3.0 + 16.0 * kEpsilon) * kEpsilon;
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  const double det = left - right;
  return std::abs(det) > kBound * (std::abs(left) + std::abs(right)) ? sign_of(det) : 2;
}

int turn(Point2 a, Point2 b, Point2 c) {
  const int quick = quick_turn(a, b, c);
  if (quick != 2) return quick;
  using E = Expansion;
  return minor_of(E::difference(a.x, c.x), E::difference(b.y, c.y), E::difference(a.y, c.y),
                  E::difference(b.x, c.x))
      .sign();
}

/// The axis along which a triangle is seen largest.
int widest_axis(Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 area = cross(b - a, c - a);
  const double x = std::abs(area.x), y = std::abs(area.y), z = std::abs(area.z);
  return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

int turn_along(int axis, Vec3 a, Vec3 b, Vec3 c) {
  return turn(without_axis(a, axis), without_axis(b, axis), without_axis(c, axis));
}

/// An axis along which a triangle is seen as one; empty where its corners lie on a line. Exact,
/// where rounding may have hidden the area.
std::optional<int> open_axis(Vec3 a, Vec3 b, Vec3 c) {
  const int widest = widest_axis(a, b, c);
  for (int k = 0; k < 3; ++k)
    if (const int axis = (widest + k) % 3; turn_along(axis, a, b, c) != 0) return axis;
  return std::nullopt;
}

/// Closed segments ab and pq in a plane.
bool segments_meet(Point2 a, Point2 b, Point2 p, Point2 q) {
  const int pa = turn(p, q, a), pb = turn(p, q, b), ap = turn(a, b, p), aq = turn(a, b, q);
  if (pa * pb > 0 || ap * aq > 0) return false;
  if (pa != 0 || pb != 0 || ap != 0 || aq != 0) return true;
  // All on one line: do their ranges overlap?
  const auto overlap = [](double a0, double a1, double b0, double b1) {
    return std::max(std::min(a0, a1), std::min(b0, b1)) <=
           std::min(std::max(a0, a1), std::max(b0, b1));
  };
  return overlap(a.x, b.x, p.x, q.x) && overlap(a.y, b.y, p.y, q.y);
}

bool contains(const std::array<Point2, 3>& t, Point2 p) {
  const int s0 = turn(t[0], t[1], p), s1 = turn(t[1], t[2], p), s2 = turn(t[2], t[0], p);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

/// Closed segments ab and pq in space.
bool segments_meet(Vec3 a, Vec3 b, Vec3 p, Vec3 q) {
  if (side_of_plane(a, b, p, q) != 0) return false;
  std::optional<int> axis = open_axis(a, b, p);
  if (!axis) axis = open_axis(a, b, q);
  if (!axis) axis = open_axis(p, q, a);
  if (axis)
    return segments_meet(without_axis(a, *axis), without_axis(b, *axis), without_axis(p, *axis),
                         without_axis(q, *axis));
  const auto [a0, a1] = std::minmax(a, b, comes_before);
  const auto [p0, p1] = std::minmax(p, q, comes_before);
  return !comes_before(a1, p0) && !comes_before(p1, a0);
}

/// Closed segment, and closed triangle whose plane has the segment or whose corners lie on a line.
bool meets_in_plane(Vec3 p, Vec3 q, Vec3 a, Vec3 b, Vec3 c) {
  const std::optional<int> open = open_axis(a, b, c);
  if (!open) {
    const auto [first, last] = std::minmax({a, b, c}, comes_before);
    return segments_meet(first, last, p, q);
  }
  const int axis = *open;
  const std::array<Point2, 3> t = {without_axis(a, axis), without_axis(b, axis),
                                   without_axis(c, axis)};
  const Point2 from = without_axis(p, axis), to = without_axis(q, axis);
  return contains(t, from) || contains(t, to) || segments_meet(t[0], t[1], from, to) ||
         segments_meet(t[1], t[2], from, to) || segments_meet(t[2], t[0], from, to);
}

/// Closed segment and closed triangle in space.
bool segment_meets(Vec3 p, Vec3 q, Vec3 a, Vec3 b, Vec3 c) {
  const int side_p = side_of_plane(a, b, c, p), side_q = side_of_plane(a, b, c, q);
  if (side_p * side_q > 0) return false;
  if (side_p == 0 && side_q == 0) return meets_in_plane(p, q, a, b, c);
  const int ab = side_of_plane(p, q, a, b), bc = side_of_plane(p, q, b, c);
  if (ab * bc < 0) return false;
  const int ca = side_of_plane(p, q, c, a);
  return ab * ca >= 0 && bc * ca >= 0;
}

/// Two triangles of a mesh with their shared vertices in front, in the same order.
struct Pair {
  std::array<Vec3, 3> s, t;
  int shared = 0;
};

Pair pair_of(std::span<const Vec3> positions, const Triangle& s, const Triangle& t) {
  Pair pair;
  std::array<bool, 3> in_s{}, in_t{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (s[i] != t[k] || in_s[i] || in_t[k]) continue;
      in_s[i] = in_t[k] = true;
      pair.s[pair.shared] = pair.t[pair.shared] = positions[s[i]];
      ++pair.shared;
    }
  }
  std::size_t of_s = pair.shared, of_t = pair.shared;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!in_s[i]) pair.s[of_s++] = positions[s[i]];
    if (!in_t[i]) pair.t[of_t++] = positions[t[i]];
  }
  return pair;
}

/// True when a line through an edge of s and all shared vertices has the other vertices of t
/// strictly on the far side of s, seen along an axis. Quick; false proves nothing.
bool is_beside(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t, int shared, int axis) {
  for (int i = 0; i < 3; ++i) {
    const int from = i, to = (i + 1) % 3, apex = (i + 2) % 3;
    if (apex < shared) continue;  // the line has to pass through every shared vertex
    const Point2 a = without_axis(s[from], axis), b = without_axis(s[to], axis);
    const int near = quick_turn(a, b, without_axis(s[apex], axis));
    if (near == 2) continue;
    bool beside = true;
    for (int k = shared; k < 3 && beside; ++k) {
      beside = quick_turn(a, b, without_axis(t[k], axis)) == -near;
    }
    if (beside) return true;
  }
  return false;
}

double sum_of(Vec3 v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

/// A triangle's plane, with the exact answer where the quick one is not known.
class TrianglePlane {
 public:
  explicit TrianglePlane(const std::array<Vec3, 3>& t) : t_(t), quick_(t[0], t[1], t[2]) {}

  int quick_side(Vec3 p) const { return quick_.side(p); }
  int side(Vec3 p) const {
    const int quick = quick_.side(p);
    return quick != QuickPlane::kUnknown ? quick : exact_side_of_plane(t_[0], t_[1], t_[2], p);
  }

 private:
  const std::array<Vec3, 3>& t_;
  QuickPlane quick_;
};

/// True when the vertices of t that s does not have lie strictly on one side of s. Quick; false
/// proves nothing.
bool is_off_plane(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t, int shared) {
  const TrianglePlane plane(s);
  const int side = plane.quick_side(t[2]);
  if (side == QuickPlane::kUnknown) return false;
  for (int k = shared; k < 2; ++k)
    if (plane.quick_side(t[k]) != side) return false;
  return true;
}

using Sides = std::array<int, 3>;

Sides sides_of(const TrianglePlane& plane, const std::array<Vec3, 3>& t) {
  return {plane.side(t[0]), plane.side(t[1]), plane.side(t[2])};
}

bool is_one_side(const Sides& sides) {
  return sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2];
}

bool has_zero(const Sides& sides) { return sides[0] == 0 || sides[1] == 0 || sides[2] == 0; }

/// Turns a triangle until its first corner is alone on its side of the other one's plane. Returns
/// which side that is. Precondition: both sides occur, and no zero.
int turn_to_lonely(const Sides& sides, std::array<Vec3, 3>& t) {
  const int lonely = sides[0] == sides[1] ? 2 : sides[0] == sides[2] ? 1 : 0;
  std::rotate(t.begin(), t.begin() + lonely, t.end());
  return sides[static_cast<std::size_t>(lonely)];
}

/// Two triangles, each with corners on both sides of the other's plane and none in it: both meet
/// the planes' common line, and two tetrahedra tell whether the pieces of it overlap.
/// Guigue, Devillers, section 3.
bool overlap_on_line(std::array<Vec3, 3> s, std::array<Vec3, 3> t, const Sides& of_s,
                     const Sides& of_t) {
  const int above_t = turn_to_lonely(of_s, s), above_s = turn_to_lonely(of_t, t);
  // The pieces run in the same direction where both lonely corners lie on the positive sides.
  if (above_t < 0) std::swap(t[1], t[2]);
  if (above_s < 0) std::swap(s[1], s[2]);
  return side_of_plane(s[0], s[1], t[0], t[1]) <= 0 && side_of_plane(s[0], s[2], t[2], t[0]) <= 0;
}

bool have_common_vertex(const Triangle& s, const Triangle& t) {
  bool any = false;
  for (const std::uint32_t v : s) any |= v == t[0] || v == t[1] || v == t[2];
  return any;
}

/// Neighbours over the edge s[0], s[1]; `axis`: an open one of s.
bool folded_onto(const Pair& pair, int axis) {
  const auto& s = pair.s;
  if (side_of_plane(s[0], s[1], s[2], pair.t[2]) != 0) return false;
  return turn_along(axis, s[0], s[1], s[2]) == turn_along(axis, s[0], s[1], pair.t[2]);
}

/// Whether p and q lie on one ray from a point.
bool are_on_ray(Vec3 from, Vec3 p, Vec3 q) {
  if (p == from || q == from || open_axis(from, p, q)) return false;
  return comes_before(from, p) == comes_before(from, q);
}

/// Whether the way from t[0] to p begins in t; `axis`: an open one of t, empty: t is a segment.
bool leads_into(const std::array<Vec3, 3>& t, std::optional<int> axis, Vec3 p) {
  if (!axis) return are_on_ray(t[0], p, t[1]) || are_on_ray(t[0], p, t[2]);
  if (p == t[0] || side_of_plane(t[0], t[1], t[2], p) != 0) return false;
  const int turns = turn_along(*axis, t[0], t[1], t[2]);
  return turns * turn_along(*axis, t[0], t[1], p) >= 0 &&
         turns * turn_along(*axis, t[0], p, t[2]) >= 0;
}

/// Two neighbours, s of which is a segment: its corners lie on a line; `axis`: an open one of t,
/// empty: t is a segment, too.
bool segment_intersects_neighbor(const Pair& pair, std::optional<int> axis) {
  const auto& s = pair.s;
  const auto& t = pair.t;
  if (pair.shared == 1) return leads_into(t, axis, s[1]) || leads_into(t, axis, s[2]);
  // The line of the edge meets an open triangle in the edge alone.
  if (axis) return false;
  if (s[0] == s[1]) return are_on_ray(s[0], s[2], t[2]);
  const auto [first, last] = std::minmax(s[0], s[1], comes_before);
  return (comes_before(last, s[2]) && comes_before(last, t[2])) ||
         (comes_before(s[2], first) && comes_before(t[2], first));
}

}  // namespace

int side_of_plane(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  const int quick = quick_side_of_plane(a, b, c, d);
  return quick != 2 ? quick : exact_side_of_plane(a, b, c, d);
}

bool triangles_across_intersect(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t,
                                const std::array<int, 3>& sides_of_s,
                                const std::array<int, 3>& sides_of_t) {
  return overlap_on_line(s, t, sides_of_s, sides_of_t);
}

bool segment_meets_triangle(Vec3 p, Vec3 q, Vec3 a, Vec3 b, Vec3 c) {
  return segment_meets(p, q, a, b, c);
}

namespace {

/// Of two triangles without a common vertex; empty where a corner lies in the other's plane.
std::optional<bool> distinct_intersect(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t) {
  const TrianglePlane of_s(s);
  const Sides sides_t = sides_of(of_s, t);
  if (is_one_side(sides_t)) return false;
  const TrianglePlane of_t(t);
  const Sides sides_s = sides_of(of_t, s);
  if (is_one_side(sides_s)) return false;
  if (has_zero(sides_s) || has_zero(sides_t)) return std::nullopt;
  return overlap_on_line(s, t, sides_s, sides_t);
}

}  // namespace

QuickPlane::QuickPlane(Vec3 a, Vec3 b, Vec3 c) : from_(a) {
  // Far above what rounding can add up to: a dozen roundings of terms of this size.
  constexpr double kBound = 32.0 * kEpsilon;
  const Vec3 u = b - a, v = c - a;
  normal_ = cross(u, v);
  bound_ = kBound * sum_of(u) * sum_of(v);
}

bool triangles_intersect(std::span<const Vec3> positions, const Triangle& s, const Triangle& t) {
  if (!have_common_vertex(s, t)) {
    const auto found = distinct_intersect({positions[s[0]], positions[s[1]], positions[s[2]]},
                                          {positions[t[0]], positions[t[1]], positions[t[2]]});
    if (found) return *found;
  }
  const Pair pair = pair_of(positions, s, t);
  if (pair.shared == 3) return true;
  if (is_off_plane(pair.s, pair.t, pair.shared) || is_off_plane(pair.t, pair.s, pair.shared))
    return false;
  const int axis = widest_axis(pair.s[0], pair.s[1], pair.s[2]);
  if (is_beside(pair.s, pair.t, pair.shared, axis) ||
      is_beside(pair.t, pair.s, pair.shared, axis)) {
    return false;
  }
  if (pair.shared > 0) {
    const std::optional<int> open_s = open_axis(pair.s[0], pair.s[1], pair.s[2]);
    const std::optional<int> open_t = open_axis(pair.t[0], pair.t[1], pair.t[2]);
    if (!open_s) return segment_intersects_neighbor(pair, open_t);
    if (!open_t) return segment_intersects_neighbor({pair.t, pair.s, pair.shared}, open_s);
    if (pair.shared == 2) return folded_onto(pair, *open_s);
  }
  const auto& p = pair.s;
  const auto& q = pair.t;
  // With a shared vertex only the edges opposite it can meet the other triangle elsewhere.
  if (segment_meets(p[1], p[2], q[0], q[1], q[2])) return true;
  if (segment_meets(q[1], q[2], p[0], p[1], p[2])) return true;
  if (pair.shared == 1) return false;
  return segment_meets(p[0], p[1], q[0], q[1], q[2]) ||
         segment_meets(p[2], p[0], q[0], q[1], q[2]) ||
         segment_meets(q[0], q[1], p[0], p[1], p[2]) || segment_meets(q[2], q[0], p[0], p[1], p[2]);
}

}  // namespace orbweave
