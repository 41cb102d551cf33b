// What the Delaunay and the regular triangulation of CGAL have in common: points inserted along a
// curve that fills space, and the tetrahedra read out as plain arrays.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "engine/voronoi/tetrahedra.h"
#include "io/error.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

constexpr std::size_t kInsertionsPerLook = 1024;

/// The order in which points are inserted: neighbours follow each other.
inline std::vector<std::size_t> insertion_order(const std::vector<Point>& points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (points.empty()) return order;  // CGAL takes the address of the first
  CGAL::spatial_sort(
      order.begin(), order.end(),
      CGAL::Spatial_sort_traits_adapter_3<Kernel, CGAL::Pointer_property_map<Point>::const_type>(
          CGAL::make_property_map(points)));
  return order;
}

inline std::vector<Point> cgal_points(std::span<const Vec3> points) {
  std::vector<Point> all;
  all.reserve(points.size());
  for (const Vec3 p : points) all.emplace_back(p.x, p.y, p.z);
  return all;
}

/// A point with a weight, as a number type holds it.
template <class Number>
struct WeightedOffset {
  std::array<Number, 3> from_first;  ///< difference to the tetrahedron's first vertex
  Number weight;                     ///< less that of the first vertex
};

/// From the first vertex of a tetrahedron to the centre of its orthogonal ball, as numerators over
/// one denominator, with what the terms of each sum amount to in absolute value.
template <class Number>
struct CenterTerms {
  std::array<Number, 3> numerator{};
  Number denominator{};
  std::array<Number, 3> numerator_terms{};
  Number denominator_terms{};
};

template <class Number>
Number magnitude(const Number& value) {
  return value < 0 ? Number(-value) : value;
}

/// Solves 2 x . d_i = |d_i|^2 - w_i for the three offsets by Cramer's rule.
template <class Number>
CenterTerms<Number> center_terms(const std::array<WeightedOffset<Number>, 3>& offsets,
                                 bool with_terms) {
  CenterTerms<Number> sums;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& d = offsets[i].from_first;
    const auto& e = offsets[(i + 1) % 3].from_first;
    const auto& f = offsets[(i + 2) % 3].from_first;
    const Number square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - offsets[i].weight;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t y = (axis + 1) % 3, z = (axis + 2) % 3;
      const Number left = e[y] * f[z], right = e[z] * f[y];
      sums.numerator[axis] += square * (left - right);
      if (i == 0) sums.denominator += d[axis] * (left - right);
      if (!with_terms) continue;
      const Number both = magnitude(left) + magnitude(right);
      sums.numerator_terms[axis] += magnitude(square) * both;
      if (i == 0) sums.denominator_terms += magnitude(d[axis]) * both;
    }
  }
  return sums;
}

struct WeightedVec {
  Vec3 position;
  double weight = 0.0;
};

template <class Number>
std::array<WeightedOffset<Number>, 3> offsets_of(const std::array<WeightedVec, 4>& corners) {
  std::array<WeightedOffset<Number>, 3> offsets;
  for (std::size_t i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      offsets[i].from_first[static_cast<std::size_t>(axis)] =
          Number(corners[i + 1].position[axis]) - Number(corners[0].position[axis]);
    offsets[i].weight = Number(corners[i + 1].weight) - Number(corners[0].weight);
  }
  return offsets;
}

inline Vec3 exact_center_offset(const std::array<WeightedVec, 4>& corners) {
  using Exact = CGAL::Exact_rational;
  const CenterTerms<Exact> sums = center_terms(offsets_of<Exact>(corners), false);
  Vec3 offset;
  for (int axis = 0; axis < 3; ++axis)
    offset[axis] = CGAL::to_double(
        Exact(sums.numerator[static_cast<std::size_t>(axis)] / (2 * sums.denominator)));
  return offset;
}

inline double sum_of(const std::array<double, 3>& values) {
  return magnitude(values[0]) + magnitude(values[1]) + magnitude(values[2]);
}

/// From the first corner to the centre. Rounding takes at most some nine of the sixteen digits:
/// where cancellation would take more, the centre is computed exactly.
inline Vec3 center_offset(const std::array<WeightedVec, 4>& corners) {
  constexpr double kCancelled = 1e-6;
  const CenterTerms<double> sums = center_terms(offsets_of<double>(corners), true);
  const double length = sum_of(sums.numerator), terms = sum_of(sums.numerator_terms);
  const bool is_certain = magnitude(sums.denominator) > kCancelled * sums.denominator_terms &&
                          length > kCancelled * terms && std::isfinite(terms) &&
                          std::isnormal(sums.denominator);
  if (!is_certain) return exact_center_offset(corners);
  const double scale = 0.5 / sums.denominator;
  return {scale * sums.numerator[0], scale * sums.numerator[1], scale * sums.numerator[2]};
}

/// The outward unit normal of the hull's facet that a tetrahedron at infinity stands on.
inline Vec3 hull_normal(std::span<const Vec3> points, const std::array<std::uint32_t, 4>& cell) {
  const auto at =
      static_cast<std::size_t>(std::find(cell.begin(), cell.end(), kInfinite) - cell.begin());
  const auto corner = [&](std::size_t k) {
    return points[cell[static_cast<std::size_t>(kFacet[at][k])]];
  };
  // Seen from outside the tetrahedron, which is inside the hull, the corners are counter-clockwise.
  return normalized(cross(corner(2) - corner(0), corner(1) - corner(0)));
}

inline void sort_four(std::array<std::uint32_t, 4>& v) {
  const auto order = [&](std::size_t i, std::size_t j) {
    const std::uint32_t low = std::min(v[i], v[j]), high = std::max(v[i], v[j]);
    v[i] = low;
    v[j] = high;
  };
  order(0, 1), order(2, 3), order(0, 2), order(1, 3), order(1, 2);
}

inline void add_center(std::span<const Vec3> points, std::span<const double> weights,
                       std::uint32_t cell, Tetrahedra& to) {
  std::array<std::uint32_t, 4> vertices = to.vertices[cell];
  sort_four(vertices);
  if (vertices[3] == kInfinite) {
    to.centers[cell] = hull_normal(points, to.vertices[cell]);
    return;
  }
  std::array<WeightedVec, 4> corners;
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] = {points[vertices[i]], weights.empty() ? 0.0 : weights[vertices[i]]};
  const Vec3 offset = center_offset(corners);
  to.centers[cell] = corners[0].position + offset;
  if (weights.empty()) to.radii[cell] = norm(offset);
}

/// Reads the tetrahedra out of a triangulation whose vertices know their indices.
template <class Triangulation>
Tetrahedra read_out(Triangulation& triangulation, const StopToken* stop) {
  triangulation.infinite_vertex()->info() = kInfinite;
  Tetrahedra result;
  const std::size_t count = triangulation.tds().number_of_cells();
  result.vertices.resize(count);
  result.neighbors.resize(count);
  result.finite.resize(count);
  std::uint32_t c = 0;
  auto& cells = triangulation.tds().cells();
  for (auto cell = cells.begin(); cell != cells.end(); ++cell, ++c) {
    cell->info() = c;
    bool is_finite = true;
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t vertex = cell->vertex(i)->info();
      result.vertices[c][static_cast<std::size_t>(i)] = vertex;
      is_finite = is_finite && vertex != kInfinite;
    }
    result.finite[c] = is_finite ? 1 : 0;
  }
  check_stop(stop);
  c = 0;
  for (auto cell = cells.begin(); cell != cells.end(); ++cell, ++c)
    for (int i = 0; i < 4; ++i)
      result.neighbors[c][static_cast<std::size_t>(i)] = cell->neighbor(i)->info();
  return result;
}

inline void add_centers(std::span<const Vec3> points, std::span<const double> weights,
                        const StopToken* stop, Tetrahedra& to) {
  to.centers.resize(to.size());
  if (weights.empty()) to.radii.resize(to.size(), 0.0);
  for (std::uint32_t c = 0; c < to.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    add_center(points, weights, c, to);
  }
}

/// Throws where the dimension of the points (-1: there is none) is below 3.
inline void require_dimension(int dimension, std::size_t points) {
  if (dimension == 3) return;
  static constexpr std::array<const char*, 4> kPlace = {"", " in one place", " on one line",
                                                        " in one plane"};
  throw_bad_input("no tetrahedron can be formed of the points",
                  {.found = std::to_string(points) + (points == 1 ? " point" : " points") +
                            kPlace.at(static_cast<std::size_t>(dimension) + 1),
                   .expected = "at least four points that do not lie in one plane",
                   .advice = "Ball pivoting takes points of one plane"});
}

}  // namespace orbweave::voronoi
