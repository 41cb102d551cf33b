#include "engine/synthetic/virtual_scanner.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "engine/synthetic/portable_math.h"
#include "engine/synthetic/rays.h"
#include "engine/synthetic/surfaces.h"
#include "io/error.h"

namespace orbweave {
namespace {

using portable::kGoldenStep;
using synthetic::Ball;
using synthetic::PointMoments;
using synthetic::Quaternion;

constexpr int kMostScans = 255;
constexpr double kGrazingCosine = 0.17364817766693034885;  ///< of 80 degrees
constexpr int kCoarseRays = 128;  ///< across the shape: enough to know its area to a thousandth
// Random numbers of different meaning come from different seeds.
constexpr std::uint64_t kSetupStream = 0x5E7u, kPoseStream = 0x905Eu;

/// Turns z to the direction `to`, of unit length, by the shortest way.
Quaternion turn_from_z(Vec3 to) {
  if (to.z < -0.999999) return {1, 0, 0, 0};
  const double length = std::sqrt(2.0 * (1.0 + to.z));
  return {-to.y / length, to.x / length, 0.0, (1.0 + to.z) / length};
}

/// From the shape to scanner `scan` of `scans`.
Vec3 direction_of_scan(int scan, int scans) {
  if (scans <= 2 || scans == 6) {
    Vec3 direction;
    direction[scan < 2 ? 2 : scan / 2 - 1] = scan % 2 == 0 ? 1.0 : -1.0;
    return direction;
  }
  SyntheticOptions sphere;
  sphere.points = static_cast<std::uint64_t>(scans);
  SyntheticCloud lattice(sphere);
  PointCloud directions;
  lattice.read(directions, sphere.points);
  return directions.positions[static_cast<std::size_t>(scan)];
}

void check(const VirtualScannerOptions& options) {
  check_options(options.surface);
  if (options.scans < 1 || options.scans > kMostScans)
    throw_usage("a virtual scanner makes 1 to 255 scans",
                {.found = std::to_string(options.scans), .expected = {}, .advice = {}});
  if (!(options.misregistration >= 0.0) || !std::isfinite(options.misregistration))
    throw_usage("misregistration must be a finite number of spacings, not negative");
  if (options.surface.density_varying)
    throw_usage("scans have the density that the scanner gives them, not a varying one");
}

/// One scanner and its grid of rays; (column + phase.x, row + phase.y) times the distance of rays.
struct View {
  Quaternion rotation;
  RigidMotion truth;  ///< from the scanner's frame, without misregistration
  Vec3 phase;
};

View view_of(const VirtualScannerOptions& options, int scan, Vec3 center) {
  const auto random = [&](std::uint64_t k) {
    const std::uint64_t seed = portable::mixed(options.surface.seed + kSetupStream);
    const auto index = static_cast<std::uint64_t>(scan);
    return portable::fraction(portable::mixed(seed + (3 * index + k) * kGoldenStep));
  };
  View view;
  view.rotation = synthetic::product(turn_from_z(direction_of_scan(scan, options.scans)),
                                     synthetic::turn_around_z(random(0)));
  view.truth = motion_of_quaternion(view.rotation, center);
  view.phase = {random(1), random(2), 0.0};
  return view;
}

}  // namespace

struct VirtualScanner::State {
  VirtualScannerOptions options;
  Ball ball;
  double gap = 0.0;  ///< between the two walls
  double ray_distance = 0.0;
  std::size_t reach = 0;  ///< rays on each side of the middle one
  std::vector<View> views;

  std::size_t rays_across() const { return 2 * reach + 1; }
  /// What the ray at (x, y) of the scanner's frame meets, in that frame, without noise.
  std::optional<Vec3> seen(const View& view, double x, double y) const;
  template <class Visit>
  void visit_row(const View& view, std::size_t row, const Visit& visit) const {
    const double middle = static_cast<double>(reach);
    const double y = (static_cast<double>(row) - middle + view.phase.y) * ray_distance;
    for (std::size_t column = 0; column < rays_across(); ++column) {
      const double x = (static_cast<double>(column) - middle + view.phase.x) * ray_distance;
      if (const auto p = seen(view, x, y)) visit(column, *p);
    }
  }
  PointMoments coarse_look(const View& view) const;
  void choose_rays(const std::vector<PointMoments>& looks);
  std::vector<std::uint64_t> count_points(const View& view) const;
  /// The points of a row, with noise, in the scanner's frame.
  void scan_row(std::size_t scan, std::size_t row, Vec3* out) const;
};

std::optional<Vec3> VirtualScanner::State::seen(const View& view, double x, double y) const {
  if (x * x + y * y > ball.radius * ball.radius) return std::nullopt;
  const double height = 1.25 * ball.radius;
  const Vec3 direction = -view.truth.direction({0.0, 0.0, 1.0});
  const auto hit =
      synthetic::first_hit(options.surface.shape, gap, view.truth.point({x, y, height}), direction);
  if (!hit || -dot(hit->normal, direction) < kGrazingCosine) return std::nullopt;
  return Vec3{x, y, height - hit->distance};
}

PointMoments VirtualScanner::State::coarse_look(const View& view) const {
  std::vector<PointMoments> rows(kCoarseRays);
  const auto place = [&](int k) {
    return ball.radius * (static_cast<double>(2 * k + 1) / kCoarseRays - 1.0);
  };
  tbb::parallel_for(0, kCoarseRays, [&](int row) {
    for (int column = 0; column < kCoarseRays; ++column)
      if (const auto p = seen(view, place(column), place(row)))
        rows[static_cast<std::size_t>(row)].add(view.truth.point(*p));
  });
  PointMoments sum;
  for (const PointMoments& row : rows) sum.add(row);
  return sum;
}

/// So far apart that all scans together get about the wanted number of points.
void VirtualScanner::State::choose_rays(const std::vector<PointMoments>& looks) {
  double rays = 0.0;
  for (const PointMoments& look : looks) rays += look.points;
  if (rays == 0.0)
    throw_usage("no scan sees the surface",
                {.found = std::to_string(options.scans) + " scans of a " +
                          std::string(name_of(options.surface.shape)),
                 .expected = {},
                 .advice = "Take more scans."});
  const double coarse = 2.0 * ball.radius / kCoarseRays;
  ray_distance = coarse * std::sqrt(rays / static_cast<double>(options.surface.points));
  reach = static_cast<std::size_t>(std::floor(ball.radius / ray_distance)) + 1;
}

/// Index of each row's first point, and the number of points.
std::vector<std::uint64_t> VirtualScanner::State::count_points(const View& view) const {
  std::vector<std::uint64_t> first(rays_across() + 1, 0);
  tbb::parallel_for(std::size_t{0}, rays_across(), [&](std::size_t row) {
    visit_row(view, row, [&](std::size_t, Vec3) { ++first[row + 1]; });
  });
  for (std::size_t row = 0; row < rays_across(); ++row) first[row + 1] += first[row];
  return first;
}

void VirtualScanner::State::scan_row(std::size_t scan, std::size_t row, Vec3* out) const {
  const double deviation = options.surface.noise * ray_distance;
  const std::uint64_t first_ray = (scan * rays_across() + row) * rays_across();
  visit_row(views[scan], row, [&](std::size_t column, Vec3 p) {
    if (deviation > 0.0)
      p.z += deviation * portable::gaussian(options.surface.seed, first_ray + column).x;
    *out++ = p;
  });
}

VirtualScanner::VirtualScanner(const VirtualScannerOptions& options)
    : RangeScans(options.surface.precision) {
  check(options);
  auto state = std::make_unique<State>();
  state->options = options;
  state->gap = synthetic::kWallGap * spacing(options.surface);
  state->ball = synthetic::bounding_ball(options.surface.shape, state->gap);
  std::vector<PointMoments> looks;
  for (int scan = 0; scan < options.scans; ++scan) {
    state->views.push_back(view_of(options, scan, state->ball.center));
    looks.push_back(state->coarse_look(state->views.back()));
  }
  state->choose_rays(looks);
  const double displacement = options.misregistration * state->ray_distance;
  for (int scan = 0; scan < options.scans; ++scan) {
    const auto index = static_cast<std::size_t>(scan);
    const View& view = state->views[index];
    scans_.push_back(
        {.pose = misregistered(view.rotation, view.truth.translation, looks[index], displacement,
                               options.surface.seed + kPoseStream, index),
         .scanner = ScannerPlace{{0.0, 0.0, 1.0}, true},
         .row_first = state->count_points(view)});
  }
  state_ = std::move(state);
}
VirtualScanner::~VirtualScanner() = default;

double VirtualScanner::ray_distance() const { return state_->ray_distance; }

void VirtualScanner::cast_row(std::size_t scan, std::size_t row, Vec3* out) const {
  state_->scan_row(scan, row, out);
}

}  // namespace orbweave
