#include "engine/synthetic/scene_scanner.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/synthetic/portable_math.h"
#include "engine/synthetic/scene_rays.h"
#include "io/error.h"

namespace orbweave {
namespace {

using portable::SineCosine;
using synthetic::FlightLine;
using synthetic::PointMoments;
using synthetic::RayHit;
using synthetic::Scene;

constexpr std::uint64_t kFewestPoints = 1000;
constexpr double kGrazingCosine = 0.08715574274765817;  ///< of 85 degrees
constexpr double kLowestTurns = -1.0 / 6.0;             ///< of a tripod's rays: 60 degrees down
constexpr double kHighestTurns = 0.25;                  ///< straight up
/// Half of what a depth camera sees, as tangents: 58 by 45 degrees; and how far, metres.
constexpr double kCameraTangentX = 0.55430905145276899, kCameraTangentY = 0.41421356237309503;
constexpr double kCameraReach = 5.0;
constexpr double kCoarseTripod = 1.0 / 300.0;           ///< step of the first look, turns
constexpr double kCoarseLine = 1.0 / 4000.0;            ///< likewise, of lines of flight
constexpr double kLeafStep = 0.25, kLeafChance = 0.12;  ///< metres in a crown; hit per step
constexpr double kMixedGap = 0.02;                      ///< of ranges that mix, relative
// Random numbers of different meaning come from different seeds.
constexpr std::uint64_t kSetupStream = 0x5CE7u, kPoseStream = 0x5C9Eu, kLeafStream = 0x1EAFu,
                        kMixedStream = 0x313Du;

void check(const SceneScannerOptions& options) {
  if (options.points < kFewestPoints)
    throw_usage("scans of a scene have at least 1,000 points",
                {.found = std::to_string(options.points), .expected = {}, .advice = {}});
  if (!(options.noise >= 0.0) || !std::isfinite(options.noise))
    throw_usage("noise must be a finite number of spacings, not negative");
  if (options.noise_growth < 0 || options.noise_growth > 2)
    throw_usage("noise grows with the power 0, 1 or 2 of the distance",
                {.found = std::to_string(options.noise_growth), .expected = {}, .advice = {}});
  if (!(options.misregistration >= 0.0) || !std::isfinite(options.misregistration))
    throw_usage("misregistration must be a finite number of spacings, not negative");
}

double random_fraction(std::uint64_t seed, std::uint64_t index) {
  return portable::fraction(portable::mixed(portable::mixed(seed) + index * portable::kGoldenStep));
}

/// Rays or rows of a camera, of which the angle between two in its middle is the step.
std::size_t across_camera(double tangent, double step) {
  return static_cast<std::size_t>(2.0 * tangent / (2.0 * portable::kPi * step));
}

/// A ray in world coordinates, and one beside it by half a step: the edge of the beam.
struct Ray {
  Vec3 origin, direction, beside;
};

/// The rays of one scan: rows by columns, `step` turns apart.
struct View {
  RigidMotion truth;  ///< from the scan's frame, without misregistration
  synthetic::Quaternion rotation = {0, 0, 0, 1};
  double row_phase = 0.0, column_phase = 0.0;
};

}  // namespace

struct SceneScanner::State {
  SceneScannerOptions options;
  Scene scene;
  synthetic::SceneRays rays;
  double spacing = 0.0;
  double step = 0.0;           ///< between rays, turns
  double mean_distance = 1.0;  ///< of returns
  std::vector<View> views;

  State(const SceneScannerOptions& given, Scene built)
      : options(given), scene(std::move(built)), rays(scene.triangles) {}

  bool has_tripods() const { return !scene.tripods.empty(); }
  bool has_cameras() const { return !scene.targets.empty(); }
  std::size_t rows(std::size_t scan) const;
  std::size_t columns(std::size_t scan) const;
  Ray ray(std::size_t scan, std::size_t row, std::size_t column) const;
  Ray tripod_ray(std::size_t scan, std::size_t row, std::size_t column) const;
  Ray camera_ray(std::size_t scan, std::size_t row, std::size_t column) const;
  Ray airborne_ray(std::size_t scan, std::size_t row, std::size_t column) const;
  /// What stops a ray first, seen from its front and not at a grazing angle.
  std::optional<RayHit> first_hit(std::size_t scan, double time, Vec3 origin, Vec3 direction) const;
  std::optional<double> range(std::size_t scan, double time, const Ray& ray,
                              std::uint64_t index) const;
  std::optional<double> leaf(const Ray& ray, double limit, std::uint64_t index) const;
  /// Calls visit(ray, distance, index of the ray) for every return of a row, in order.
  template <class Visit>
  void visit_row(std::size_t scan, std::size_t row, const Visit& visit) const;
  struct Look {
    PointMoments moments;
    double distance = 0.0;  ///< sum
  };
  Look look(std::size_t scan) const;
  void place_views();
  std::vector<Look> choose_step();
  std::vector<std::uint64_t> count_points(std::size_t scan) const;
  void scan_row(std::size_t scan, std::size_t row, Vec3* out) const;
};

void SceneScanner::State::place_views() {
  const std::size_t scans = has_tripods() ? scene.tripods.size() : scene.lines.size();
  for (std::size_t scan = 0; scan < scans; ++scan) {
    const auto random = [&](std::uint64_t k) {
      return random_fraction(options.seed + kSetupStream, 3 * scan + k);
    };
    View view;
    if (has_tripods()) {
      view.rotation = synthetic::turn_around_z(random(0));
      view.truth = motion_of_quaternion(view.rotation, scene.tripods[scan]);
    }
    view.row_phase = random(1);
    view.column_phase = random(2);
    views.push_back(view);
  }
}

std::size_t SceneScanner::State::rows(std::size_t scan) const {
  if (has_cameras()) return across_camera(kCameraTangentY, step);
  if (has_tripods()) return static_cast<std::size_t>((kHighestTurns - kLowestTurns) / step);
  const FlightLine& line = scene.lines[scan];
  const double distance = 2.0 * portable::kPi * step * line.begin.z;
  return static_cast<std::size_t>(norm(line.end - line.begin) / distance);
}

std::size_t SceneScanner::State::columns(std::size_t scan) const {
  if (has_cameras()) return across_camera(kCameraTangentX, step);
  const double turns = has_tripods() ? 1.0 : 2.0 * scene.lines[scan].half_angle_turns;
  return static_cast<std::size_t>(turns / step);
}

Ray SceneScanner::State::ray(std::size_t scan, std::size_t row, std::size_t column) const {
  if (has_cameras()) return camera_ray(scan, row, column);
  return has_tripods() ? tripod_ray(scan, row, column) : airborne_ray(scan, row, column);
}

Ray SceneScanner::State::camera_ray(std::size_t scan, std::size_t row, std::size_t column) const {
  const View& view = views[scan];
  const Vec3 place = scene.tripods[scan], ahead = normalized(scene.targets[scan] - place);
  const Vec3 right = normalized(cross(ahead, Vec3{0, 0, 1})), up = cross(right, ahead);
  const double pixel = 2.0 * portable::kPi * step;
  const auto towards = [&](double offset) {
    const double x = (static_cast<double>(column) + view.column_phase + offset) * pixel;
    const double y = (static_cast<double>(row) + view.row_phase + offset) * pixel;
    return normalized(ahead + (x - kCameraTangentX) * right + (y - kCameraTangentY) * up);
  };
  return {place, towards(0.0), towards(0.5)};
}

Ray SceneScanner::State::tripod_ray(std::size_t scan, std::size_t row, std::size_t column) const {
  const View& view = views[scan];
  const auto towards = [&](double offset) {
    const SineCosine up = portable::sine_cosine(
        kLowestTurns + (static_cast<double>(row) + view.row_phase + offset) * step);
    const SineCosine around =
        portable::sine_cosine((static_cast<double>(column) + view.column_phase + offset) * step);
    return view.truth.direction({up.cosine * around.cosine, up.cosine * around.sine, up.sine});
  };
  return {scene.tripods[scan], towards(0.0), towards(0.5)};
}

Ray SceneScanner::State::airborne_ray(std::size_t scan, std::size_t row, std::size_t column) const {
  const View& view = views[scan];
  const FlightLine& line = scene.lines[scan];
  const Vec3 along = normalized(line.end - line.begin), across = cross(along, Vec3{0, 0, 1});
  const double way =
      (static_cast<double>(row) + view.row_phase) * 2.0 * portable::kPi * step * line.begin.z;
  const auto towards = [&](double offset) {
    const SineCosine angle = portable::sine_cosine(
        (static_cast<double>(column) + view.column_phase + offset) * step - line.half_angle_turns);
    return angle.sine * across - angle.cosine * Vec3{0, 0, 1};
  };
  return {line.begin + way * along, towards(0.0), towards(0.5)};
}

std::optional<RayHit> SceneScanner::State::first_hit(std::size_t scan, double time, Vec3 origin,
                                                     Vec3 direction) const {
  std::optional<RayHit> hit = rays.first_hit(origin, direction);
  if (options.disturbances)
    for (const synthetic::Walker& walker : scene.walkers) {
      if (walker.scan != scan) continue;
      const Vec3 foot = walker.from + time * (walker.to - walker.from);
      const auto body =
          synthetic::cylinder_hit(foot, walker.radius, walker.height, origin, direction);
      if (body && (!hit || body->distance < hit->distance)) hit = body;
    }
  if (!hit || -dot(hit->normal, direction) < kGrazingCosine) return std::nullopt;
  if (has_cameras() && hit->distance > kCameraReach) return std::nullopt;
  return hit;
}

/// Half of the beams that end on two surfaces return a distance between both.
std::optional<double> SceneScanner::State::range(std::size_t scan, double time, const Ray& ray,
                                                 std::uint64_t index) const {
  const std::optional<RayHit> hit = first_hit(scan, time, ray.origin, ray.direction);
  if (!hit) return std::nullopt;
  const double share = 2.0 * random_fraction(options.seed + kMixedStream, index);
  if (!options.disturbances || share >= 1.0) return hit->distance;
  const std::optional<RayHit> beside = first_hit(scan, time, ray.origin, ray.beside);
  if (!beside) return hit->distance;
  // One surface goes on in the plane that the first ray meets.
  const double gap = beside->distance - hit->distance;
  const double in_plane =
      hit->distance * (dot(ray.direction, hit->normal) / dot(ray.beside, hit->normal) - 1.0);
  if (std::abs(gap - in_plane) < kMixedGap * hit->distance) return hit->distance;
  return hit->distance + share * gap;
}

/// Distance to the first leaf on a ray, nearer than `limit`.
std::optional<double> SceneScanner::State::leaf(const Ray& ray, double limit,
                                                std::uint64_t index) const {
  std::optional<double> first;
  for (std::size_t tree = 0; tree < scene.crowns.size(); ++tree) {
    const synthetic::Crown& crown = scene.crowns[tree];
    const auto chord = synthetic::ball_chord(crown.center, crown.radius, ray.origin, ray.direction);
    if (!chord) continue;
    const std::uint64_t seed = options.seed + kLeafStream + tree;
    std::uint64_t draw = 64 * index;
    for (double at = chord->enter; at < chord->leave; at += kLeafStep, ++draw) {
      const double place = random_fraction(seed, draw);
      if (place >= kLeafChance) continue;
      const double distance = at + kLeafStep * place / kLeafChance;
      if (distance < std::min({limit, chord->leave, first.value_or(limit)})) first = distance;
      break;
    }
  }
  return first;
}

template <class Visit>
void SceneScanner::State::visit_row(std::size_t scan, std::size_t row, const Visit& visit) const {
  const std::size_t count = columns(scan);
  for (std::size_t column = 0; column < count; ++column) {
    const std::uint64_t index = (scan * rows(scan) + row) * count + column;
    const Ray beam = ray(scan, row, column);
    const double time = static_cast<double>(column) / static_cast<double>(count);
    const std::optional<double> distance = range(scan, time, beam, index);
    const std::optional<double> leaf_at =
        options.disturbances ? leaf(beam, distance.value_or(2.0 * beam.origin.z), index)
                             : std::nullopt;
    if (leaf_at) visit(beam, *leaf_at, index);
    // Half of the pulses that meet a leaf have no other return.
    if (distance && (!leaf_at || (portable::mixed(index) & 1) == 0)) visit(beam, *distance, index);
  }
}

SceneScanner::State::Look SceneScanner::State::look(std::size_t scan) const {
  std::vector<Look> looks(rows(scan));
  tbb::parallel_for(std::size_t{0}, looks.size(), [&](std::size_t row) {
    visit_row(scan, row, [&](const Ray& ray, double distance, std::uint64_t) {
      looks[row].moments.add(ray.origin + distance * ray.direction);
      looks[row].distance += distance;
    });
  });
  Look sum;
  for (const Look& look : looks) {
    sum.moments.add(look.moments);
    sum.distance += look.distance;
  }
  return sum;
}

/// So small that all scans together get about the wanted number of points.
std::vector<SceneScanner::State::Look> SceneScanner::State::choose_step() {
  step = has_tripods() ? kCoarseTripod : kCoarseLine;
  std::vector<Look> looks;
  double points = 0.0, distance = 0.0;
  for (std::size_t scan = 0; scan < views.size(); ++scan) {
    looks.push_back(look(scan));
    points += looks.back().moments.points;
    distance += looks.back().distance;
  }
  mean_distance = distance / points;
  step *= std::sqrt(points / static_cast<double>(options.points));
  return looks;
}

/// Index of each row's first point, and the number of points.
std::vector<std::uint64_t> SceneScanner::State::count_points(std::size_t scan) const {
  std::vector<std::uint64_t> first(rows(scan) + 1, 0);
  tbb::parallel_for(std::size_t{0}, rows(scan), [&](std::size_t row) {
    visit_row(scan, row, [&](const Ray&, double, std::uint64_t) { ++first[row + 1]; });
  });
  for (std::size_t row = 0; row + 1 < first.size(); ++row) first[row + 1] += first[row];
  return first;
}

void SceneScanner::State::scan_row(std::size_t scan, std::size_t row, Vec3* out) const {
  const double deviation = options.noise * spacing;
  const View& view = views[scan];
  visit_row(scan, row, [&](const Ray& ray, double distance, std::uint64_t index) {
    double noise = deviation;
    for (int power = 0; power < options.noise_growth; ++power) noise *= distance / mean_distance;
    if (noise > 0.0) distance += noise * portable::gaussian(options.seed, 4 * index + scan).x;
    const Vec3 p = ray.origin + distance * ray.direction - view.truth.translation;
    *out++ = {dot({view.truth.rows[0].x, view.truth.rows[1].x, view.truth.rows[2].x}, p),
              dot({view.truth.rows[0].y, view.truth.rows[1].y, view.truth.rows[2].y}, p),
              dot({view.truth.rows[0].z, view.truth.rows[1].z, view.truth.rows[2].z}, p)};
  });
}

SceneScanner::SceneScanner(const SceneScannerOptions& options) : RangeScans(options.precision) {
  check(options);
  auto state = std::make_unique<State>(options, synthetic::scene_of(options.scene));
  state->spacing =
      std::sqrt(synthetic::truth_area(state->scene) / static_cast<double>(options.points));
  state->place_views();
  const std::vector<State::Look> looks = state->choose_step();
  for (std::size_t scan = 0; scan < state->views.size(); ++scan) {
    const View& view = state->views[scan];
    std::optional<ScannerPlace> scanner;
    if (state->has_tripods()) scanner = ScannerPlace{};
    scans_.push_back(
        {.pose = misregistered(view.rotation, view.truth.translation, looks[scan].moments,
                               options.misregistration * state->spacing, options.seed + kPoseStream,
                               scan),
         .scanner = scanner,
         .row_first = state->count_points(scan)});
  }
  state_ = std::move(state);
}
SceneScanner::~SceneScanner() = default;

double SceneScanner::spacing() const { return state_->spacing; }
const Scene& SceneScanner::scene() const { return state_->scene; }

void SceneScanner::cast_row(std::size_t scan, std::size_t row, Vec3* out) const {
  state_->scan_row(scan, row, out);
}

}  // namespace orbweave
