#include "tests/engine/plane_polygons.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace orbweave::test {

Polygon star_polygon(std::uint32_t corners, std::int64_t extent, Random& random) {
  Polygon polygon;
  for (std::uint32_t i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5 * random.uniform()) / corners;
    const double radius = (0.1 + 0.9 * random.uniform()) * static_cast<double>(extent);
    polygon.push_back(
        {std::llround(radius * std::cos(angle)), std::llround(radius * std::sin(angle))});
  }
  return polygon;
}

Polygon spiral_polygon(std::uint32_t turns, std::uint32_t per_turn) {
  const double pitch = static_cast<double>(kPlaneExtent) / (turns + 2.0);
  const auto point = [&](double i, double offset) {
    const double angle = 2.0 * std::numbers::pi * i / per_turn;
    const double radius = pitch * (1.0 + i / per_turn + offset);
    return PlanePoint{std::llround(radius * std::cos(angle)),
                      std::llround(radius * std::sin(angle))};
  };
  Polygon polygon;
  const std::uint32_t steps = turns * per_turn;
  for (std::uint32_t i = 0; i <= steps; ++i) polygon.push_back(point(i, 0.6));
  for (std::uint32_t i = steps + 1; i-- > 0;) polygon.push_back(point(i, 0.0));
  return polygon;
}

Polygon comb_polygon(std::uint32_t teeth) {
  constexpr std::int64_t kHeight = 1 << 20;
  Polygon polygon = {{0, -1000}, {4000 * std::int64_t{teeth}, -1000}};
  for (std::int64_t tooth = teeth; tooth-- > 0;) {
    polygon.push_back({4000 * tooth + 2000, 0});
    polygon.push_back({4000 * tooth + 1000, kHeight});
    polygon.push_back({4000 * tooth, 0});
  }
  return polygon;
}

Polygon lattice_square(std::int64_t side, std::int64_t step) {
  Polygon polygon;
  const std::int64_t end = side * step;
  for (std::int64_t i = 0; i < side; ++i) polygon.push_back({i * step, 0});
  for (std::int64_t i = 0; i < side; ++i) polygon.push_back({end, i * step});
  for (std::int64_t i = side; i > 0; --i) polygon.push_back({i * step, end});
  for (std::int64_t i = side; i > 0; --i) polygon.push_back({0, i * step});
  return polygon;
}

std::vector<NamedPolygon> touching_polygons() {
  return {
      {"a square with a slit", {{0, 0}, {8, 0}, {8, 8}, {4, 4}, {8, 8}, {0, 8}}},
      {"a slit with a bend", {{0, 0}, {8, 0}, {8, 8}, {4, 5}, {3, 3}, {4, 5}, {8, 8}, {0, 8}}},
      {"two slits from one corner",
       {{0, 0}, {8, 0}, {8, 8}, {6, 3}, {8, 8}, {3, 6}, {8, 8}, {0, 8}}},
      {"a slit that forks",
       {{0, 0}, {9, 0}, {9, 9}, {6, 6}, {5, 2}, {6, 6}, {2, 5}, {6, 6}, {9, 9}, {0, 9}}},
      {"a bridge to an island",
       {{0, 0}, {9, 0}, {9, 9}, {6, 6}, {6, 3}, {3, 3}, {3, 6}, {6, 6}, {9, 9}, {0, 9}}},
      {"two islands in a row",
       {{0, 0},
        {20, 0},
        {20, 9},
        {18, 6},
        {18, 3},
        {15, 4},
        {12, 5},
        {12, 3},
        {10, 4},
        {12, 5},
        {15, 4},
        {18, 6},
        {20, 9},
        {0, 9}}},
      {"an island at a corner", {{0, 0}, {9, 0}, {9, 9}, {7, 6}, {3, 3}, {6, 7}, {9, 9}, {0, 9}}},
      {"a horseshoe whose ends touch",
       {{5, 10}, {0, 10}, {0, 0}, {10, 0}, {10, 10}, {5, 10}, {8, 8}, {8, 2}, {2, 2}, {2, 8}}},
      {"a ring closed at a point",
       {{0, 0}, {4, -3}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {3, 6}, {6, 6}, {6, 3}}},
      {"two islands at one corner",
       {{0, 0},
        {20, 0},
        {20, 20},
        {19, 6},
        {15, 5},
        {16, 9},
        {20, 20},
        {9, 16},
        {6, 14},
        {8, 18},
        {20, 20},
        {0, 20}}},
  };
}

std::vector<NamedPolygon> unsound_polygons() {
  return {
      {"two corners", {{0, 0}, {5, 5}}},
      {"a line there and back", {{0, 0}, {5, 5}, {9, 9}, {5, 5}}},
      {"clockwise", {{0, 0}, {0, 8}, {8, 8}, {8, 0}}},
      {"a bow tie", {{0, 0}, {8, 8}, {8, 0}, {0, 8}}},
      {"a figure-eight pinched to nothing", {{0, 0}, {4, 4}, {8, 0}, {8, 8}, {4, 4}, {0, 8}}},
      {"a figure-eight that crosses itself at a corner",
       {{0, 0}, {4, 4}, {8, 8}, {8, 0}, {4, 4}, {0, 8}}},
      {"a corner on an edge, from inside", {{0, 0}, {8, 0}, {8, 8}, {4, 0}, {0, 8}}},
      {"a corner on an edge, from outside",
       {{0, 0}, {8, 0}, {8, 4}, {12, 2}, {12, 8}, {8, 2}, {10, 9}, {0, 8}}},
      {"overlapping collinear edges", {{0, 0}, {8, 0}, {4, 0}, {8, 8}}},
      {"successive corners at one point", {{0, 0}, {8, 0}, {8, 0}, {8, 8}}},
      {"twice around", {{0, 0}, {8, 0}, {8, 8}, {0, 0}, {8, 0}, {8, 8}}},
      {"a hair outside", {{0, 0}, {8, 0}, {12, 3}, {8, 0}, {8, 8}, {0, 8}}},
      {"a loop inside, the same way around",
       {{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {6, 3}, {6, 6}, {3, 6}}},
      {"an island crossed by another edge",
       {{0, 0}, {9, 0}, {9, 9}, {6, 6}, {6, 3}, {3, 3}, {3, 12}, {6, 6}, {9, 9}, {0, 9}}},
  };
}

std::int64_t doubled_area(const Polygon& polygon) {
  std::uint64_t sum = 0;  // partial sums may pass 2^63, the total does not
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    sum += static_cast<std::uint64_t>(orientation(polygon[0], polygon[i], polygon[i + 1]));
  }
  return static_cast<std::int64_t>(sum);
}

bool is_strictly_inside(const Polygon& polygon, PlanePoint p) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PlanePoint a = polygon[i];
    const PlanePoint b = polygon[(i + 1) % polygon.size()];
    const std::int64_t side = orientation(a, b, p);
    const bool between = std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
                         std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
    if (side == 0 && between) return false;
    if (a.y <= p.y && b.y > p.y && side > 0) inside = !inside;
    if (b.y <= p.y && a.y > p.y && side < 0) inside = !inside;
  }
  return inside;
}

namespace {

int sign(std::int64_t value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

bool is_on_edge(PlanePoint a, PlanePoint b, PlanePoint p) {
  if (orientation(a, b, p) != 0 || p == a || p == b) return false;
  return (p.x - a.x) * (p.x - b.x) + (p.y - a.y) * (p.y - b.y) < 0;
}

bool edges_are_sound(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const PlanePoint a = polygon[i];
    const PlanePoint b = polygon[(i + 1) % n];
    if (a == b) return false;
    for (std::size_t j = 0; j < n; ++j) {
      const PlanePoint c = polygon[j];
      const PlanePoint d = polygon[(j + 1) % n];
      if (is_on_edge(a, b, c) || (i != j && a == c && b == d)) return false;
      if (sign(orientation(a, b, c)) * sign(orientation(a, b, d)) < 0 &&
          sign(orientation(c, d, a)) * sign(orientation(c, d, b)) < 0) {
        return false;
      }
    }
  }
  return true;
}

/// The turn to the left from the direction a-b to the direction a-c, in (0, 2 pi].
double turn(PlanePoint a, PlanePoint b, PlanePoint c) {
  const double angle = std::atan2(static_cast<double>(c.y - a.y), static_cast<double>(c.x - a.x)) -
                       std::atan2(static_cast<double>(b.y - a.y), static_cast<double>(b.x - a.x));
  constexpr double kRounding = 1e-9;
  return angle > kRounding ? angle : angle + 2.0 * std::numbers::pi;
}

/// The inside turns around once, and corners at one point do not share it.
bool corners_are_sound(const Polygon& polygon) {
  constexpr double kRounding = 1e-6;
  const std::size_t n = polygon.size();
  const auto at = [&](std::size_t i) { return polygon[i % n]; };
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double inside = turn(at(i), at(i + 1), at(i + n - 1));
    sum += inside;
    for (std::size_t j = 0; j < n; ++j) {
      if (j == i || at(j) != at(i)) continue;
      const double other = turn(at(i), at(i + 1), at(j + 1));
      if (other < inside - kRounding) return false;
    }
  }
  return std::abs(sum - static_cast<double>(n - 2) * std::numbers::pi) < kRounding;
}

}  // namespace

bool is_weakly_simple_by_trial(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  if (n < 3 || !edges_are_sound(polygon) || !corners_are_sound(polygon)) return false;
  std::vector<char> possible(n * n, 0);
  for (std::size_t i = 0; i + 1 < n; ++i) possible[i * n + i + 1] = 1;
  for (std::size_t span = 2; span < n; ++span) {
    for (std::size_t i = 0; i + span < n; ++i) {
      const std::size_t j = i + span;
      for (std::size_t k = i + 1; k < j; ++k) {
        if (possible[i * n + k] != 0 && possible[k * n + j] != 0 &&
            orientation(polygon[i], polygon[k], polygon[j]) > 0) {
          possible[i * n + j] = 1;
        }
      }
    }
  }
  return possible[n - 1] != 0;
}

}  // namespace orbweave::test
