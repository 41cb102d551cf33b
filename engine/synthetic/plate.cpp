#include "engine/synthetic/plate.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace orbweave::synthetic {
namespace {

using portable::kPi;
using portable::sine_cosine;
using portable::SineCosine;

constexpr double kSideMargin = 0.22;  ///< of a flat side's points from its border, in spacings

/// Of a sheet: the circle that the centre line of its rim is.
struct RimCircle {
  Vec3 center;
  double radius = 0.0;
  double side = 1.0;  ///< 1: the surface is outside of the circle, -1: inside
};

RimCircle rim_circle(int sheet) {
  if (sheet == kPlateRim) return {{}, kPlateRadius, 1.0};
  return {plate_hole_center(sheet - kPlateFirstHole), kPlateHoleRadius, -1.0};
}

/// The root of the density on a rim, where the rim's own radius has the angle v (turns): even in v,
/// with its integral over the angle in radians from the upper border on.
struct RimDensity {
  double mean = 1.0, swing = 0.0;

  double root(double v) const { return mean + swing * sine_cosine(v).cosine; }
  double integral(double v) const {
    return mean * 2.0 * kPi * (0.25 - v) + swing * (1.0 - sine_cosine(v).sine);
  }
};

/// The plate's rows while their counts are found: those that have a certain number of points, and
/// those that share the others by their weights.
struct RowPlan {
  std::vector<Row> certain, flexible;
  std::vector<double> weights;
  double points = 0.0;

  void add(Row row, double weight) {
    points += weight;
    weights.push_back(weight);
    flexible.push_back(row);
  }
  void add_certain(Row row, std::uint64_t count) {
    row.count = count;
    points += static_cast<double>(count);
    certain.push_back(row);
  }
};

/// A part of a flat side's row, from `begin` to `end`. Short parts have a certain number of points,
/// because one more would crowd them.
void add_part(RowPlan& plan, Row row, double begin, double end, double spacing) {
  if (end < begin) return;
  row.begin = begin;
  row.end = end;
  const double length = end - begin;
  if (length < 0.85 * spacing)
    plan.add_certain(row, 1);
  else if (length < 1.5 * spacing)
    plan.add_certain(row, 2);
  else
    plan.add(row, 1.0 + length / (kPointDistance * spacing));
}

void add_side(RowPlan& plan, PlateSheet sheet, double spacing) {
  const double reach = kPlateRadius - kSideMargin * spacing;
  const double hole = kPlateHoleRadius + kSideMargin * spacing;
  if (!(reach > 0.0)) return;
  const double steps = std::max(1.0, std::floor(2.0 * reach / (kRowDistance * spacing) + 0.5));
  for (double j = 0.0; j <= steps; j += 1.0) {
    Row row;
    row.sheet = sheet;
    row.v = reach * (2.0 * (j / steps) - 1.0);
    row.stagger = std::fmod(j, 2.0) == 0.0 ? -0.25 : 0.25;
    const double half = std::sqrt(std::max(0.0, reach * reach - row.v * row.v));
    std::vector<std::pair<double, double>> gaps;
    for (int k = 0; k < kPlateHoles; ++k) {
      const Vec3 center = plate_hole_center(k);
      const double across = row.v - center.y, square = hole * hole - across * across;
      if (square > 0.0)
        gaps.emplace_back(center.x - std::sqrt(square), center.x + std::sqrt(square));
    }
    std::sort(gaps.begin(), gaps.end());
    double begin = -half;
    for (const auto& [first, last] : gaps) {
      add_part(plan, row, begin, std::min(half, first), spacing);
      begin = std::max(begin, last);
    }
    add_part(plan, row, begin, half, spacing);
  }
}

/// The angle in turns where the integral of the root density is that part of the whole.
double rim_angle(const RimDensity& density, double part) {
  const double target = part * density.integral(-0.25);
  double low = -0.25, high = 0.25;  // the integral falls with the angle
  for (int step = 0; step < 64; ++step) {
    const double middle = 0.5 * (low + high);
    (density.integral(middle) < target ? high : low) = middle;
  }
  return low;
}

void add_rim(RowPlan& plan, int sheet, const RimDensity& density, double spacing) {
  const RimCircle circle = rim_circle(sheet);
  const double width = kPlateHalf * density.integral(-0.25);
  const double count = std::max(2.0, std::floor(width / (kRowDistance * spacing) + 0.5));
  for (double j = 0.0; j < count; j += 1.0) {
    Row row;
    row.sheet = sheet;
    row.closed = true;
    row.v = rim_angle(density, (j + 0.5) / count);
    row.begin = portable::fraction(static_cast<std::uint64_t>(j) * portable::kGoldenStep);
    const double radius = circle.radius + circle.side * kPlateHalf * sine_cosine(row.v).cosine;
    plan.add(row, 2.0 * kPi * radius * density.root(row.v) / (kPointDistance * spacing));
  }
}

/// `spacing`: where the density is 1.
RowPlan plan_rows(double spacing, bool varying) {
  RowPlan plan;
  const double on_sides = varying ? 2.0 : 1.0;
  add_side(plan, kPlateTop, spacing / on_sides);
  add_side(plan, kPlateBottom, spacing / on_sides);
  add_rim(plan, kPlateRim, {on_sides, varying ? 2.0 : 0.0}, spacing);
  for (int k = 0; k < kPlateHoles; ++k)
    add_rim(plan, kPlateFirstHole + k, {on_sides, varying ? -1.0 : 0.0}, spacing);
  return plan;
}

}  // namespace

Vec3 plate_hole_center(int hole) {
  const SineCosine turn = sine_cosine(static_cast<double>(hole) / kPlateHoles);
  return {kPlateHoleDistance * turn.cosine, kPlateHoleDistance * turn.sine, 0.0};
}

double plate_area() {
  const double sides =
      2.0 * kPi * (kPlateRadius * kPlateRadius - kPlateHoles * kPlateHoleRadius * kPlateHoleRadius);
  const double around = 2.0 * kPi * kPlateHalf;
  const double rim = around * (kPi * kPlateRadius + 2.0 * kPlateHalf);
  const double hole = around * (kPi * kPlateHoleRadius - 2.0 * kPlateHalf);
  return sides + rim + kPlateHoles * hole;
}

SurfacePoint plate_side_point(PlateSheet sheet, double x, double y) {
  const double up = sheet == kPlateTop ? 1.0 : -1.0;
  return {{x, y, up * kPlateHalf}, {0.0, 0.0, up}};
}

SurfacePoint plate_rim_point(int sheet, SineCosine a, SineCosine v) {
  const RimCircle circle = rim_circle(sheet);
  const double from_center = circle.radius + circle.side * kPlateHalf * v.cosine;
  return {circle.center + Vec3{from_center * a.cosine, from_center * a.sine, kPlateHalf * v.sine},
          {circle.side * v.cosine * a.cosine, circle.side * v.cosine * a.sine, v.sine}};
}

TubeField plate_field(Vec3 position) {
  // The distance from the flat middle in its plane: positive beside it, with its direction.
  const Vec3 flat{position.x, position.y, 0.0};
  double beside = norm(flat) - kPlateRadius;
  Vec3 away = normalized(flat);
  for (int k = 0; k < kPlateHoles; ++k) {
    const Vec3 from_center = flat - plate_hole_center(k);
    const double inside = kPlateHoleRadius - norm(from_center);
    if (inside <= beside) continue;
    beside = inside;
    away = -normalized(from_center);
  }
  if (beside <= 0.0)
    return {std::abs(position.z) - kPlateHalf, {0.0, 0.0, position.z < 0.0 ? -1.0 : 1.0}};
  const double distance = std::sqrt(beside * beside + position.z * position.z);
  return {distance - kPlateHalf,
          (beside / distance) * away + Vec3{0.0, 0.0, position.z / distance}};
}

std::vector<Row> plate_rows(std::uint64_t points, bool density_varying) {
  double sparse = 1e3, dense = 1e-6;  // spacings
  for (int step = 0; step < 64; ++step) {
    const double middle = std::sqrt(sparse * dense);
    (plan_rows(middle, density_varying).points < static_cast<double>(points) ? sparse : dense) =
        middle;
  }
  RowPlan plan = plan_rows(sparse, density_varying);
  std::uint64_t certain = 0;
  for (const Row& row : plan.certain) certain += row.count;
  std::vector<Row> rows;
  append_counted(rows, std::move(plan.flexible), plan.weights, points - std::min(points, certain));
  for (Row& row : plan.certain) {
    row.count = std::min(row.count, points);
    points -= row.count;
    if (row.count > 0) rows.push_back(row);
  }
  return rows;
}

}  // namespace orbweave::synthetic
