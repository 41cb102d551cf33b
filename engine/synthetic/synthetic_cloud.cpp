#include "engine/synthetic/synthetic_cloud.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <string>

#include "engine/synthetic/plate.h"
#include "engine/synthetic/rows.h"
#include "engine/synthetic/surfaces.h"
#include "io/error.h"

namespace orbweave {
namespace {

using portable::kPi;
using portable::sine_cosine;
using portable::SineCosine;
using synthetic::Row;
using synthetic::SurfacePoint;

constexpr std::array<Shape, 8> kShapes = {
    Shape::kSphere,     Shape::kTorus, Shape::kBumpyTorus,    Shape::kPlane,
    Shape::kDoubleWall, Shape::kCube,  Shape::kTwoComponents, Shape::kGenusThree};
constexpr std::array<std::string_view, 8> kShapeNames = {
    "sphere", "torus", "bumpy-torus", "plane", "double-wall", "cube", "two-components", "genus-3"};

/// The midpoint rule, which converges geometrically for a periodic analytic integrand.
double bumpy_torus_area() {
  constexpr int kSteps = 256;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j)
      sum += synthetic::bumpy_torus_area_element(static_cast<double>(i) / kSteps,
                                                 static_cast<double>(j) / kSteps);
  return sum * (2.0 * kPi / kSteps) * (2.0 * kPi / kSteps);
}

/// Spherical Fibonacci lattice: equal steps of area along z, golden steps around it. Stretching
/// it along z by a smooth density keeps it near-uniform, because no stretch brings points of a
/// golden lattice close together.
SurfacePoint sphere_point(std::uint64_t i, std::uint64_t points, bool density_varying) {
  const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(points);
  // t: height from the south pole in diameters; (1 + 3 t)^3 = 1 + 63 u for density (1 + 3 t)^2.
  const double t = density_varying ? (portable::cube_root(1.0 + 63.0 * u) - 1.0) / 3.0 : u;
  const double ring = 2.0 * std::sqrt(std::max(0.0, t * (1.0 - t)));
  const SineCosine a = sine_cosine(portable::fraction(i * portable::kGoldenStep));
  const Vec3 position{ring * a.cosine, ring * a.sine, 2.0 * t - 1.0};
  return {position, normalized(position)};
}

SurfacePoint face_or_edge_point(const Row& row, double u, bool density_varying) {
  Vec3 position;
  if (row.sheet < 6) {
    const int axis = row.sheet / 2;
    position[axis] = row.sheet % 2;
    position[axis == 0 ? 1 : 0] = u;
    position[axis == 2 ? 1 : 2] = row.v;
    return {position, synthetic::cube_normal(position)};
  }
  const int axis = (row.sheet - 6) / 4;
  const int corner = (row.sheet - 6) % 4;
  const synthetic::DensityProfile profile{density_varying && axis == 2};
  position[axis] = profile.inverse_integral(u * profile.integral(1.0));
  position[axis == 0 ? 1 : 0] = (corner & 1) == 0 ? 0.0 : 1.0;
  position[axis == 2 ? 1 : 2] = (corner & 2) == 0 ? 0.0 : 1.0;
  return {position, synthetic::cube_normal(position)};
}

}  // namespace

std::string_view name_of(Shape shape) { return kShapeNames[static_cast<std::size_t>(shape)]; }

std::optional<Shape> shape_named(std::string_view name) {
  for (const Shape shape : kShapes)
    if (name == name_of(shape)) return shape;
  return std::nullopt;
}

std::span<const Shape> all_shapes() { return kShapes; }

void check_options(const SyntheticOptions& options) {
  if (options.points == 0) throw_usage("a synthetic cloud needs at least one point");
  if (!(options.noise >= 0.0) || !std::isfinite(options.noise))
    throw_usage("noise must be a finite number of spacings, not negative");
  if (options.precision != ScalarType::kFloat64 && options.precision != ScalarType::kFloat32)
    throw_usage("positions are float32 or float64", {.file = {},
                                                     .place = {},
                                                     .found = name_of(options.precision),
                                                     .expected = {},
                                                     .advice = {}});
}

double surface_area(Shape shape) {
  switch (shape) {
    case Shape::kSphere:
      return 4.0 * kPi;
    case Shape::kTorus:
      return 4.0 * kPi * kPi * synthetic::kMajorRadius * synthetic::kTubeRadius;
    case Shape::kBumpyTorus: {
      static const double area = bumpy_torus_area();
      return area;
    }
    case Shape::kPlane:
      return 1.0;
    case Shape::kDoubleWall:
      return 2.0;
    case Shape::kCube:
      return 6.0;
    case Shape::kTwoComponents:
      return surface_area(Shape::kTorus) +
             surface_area(Shape::kSphere) * synthetic::kUpperRadius * synthetic::kUpperRadius;
    case Shape::kGenusThree:
      return synthetic::plate_area();
  }
  return 0.0;
}

double spacing(const SyntheticOptions& options) {
  return std::sqrt(surface_area(options.shape) / static_cast<double>(options.points));
}

struct SyntheticCloud::State {
  SyntheticOptions options;
  PointSchema schema;
  std::uint64_t on_sphere = 0;  ///< the first points
  std::vector<Row> rows;        ///< of the others
  double noise = 0.0;           ///< world units
  double gap = 0.0;             ///< between the walls, world units
  std::uint64_t next = 0;

  std::uint64_t point_bytes() const { return 6 * size_of(options.precision); }
  SurfacePoint on_sphere_point(std::uint64_t index) const;
  SurfacePoint row_point(const Row& row, SineCosine around_tube, std::uint64_t k) const;
  void fill(PointCloud& batch, std::uint64_t first, std::size_t begin, std::size_t end) const;
  void store(PointCloud& batch, std::size_t slot, std::uint64_t index, SurfacePoint point) const;
};

SurfacePoint SyntheticCloud::State::on_sphere_point(std::uint64_t index) const {
  const SurfacePoint point = sphere_point(index, on_sphere, options.density_varying);
  return options.shape == Shape::kSphere ? point : synthetic::upper_sphere_point(point);
}

SurfacePoint SyntheticCloud::State::row_point(const Row& row, SineCosine around_tube,
                                              std::uint64_t k) const {
  const double u = synthetic::along(row, k);
  switch (options.shape) {
    case Shape::kTorus:
    case Shape::kTwoComponents:
      return synthetic::torus_point(u, around_tube);
    case Shape::kBumpyTorus:
      return synthetic::bumpy_torus_point(u, row.v, around_tube);
    case Shape::kDoubleWall:
      if (row.sheet == 0) return {{u, row.v, 0.0}, {0.0, 0.0, -1.0}};
      return {{u, row.v, gap}, {0.0, 0.0, 1.0}};
    case Shape::kCube:
      return face_or_edge_point(row, u, options.density_varying);
    case Shape::kGenusThree:
      if (row.closed) return synthetic::plate_rim_point(row.sheet, sine_cosine(u), around_tube);
      return synthetic::plate_side_point(static_cast<synthetic::PlateSheet>(row.sheet), u, row.v);
    default:
      return {{u, row.v, 0.0}, {0.0, 0.0, 1.0}};
  }
}

void SyntheticCloud::State::store(PointCloud& batch, std::size_t slot, std::uint64_t index,
                                  SurfacePoint point) const {
  if (noise > 0.0)
    point.position = point.position + noise * portable::gaussian(options.seed, index);
  if (options.precision == ScalarType::kFloat32) {
    point.position = portable::rounded_to_float(point.position);
    point.normal = portable::rounded_to_float(point.normal);
  }
  batch.positions[slot] = point.position;
  batch.normals[slot] = point.normal;
}

void SyntheticCloud::State::fill(PointCloud& batch, std::uint64_t first, std::size_t begin,
                                 std::size_t end) const {
  for (; begin < end && first + begin < on_sphere; ++begin)
    store(batch, begin, first + begin, on_sphere_point(first + begin));
  if (begin == end) return;
  const auto after =
      std::upper_bound(rows.begin(), rows.end(), first + begin,
                       [](std::uint64_t index, const Row& row) { return index < row.first; });
  auto row = after - 1;
  for (std::size_t slot = begin; slot < end; ++row) {
    const SineCosine around_tube = row->closed ? sine_cosine(row->v) : SineCosine{};
    const std::uint64_t last = std::min(first + end, row->first + row->count);
    for (; first + slot < last; ++slot)
      store(batch, slot, first + slot, row_point(*row, around_tube, first + slot - row->first));
  }
}

SyntheticCloud::SyntheticCloud(const SyntheticOptions& options)
    : state_(std::make_unique<State>()) {
  check_options(options);
  state_->options = options;
  state_->schema.has_normals = true;
  state_->schema.position_type = options.precision;
  state_->schema.normal_type = options.precision;
  state_->on_sphere = synthetic::sphere_points(options);
  state_->rows = synthetic::rows_of(options);
  state_->noise = options.noise * spacing(options);
  state_->gap = synthetic::kWallGap * spacing(options);
}
SyntheticCloud::~SyntheticCloud() = default;

const PointSchema& SyntheticCloud::schema() const { return state_->schema; }

std::optional<std::uint64_t> SyntheticCloud::declared_points() const {
  return state_->options.points;
}

bool SyntheticCloud::read(PointCloud& batch, std::size_t capacity) {
  batch.schema = state_->schema;
  batch.clear();
  const std::uint64_t first = state_->next;
  const auto count =
      static_cast<std::size_t>(std::min<std::uint64_t>(capacity, state_->options.points - first));
  if (count == 0) return false;
  batch.positions.resize(count);
  batch.normals.resize(count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 8192),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      state_->fill(batch, first, range.begin(), range.end());
                    });
  state_->next += count;
  return true;
}

std::uint64_t SyntheticCloud::bytes_read() const { return state_->next * state_->point_bytes(); }
std::uint64_t SyntheticCloud::bytes_total() const {
  return state_->options.points * state_->point_bytes();
}

}  // namespace orbweave
