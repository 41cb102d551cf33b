#include "engine/synthetic/virtual_scanner.h"

#include <tbb/blocked_range.h>
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
using Quaternion = std::array<double, 4>;  // x, y, z, w; turns p into q p q*

constexpr int kMostScans = 255;
constexpr double kGrazingCosine = 0.17364817766693034885;  ///< of 80 degrees
constexpr int kCoarseRays = 128;  ///< across the shape: enough to know its area to a thousandth
constexpr std::uint64_t kBlockPoints = std::uint64_t{1} << 16;
// Random numbers of different meaning come from different seeds.
constexpr std::uint64_t kSetupStream = 0x5E7u, kPoseStream = 0x905Eu;

/// a after b.
Quaternion product(const Quaternion& a, const Quaternion& b) {
  const Vec3 u{a[0], a[1], a[2]}, v{b[0], b[1], b[2]};
  const Vec3 w = a[3] * v + b[3] * u + cross(u, v);
  return {w.x, w.y, w.z, a[3] * b[3] - dot(u, v)};
}

Quaternion normalized(Quaternion q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& part : q) part /= length;
  return q;
}

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

/// What a scanner sees, in short.
struct Moments {
  double points = 0.0;
  Vec3 sum;
  std::array<Vec3, 3> products;  ///< sum of p p^T

  void add(Vec3 p) {
    points += 1.0;
    sum = sum + p;
    for (int axis = 0; axis < 3; ++axis) products[axis] = products[axis] + p[axis] * p;
  }
  void add(const Moments& other) {
    points += other.points;
    sum = sum + other.sum;
    for (int axis = 0; axis < 3; ++axis) products[axis] = products[axis] + other.products[axis];
  }
  Vec3 mean() const { return sum / points; }
  /// Mean of |axis x (p - mean)|^2.
  double leverage(Vec3 axis) const {
    const Vec3 m = mean();
    double square = 0.0, along = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 row = products[k] / points - m[k] * m;
      square += row[k];
      along += axis[k] * dot(row, axis);
    }
    return square * squared_norm(axis) - along;
  }
};

/// One scanner and its grid of rays; (column + phase.x, row + phase.y) times the distance of rays.
struct View {
  Quaternion rotation;
  RigidMotion truth;  ///< from the scanner's frame, without misregistration
  Vec3 phase;
  ScannerPose pose;
  std::vector<std::uint64_t> row_first;  ///< index of each row's first point; and their number
};

Vec3 random_direction(std::uint64_t seed, std::uint64_t index) {
  return normalized(portable::gaussian(seed, index));
}

View view_of(const VirtualScannerOptions& options, int scan, Vec3 center) {
  const auto random = [&](std::uint64_t k) {
    const std::uint64_t seed = portable::mixed(options.surface.seed + kSetupStream);
    const auto index = static_cast<std::uint64_t>(scan);
    return portable::fraction(portable::mixed(seed + (3 * index + k) * kGoldenStep));
  };
  View view;
  const portable::SineCosine half = portable::sine_cosine(0.5 * random(0));
  view.rotation =
      product(turn_from_z(direction_of_scan(scan, options.scans)), {0, 0, half.sine, half.cosine});
  view.truth = motion_of_quaternion(view.rotation, center);
  view.phase = {random(1), random(2), 0.0};
  return view;
}

/// The true pose, then a shift and a turn that displace the points of `moments`, by their root mean
/// square, by `displacement`.
ScannerPose misregistered(const View& view, const Moments& moments, double displacement,
                          std::uint64_t seed, int scan) {
  const auto index = static_cast<std::uint64_t>(scan);
  const double part = displacement * std::sqrt(0.5);
  const Vec3 shift = part * random_direction(seed, 2 * index);
  const Vec3 axis = random_direction(seed, 2 * index + 1);
  const double leverage = moments.points > 0.0 ? moments.leverage(axis) : 0.0;
  const double angle = leverage > 0.0 ? part / std::sqrt(leverage) : 0.0;
  const Vec3 middle = moments.points > 0.0 ? moments.mean() : Vec3{};
  const Vec3 half = 0.5 * angle * axis;
  const RigidMotion turn = motion_of_quaternion({half.x, half.y, half.z, 1.0}, {});
  const Quaternion q = normalized(product({half.x, half.y, half.z, 1.0}, view.rotation));
  ScannerPose pose;
  pose.translation = middle + shift + turn.direction(view.truth.translation - middle);
  pose.motion = motion_of_quaternion(q, pose.translation);
  pose.quaternion = {-q[0], -q[1], -q[2], q[3]};
  return pose;
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
  Moments coarse_look(const View& view) const;
  void choose_rays(const std::vector<Moments>& looks);
  void count_points(View& view) const;
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

Moments VirtualScanner::State::coarse_look(const View& view) const {
  std::vector<Moments> rows(kCoarseRays);
  const auto place = [&](int k) {
    return ball.radius * (static_cast<double>(2 * k + 1) / kCoarseRays - 1.0);
  };
  tbb::parallel_for(0, kCoarseRays, [&](int row) {
    for (int column = 0; column < kCoarseRays; ++column)
      if (const auto p = seen(view, place(column), place(row)))
        rows[static_cast<std::size_t>(row)].add(view.truth.point(*p));
  });
  Moments sum;
  for (const Moments& row : rows) sum.add(row);
  return sum;
}

/// So far apart that all scans together get about the wanted number of points.
void VirtualScanner::State::choose_rays(const std::vector<Moments>& looks) {
  double rays = 0.0;
  for (const Moments& look : looks) rays += look.points;
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

void VirtualScanner::State::count_points(View& view) const {
  view.row_first.assign(rays_across() + 1, 0);
  tbb::parallel_for(std::size_t{0}, rays_across(), [&](std::size_t row) {
    visit_row(view, row, [&](std::size_t, Vec3) { ++view.row_first[row + 1]; });
  });
  for (std::size_t row = 0; row < rays_across(); ++row)
    view.row_first[row + 1] += view.row_first[row];
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

VirtualScanner::VirtualScanner(const VirtualScannerOptions& options) {
  check(options);
  auto state = std::make_unique<State>();
  state->options = options;
  state->gap = synthetic::kWallGap * spacing(options.surface);
  state->ball = synthetic::bounding_ball(options.surface.shape, state->gap);
  std::vector<Moments> looks;
  for (int scan = 0; scan < options.scans; ++scan) {
    state->views.push_back(view_of(options, scan, state->ball.center));
    looks.push_back(state->coarse_look(state->views.back()));
  }
  state->choose_rays(looks);
  const double displacement = options.misregistration * state->ray_distance;
  for (int scan = 0; scan < options.scans; ++scan) {
    View& view = state->views[static_cast<std::size_t>(scan)];
    view.pose = misregistered(view, looks[static_cast<std::size_t>(scan)], displacement,
                              options.surface.seed + kPoseStream, scan);
    state->count_points(view);
  }
  state_ = std::move(state);
}
VirtualScanner::~VirtualScanner() = default;

int VirtualScanner::scans() const { return state_->options.scans; }
double VirtualScanner::ray_distance() const { return state_->ray_distance; }
std::uint64_t VirtualScanner::points(int scan) const {
  return state_->views.at(static_cast<std::size_t>(scan)).row_first.back();
}
std::uint64_t VirtualScanner::points() const {
  std::uint64_t sum = 0;
  for (int scan = 0; scan < scans(); ++scan) sum += points(scan);
  return sum;
}
const ScannerPose& VirtualScanner::pose(int scan) const {
  return state_->views.at(static_cast<std::size_t>(scan)).pose;
}

namespace {

/// The scans from `scan` to before `end`, in their own frames or all in the world's.
class ScanSource : public PointSource {
 public:
  ScanSource(const VirtualScanner::State& state, std::size_t scan, std::size_t end, bool in_world);

  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override { return total_; }
  bool read(PointCloud& batch, std::size_t capacity) override;
  std::uint64_t bytes_read() const override { return given_ * point_bytes(); }
  std::uint64_t bytes_total() const override { return total_ * point_bytes(); }
  std::optional<ScannerPlace> scanner() const override { return place_; }

 private:
  bool next_block();
  std::uint64_t point_bytes() const {
    return 3 * size_of(schema_.position_type) + schema_.attribute_bytes();
  }

  const VirtualScanner::State& state_;
  std::size_t scan_, end_;
  std::size_t row_ = 0;
  bool in_world_;
  PointSchema schema_;
  std::vector<Vec3> block_;  ///< of scan block_scan_
  std::size_t block_next_ = 0;
  std::size_t block_scan_ = 0;
  std::uint64_t given_ = 0, total_ = 0;
  std::optional<ScannerPlace> place_;
};

ScanSource::ScanSource(const VirtualScanner::State& state, std::size_t scan, std::size_t end,
                       bool in_world)
    : state_(state), scan_(scan), end_(end), in_world_(in_world) {
  schema_.position_type = state.options.surface.precision;
  if (in_world) schema_.attributes = {{"scan", ScalarType::kUint8}};
  for (std::size_t k = scan; k < end; ++k) total_ += state.views[k].row_first.back();
}

/// Casts the next rows of one scan; false where there is none left.
bool ScanSource::next_block() {
  while (scan_ < end_ && row_ == state_.rays_across()) {
    ++scan_;
    row_ = 0;
  }
  if (scan_ == end_) return false;
  const std::vector<std::uint64_t>& first = state_.views[scan_].row_first;
  std::size_t stop = row_ + 1;
  while (stop < state_.rays_across() && first[stop] - first[row_] < kBlockPoints) ++stop;
  block_.resize(first[stop] - first[row_]);
  tbb::parallel_for(row_, stop, [&](std::size_t row) {
    state_.scan_row(scan_, row, block_.data() + (first[row] - first[row_]));
  });
  block_scan_ = scan_;
  block_next_ = 0;
  row_ = stop;
  return true;
}

bool ScanSource::read(PointCloud& batch, std::size_t capacity) {
  batch.schema = schema_;
  batch.clear();
  while (block_next_ == block_.size())
    if (!next_block()) return false;
  const ScannerPose& pose = state_.views[block_scan_].pose;
  const std::size_t count = std::min(capacity, block_.size() - block_next_);
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 own = block_[block_next_ + k];
    const Vec3 p = in_world_ ? pose.motion.point(own) : own;
    batch.positions.push_back(
        schema_.position_type == ScalarType::kFloat32 ? portable::rounded_to_float(p) : p);
  }
  if (in_world_) batch.attributes.assign(count, static_cast<std::byte>(block_scan_));
  const Vec3 towards{0.0, 0.0, 1.0};
  place_ = ScannerPlace{in_world_ ? pose.motion.direction(towards) : towards, true};
  block_next_ += count;
  given_ += count;
  return true;
}

}  // namespace

std::unique_ptr<PointSource> VirtualScanner::scan(int scan) const {
  const auto index = static_cast<std::size_t>(scan);
  return std::make_unique<ScanSource>(*state_, index, index + 1, false);
}

std::unique_ptr<PointSource> VirtualScanner::all() const {
  return std::make_unique<ScanSource>(*state_, 0, state_->views.size(), true);
}

}  // namespace orbweave
