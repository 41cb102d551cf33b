// Clouds of known surfaces, with exact normals, in any size: what `generate` writes.
//
// The same options give the same bits on every machine and for every batch size
// (engine/synthetic/portable_math.h says how).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "io/point_source.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// World units; every surface is about 1 to 3 units large.
enum class Shape {
  kSphere,      ///< radius 1 around the origin
  kTorus,       ///< around the z axis, radii 1 and 0.4
  kBumpyTorus,  ///< the torus, its tube radius modulated by three sines (together at most 21 %)
  kPlane,       ///< unit square in z = 0, normals up, straight border
  kDoubleWall,  ///< two unit squares three spacings apart, normals outward, open at the sides
  kCube         ///< [0, 1]^3 with points on edges and corners
};
/// "sphere", "torus", "bumpy-torus", "plane", "double-wall", "cube".
std::string_view name_of(Shape shape);
std::optional<Shape> shape_named(std::string_view name);
std::span<const Shape> all_shapes();

struct SyntheticOptions {
  Shape shape = Shape::kSphere;
  std::uint64_t points = 10'000;  ///< exactly so many; at least 1
  /// Standard deviation of each coordinate's noise, in units of spacing(); >= 0. Isotropic and
  /// nearly Gaussian; normals stay those of the undisturbed surface.
  double noise = 0.0;
  /// Density varies 1:16 from one end of the shape to the other: growing with z (sphere, cube),
  /// with y (plane, double wall), from the inner to the outer equator (tori). Locally the points
  /// stay near-uniform.
  bool density_varying = false;
  std::uint64_t seed = 1;                       ///< of the noise
  ScalarType precision = ScalarType::kFloat64;  ///< of positions and normals; or kFloat32
};

/// Throws Error (usage) for zero points, a noise that is negative or not finite, and a precision
/// other than float.
void check_options(const SyntheticOptions& options);

/// Nominal distance between neighbours, world units: sqrt(area / points). Without noise and with
/// uniform density, nearest neighbours are 0.85 to 1.2 spacings apart (bumpy torus: from 0.65) and
/// no point of the surface is farther than 0.9 spacings from the cloud (from 1,000 points on). With
/// varying density it is the mean; the density is proportional to (1 + 3 t)^2, t from 0 to 1 along
/// the shape.
double spacing(const SyntheticOptions& options);

/// Area of the shape, square world units; both sheets of the double wall.
double surface_area(Shape shape);

/// Streams the points in bounded memory (O(sqrt(points)) for a table of rows). Normals have unit
/// length. On the cube, points inside a face have the face's normal, points on an edge or corner
/// the normalised mean of their faces' normals. Runs on the calling TBB arena.
class SyntheticCloud : public PointSource {
 public:
  /// Throws like check_options().
  explicit SyntheticCloud(const SyntheticOptions& options);
  ~SyntheticCloud() override;

  const PointSchema& schema() const override;
  std::optional<std::uint64_t> declared_points() const override;
  bool read(PointCloud& batch, std::size_t capacity) override;
  std::uint64_t bytes_read() const override;
  std::uint64_t bytes_total() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The surface itself as a mesh with exact vertices and normals: about `resolution` edges along
/// its longest closed curve or side (at least 8 are taken). Closed where the shape is closed.
/// Of the options only the shape counts, and for the double wall the number of points, which
/// decides how far apart the walls are.
TriangleMesh truth_mesh(const SyntheticOptions& options, std::uint32_t resolution);

}  // namespace orbweave
