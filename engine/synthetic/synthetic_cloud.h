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

#include "engine/synthetic/synthetic_options.h"
#include "io/points/point_source.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// "sphere", "torus", "bumpy-torus", "plane", "double-wall", "cube", "two-components".
std::string_view name_of(Shape shape);
std::optional<Shape> shape_named(std::string_view name);
std::span<const Shape> all_shapes();

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
