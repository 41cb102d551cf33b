#include "engine/synthetic/rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "engine/synthetic/plate.h"
#include "engine/synthetic/surfaces.h"

namespace orbweave::synthetic {
namespace {

using portable::kGoldenStep;
using portable::kPi;
using portable::sine_cosine;

constexpr double kEdgeMargin = 0.85;  // of a cube's face from its edges, in local spacings

/// Smallest x in [low, high] (to rounding) with value(x) >= target, for increasing `value`.
double bisect(double low, double high, double target, const std::function<double(double)>& value) {
  for (int step = 0; step < 64; ++step) {
    const double middle = 0.5 * (low + high);
    (value(middle) < target ? low : high) = middle;
  }
  return high;
}

/// A rectangle-like piece of a plane: v from v_begin to v_end (rows on both ends), u from
/// margin/q(v) to 1 - margin/q(v), q the root of the density there times `scale`.
struct Patch {
  DensityProfile profile;
  double scale = 1.0;
  double v_begin = 0.0, v_end = 1.0;
  double margin = 0.0;
  int sheet = 0;

  double root_density(double v) const { return scale * profile.root_density(v); }
  double row_margin(double v) const { return margin / root_density(v); }
  /// Rows less one at spacing `c` where the density is one.
  double row_steps(double c) const {
    return scale * (profile.integral(v_end) - profile.integral(v_begin)) / (kRowDistance * c);
  }
  double row_points(double v, double c) const {
    return 1.0 + std::max(0.0, 1.0 - 2.0 * row_margin(v)) * root_density(v) / (kPointDistance * c);
  }
  double row_v(double fraction) const {
    if (fraction <= 0.0) return v_begin;
    if (fraction >= 1.0) return v_end;
    const double first = profile.integral(v_begin);
    return profile.inverse_integral(first + fraction * (profile.integral(v_end) - first));
  }
  double expected_points(double c) const {
    constexpr int kSamples = 64;
    double sum = 0.0;
    for (int i = 0; i < kSamples; ++i) sum += row_points(row_v((i + 0.5) / kSamples), c);
    return (1.0 + row_steps(c)) * sum / kSamples;
  }
};

void append_patch(std::vector<Row>& rows, const Patch& patch, std::uint64_t points) {
  if (points == 0) return;
  const double density = bisect(1e-3, 1e12, static_cast<double>(points), [&](double per_unit) {
    return patch.expected_points(1.0 / std::sqrt(per_unit));
  });
  const double c = 1.0 / std::sqrt(density);
  const auto count = static_cast<std::uint64_t>(std::floor(patch.row_steps(c) + 1.5));
  std::vector<Row> sheet(count);
  std::vector<double> weights(count);
  for (std::uint64_t j = 0; j < count; ++j) {
    const double fraction =
        count > 1 ? static_cast<double>(j) / static_cast<double>(count - 1) : 0.5;
    Row& row = sheet[j];
    row.sheet = patch.sheet;
    row.v = patch.row_v(fraction);
    row.begin = patch.row_margin(row.v);
    row.end = 1.0 - row.begin;
    row.stagger = j % 2 == 0 ? -0.25 : 0.25;
    weights[j] = patch.row_points(row.v, c);
  }
  append_counted(rows, std::move(sheet), weights, points);
}

void append_torus(std::vector<Row>& rows, const SyntheticOptions& options) {
  // Root of the density: 2.5 + 1.5 cos(v), 4 on the outer equator and 1 on the inner one.
  const double mean = options.density_varying ? 2.5 : 1.0;
  const double swing = options.density_varying ? 1.5 : 0.0;
  // Points per c^-2: the integral of density over the area, in closed form.
  const double tube = kTubeRadius;
  const double weighted_area =
      4.0 * kPi * kPi * tube *
      (kMajorRadius * (mean * mean + 0.5 * swing * swing) + tube * mean * swing);
  const double c = std::sqrt(weighted_area / static_cast<double>(options.points));
  const double row_steps = 2.0 * kPi * tube * mean / (kRowDistance * c);
  const auto count = static_cast<std::uint64_t>(std::max(3.0, std::floor(row_steps + 0.5)));
  std::vector<Row> sheet(count);
  std::vector<double> weights(count);
  for (std::uint64_t j = 0; j < count; ++j) {
    const double fraction = (static_cast<double>(j) + 0.5) / static_cast<double>(count);
    // Integral of the root of the density, as a fraction of the whole: rows are even in it.
    const auto integral = [&](double v) {
      return v + swing / mean * sine_cosine(v).sine / (2.0 * kPi);
    };
    Row& row = sheet[j];
    row.closed = true;
    row.v = options.density_varying ? bisect(0.0, 1.0, fraction, integral) : fraction;
    row.begin = portable::fraction(j * kGoldenStep);
    const double cosine = sine_cosine(row.v).cosine;
    weights[j] = (kMajorRadius + tube * cosine) * (mean + swing * cosine);
  }
  append_counted(rows, std::move(sheet), weights, options.points);
}

/// Points strictly inside each edge of the cube: at the bottom, at the top, upright.
struct CubeEdges {
  std::uint64_t bottom = 0, top = 0, upright = 0;
  std::uint64_t points() const { return 4 * (bottom + top + upright); }
};

CubeEdges cube_edges(const DensityProfile& profile, double c, std::uint64_t points) {
  const auto inside = [&](double root_density) {
    return static_cast<std::uint64_t>(std::max(0.0, std::floor(root_density / c - 0.5)));
  };
  CubeEdges edges{inside(profile.root_density(0.0)), inside(profile.root_density(1.0)),
                  inside(profile.integral(1.0))};
  while (edges.points() > 0 && edges.points() + 8 > points) {
    edges.bottom /= 2;
    edges.top /= 2;
    edges.upright /= 2;
  }
  return edges;
}

void append_cube_edges(std::vector<Row>& rows, const CubeEdges& edges, std::uint64_t points) {
  const auto append = [&](int sheet, std::uint64_t inside, bool with_ends) {
    Row row;
    row.sheet = sheet;
    row.count = inside + (with_ends ? 2 : 0);
    const double steps = static_cast<double>(inside + 1);
    row.begin = with_ends ? 0.0 : 1.0 / steps;
    row.end = with_ends ? 1.0 : static_cast<double>(inside) / steps;
    // Fewer points than corners: what there is goes to the first edges.
    row.count = std::min(row.count, points);
    points -= row.count;
    if (row.count > 0) rows.push_back(row);
  };
  // Bit 1 of an edge's position is z for the horizontal ones.
  for (int e = 0; e < 4; ++e) append(6 + e, e < 2 ? edges.bottom : edges.top, true);
  for (int e = 0; e < 4; ++e) append(10 + e, e < 2 ? edges.bottom : edges.top, false);
  for (int e = 0; e < 4; ++e) append(14 + e, edges.upright, false);
}

void append_cube(std::vector<Row>& rows, const SyntheticOptions& options) {
  const DensityProfile profile{options.density_varying};
  const double top = profile.root_density(1.0);
  const double upright = options.density_varying ? 7.0 : 1.0;  // integral of (1 + 3 t)^2
  const double weighted_area = 1.0 + top * top + 4.0 * upright;
  const double c = std::sqrt(weighted_area / static_cast<double>(options.points));
  const CubeEdges edges = cube_edges(profile, c, options.points);
  append_cube_edges(rows, edges, options.points);

  std::array<Patch, 6> faces;
  std::array<double, 6> expected{};
  double total = 0.0;
  for (int f = 0; f < 6; ++f) {
    Patch& face = faces[f];
    face.sheet = f;
    if (f < 4)
      face.profile = profile;
    else
      face.scale = f == 4 ? 1.0 : top;
    face.margin = std::min(0.4, kEdgeMargin * c);
    face.v_begin = face.margin / face.root_density(0.0);
    face.v_end = 1.0 - face.margin / face.root_density(1.0);
    total += expected[f] = face.expected_points(c);
  }
  const std::uint64_t on_edges = std::min(options.points, edges.points() + 8);
  const std::uint64_t inside = options.points - on_edges;
  std::uint64_t spent = 0;
  double sum = 0.0;
  for (int f = 0; f < 6; ++f) {
    sum += expected[f];
    const auto upto = f == 5 ? inside
                             : static_cast<std::uint64_t>(
                                   std::floor(static_cast<double>(inside) * (sum / total) + 0.5));
    append_patch(rows, faces[f], upto - spent);
    spent = upto;
  }
}

}  // namespace

double DensityProfile::root_density(double t) const { return varying ? 1.0 + 3.0 * t : 1.0; }
double DensityProfile::integral(double t) const { return varying ? t + 1.5 * t * t : t; }
double DensityProfile::inverse_integral(double value) const {
  return varying ? (std::sqrt(1.0 + 6.0 * value) - 1.0) / 3.0 : value;
}

std::uint64_t sphere_points(const SyntheticOptions& options) {
  if (options.shape == Shape::kSphere) return options.points;
  if (options.shape != Shape::kTwoComponents) return 0;
  // In proportion to the areas.
  const double sphere = kUpperRadius * kUpperRadius;
  const double torus = kPi * kMajorRadius * kTubeRadius;
  return static_cast<std::uint64_t>(
      std::floor(static_cast<double>(options.points) * (sphere / (sphere + torus)) + 0.5));
}

std::vector<Row> rows_of(const SyntheticOptions& options) {
  std::vector<Row> rows;
  Patch square;
  square.profile.varying = options.density_varying;
  switch (options.shape) {
    case Shape::kSphere:
      break;
    case Shape::kTorus:
    case Shape::kBumpyTorus:
      append_torus(rows, options);
      break;
    case Shape::kPlane:
      append_patch(rows, square, options.points);
      break;
    case Shape::kDoubleWall:
      append_patch(rows, square, options.points - options.points / 2);
      square.sheet = 1;
      append_patch(rows, square, options.points / 2);
      break;
    case Shape::kCube:
      append_cube(rows, options);
      break;
    case Shape::kTwoComponents: {
      SyntheticOptions torus = options;
      torus.points -= sphere_points(options);
      append_torus(rows, torus);
      break;
    }
    case Shape::kGenusThree:
      rows = plate_rows(options.points, options.density_varying);
      break;
  }
  std::uint64_t first = sphere_points(options);
  for (Row& row : rows) {
    row.first = first;
    first += row.count;
  }
  return rows;
}

}  // namespace orbweave::synthetic
