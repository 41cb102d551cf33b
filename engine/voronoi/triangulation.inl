// What the Delaunay and the regular triangulation have in common: the order in which points are
// inserted, along a curve that fills space, and the centres. Triangulations of CGAL are read out.

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

#include "engine/voronoi/share_done.h"
#include "engine/voronoi/tetrahedra.h"
#include "engine/voronoi/weighted_vec.h"
#include "io/error.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

/// Looks up from the insertions now and then: at `stop`, and to say how many are done.
inline void look_up(std::size_t inserted, std::size_t all, const StopToken* stop,
                    const ShareDone& done) {
  constexpr std::size_t kInsertionsPerLook = 1024;
  if (inserted % kInsertionsPerLook != 0) return;
  check_stop(stop);
  if (done) done(static_cast<double>(inserted) / static_cast<double>(all));
}

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

inline Point cgal_point(Vec3 p) { return {p.x, p.y, p.z}; }

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

/// Numbers of several tetrahedra, which the machine computes with side by side.
struct Lanes {
  static constexpr std::size_t kCount = 4;
  std::array<double, kCount> value{};

  template <class Operation>
  static Lanes each(const Operation& operation) {
    Lanes result;
    for (std::size_t lane = 0; lane < kCount; ++lane) result.value[lane] = operation(lane);
    return result;
  }
  friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t lane) { return a.value[lane] + b.value[lane]; });
  }
  friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t lane) { return a.value[lane] - b.value[lane]; });
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t lane) { return a.value[lane] * b.value[lane]; });
  }
  Lanes& operator+=(const Lanes& other) { return *this = *this + other; }
};

inline Lanes magnitude(const Lanes& a) {
  return Lanes::each([&](std::size_t lane) { return std::abs(a.value[lane]); });
}

/// Solves 2 x . d_i = |d_i|^2 - w_i for the three offsets by Cramer's rule.
template <bool with_terms, class Number>
CenterTerms<Number> center_terms(const std::array<WeightedOffset<Number>, 3>& offsets) {
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
      if constexpr (!with_terms) continue;
      const Number both = magnitude(left) + magnitude(right);
      sums.numerator_terms[axis] += magnitude(square) * both;
      if (i == 0) sums.denominator_terms += magnitude(d[axis]) * both;
    }
  }
  return sums;
}

using Corners = std::array<WeightedVec, 4>;

template <class Number>
std::array<WeightedOffset<Number>, 3> offsets_of(const Corners& corners) {
  std::array<WeightedOffset<Number>, 3> offsets;
  for (std::size_t i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      offsets[i].from_first[static_cast<std::size_t>(axis)] =
          Number(corners[i + 1].position[axis]) - Number(corners[0].position[axis]);
    offsets[i].weight = Number(corners[i + 1].weight) - Number(corners[0].weight);
  }
  return offsets;
}

inline void set_lane(const Corners& corners, std::size_t lane,
                     std::array<WeightedOffset<Lanes>, 3>& offsets) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 offset = corners[i + 1].position - corners[0].position;
    offsets[i].from_first[0].value[lane] = offset.x;
    offsets[i].from_first[1].value[lane] = offset.y;
    offsets[i].from_first[2].value[lane] = offset.z;
    offsets[i].weight.value[lane] = corners[i + 1].weight - corners[0].weight;
  }
}

inline Vec3 exact_center_offset(const Corners& corners) {
  using Exact = CGAL::Exact_rational;
  const CenterTerms<Exact> sums = center_terms<false>(offsets_of<Exact>(corners));
  Vec3 offset;
  for (int axis = 0; axis < 3; ++axis)
    offset[axis] = CGAL::to_double(
        Exact(sums.numerator[static_cast<std::size_t>(axis)] / (2 * sums.denominator)));
  return offset;
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

/// The corners of a finite tetrahedron in ascending order.
inline Corners corners_of(std::span<const Vec3> points, std::span<const double> weights,
                          std::array<std::uint32_t, 4> vertices) {
  sort_four(vertices);
  Corners corners;
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] = {points[vertices[i]], weights.empty() ? 0.0 : weights[vertices[i]]};
  return corners;
}

/// Centres of finite tetrahedra, some at a time. Rounding takes at most some nine of the sixteen
/// digits: where cancellation would take more, the centre is computed exactly.
class CenterBatch {
 public:
  CenterBatch(std::span<const Vec3> points, std::span<const double> weights, Tetrahedra& to)
      : points_(points), weights_(weights), to_(to) {}

  void add(std::uint32_t cell) {
    cells_[count_] = cell;
    corners_[count_] = corners_of(points_, weights_, to_.vertices[cell]);
    set_lane(corners_[count_], count_, offsets_);
    if (++count_ == Lanes::kCount) finish();
  }

  void finish() {
    const CenterTerms<Lanes> sums = center_terms<true>(offsets_);
    const Lanes length = sum_of(sums.numerator), terms = sum_of(sums.numerator_terms);
    for (std::size_t lane = 0; lane < count_; ++lane) {
      const double denominator = sums.denominator.value[lane];
      const bool is_certain =
          std::abs(denominator) > kCancelled * sums.denominator_terms.value[lane] &&
          length.value[lane] > kCancelled * terms.value[lane] && std::isfinite(terms.value[lane]) &&
          std::isnormal(denominator);
      const double scale = 0.5 / denominator;
      store(lane, is_certain ? Vec3{scale * sums.numerator[0].value[lane],
                                    scale * sums.numerator[1].value[lane],
                                    scale * sums.numerator[2].value[lane]}
                             : exact_center_offset(corners_[lane]));
    }
    count_ = 0;
  }

 private:
  static constexpr double kCancelled = 1e-6;

  static Lanes sum_of(const std::array<Lanes, 3>& values) {
    return magnitude(values[0]) + magnitude(values[1]) + magnitude(values[2]);
  }

  void store(std::size_t lane, Vec3 offset) {
    to_.centers[cells_[lane]] = corners_[lane][0].position + offset;
    if (weights_.empty()) to_.radii[cells_[lane]] = norm(offset);
  }

  std::span<const Vec3> points_;
  std::span<const double> weights_;
  Tetrahedra& to_;
  std::array<std::uint32_t, Lanes::kCount> cells_{};
  std::array<Corners, Lanes::kCount> corners_;
  std::array<WeightedOffset<Lanes>, 3> offsets_;
  std::size_t count_ = 0;
};

/// Reads the tetrahedra out of a triangulation whose vertices know their indices, below `points`.
template <class Triangulation>
Tetrahedra read_out(Triangulation& triangulation, std::size_t points, const StopToken* stop) {
  triangulation.infinite_vertex()->info() = kInfinite;
  auto& cells = triangulation.tds().cells();
  std::vector<std::uint32_t> number;
  number.reserve(triangulation.tds().number_of_cells());
  for (auto cell = cells.begin(); cell != cells.end(); ++cell) {
    cell->info() = static_cast<std::uint32_t>(number.size());
    number.push_back(std::min(std::min(cell->vertex(0)->info(), cell->vertex(1)->info()),
                              std::min(cell->vertex(2)->info(), cell->vertex(3)->info())));
  }
  check_stop(stop);
  number_by(number, points);
  Tetrahedra result;
  result.vertices.resize(number.size());
  result.neighbors.resize(number.size());
  result.finite.resize(number.size());
  std::size_t stored = 0;
  for (auto cell = cells.begin(); cell != cells.end(); ++cell) {
    const std::uint32_t c = number[stored++];
    bool is_finite = true;
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t vertex = cell->vertex(i)->info();
      result.vertices[c][static_cast<std::size_t>(i)] = vertex;
      result.neighbors[c][static_cast<std::size_t>(i)] = number[cell->neighbor(i)->info()];
      is_finite = is_finite && vertex != kInfinite;
    }
    result.finite[c] = is_finite ? 1 : 0;
  }
  return result;
}

inline void add_centers(std::span<const Vec3> points, std::span<const double> weights,
                        const StopToken* stop, Tetrahedra& to) {
  to.centers.resize(to.size());
  if (weights.empty()) to.radii.resize(to.size(), 0.0);
  CenterBatch batch(points, weights, to);
  for (std::uint32_t c = 0; c < to.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    if (to.is_finite(c))
      batch.add(c);
    else
      to.centers[c] = hull_normal(points, to.vertices[c]);
  }
  batch.finish();
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
