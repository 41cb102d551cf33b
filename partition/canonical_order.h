// The canonical order: one total order on points that depends on nothing but the points and
// the cloud's bounds. docs/dev/canonical-order.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/point_cloud.h"
#include "partition/root_cube.h"

namespace orbweave {

/// Maps points to fine Morton codes: the cells of side root.side / 2^21 that the coordinates lie
/// in, interleaved. Exact (no rounding moves a point to another cell), hence in step with every
/// power-of-two lattice anchored at zero, the count grid's among them.
class MortonFrame {
 public:
  MortonFrame() = default;
  explicit MortonFrame(const RootCube& root);
  /// Points outside the cube are clamped to it.
  std::uint64_t code(Vec3 p) const;
  /// Index of the finest cell along one axis, 0 to 2^21 - 1.
  std::uint32_t coordinate(double value, int axis) const;

 private:
  double scale_ = 0.0;  ///< finest cells per world unit, a power of two
  double shift_[3] = {0.0, 0.0, 0.0};
  double low_[3] = {0.0, 0.0, 0.0};
};

/// Fine Morton code of a point (x lowest bit of each triple), 63 bits. Points outside the cube
/// are clamped to it.
std::uint64_t morton_code(Vec3 p, const RootCube& root);
/// Interleaves three 21-bit cell coordinates.
std::uint64_t interleave(std::uint32_t x, std::uint32_t y, std::uint32_t z);
/// Undoes `interleave` for one axis (0: x, 1: y, 2: z).
std::uint32_t deinterleave(std::uint64_t code, int axis);

/// The columns of a cloud that decide its order.
struct PointColumns {
  std::span<const Vec3> positions;
  std::span<const Vec3> normals;          ///< empty: none
  std::span<const std::byte> attributes;  ///< rows of attribute_bytes
  std::size_t attribute_bytes = 0;
};
PointColumns columns_of(const PointCloud& cloud);

/// The rows of a cloud in the order of sort_canonically, duplicates left out.
std::vector<std::uint32_t> canonical_rows(const PointColumns& columns, const RootCube& root);

/// Sorts a cloud canonically: by Morton code, then x, y, z, then the bytes of normal,
/// attributes and position; then collapses exact duplicates (equal x, y, z; -0 equals 0) to the
/// first of them. Returns the number of points that were merged away. Positions must be finite.
/// Large clouds are sorted by the calling thread's TBB arena. O(n) but for ties; needs about
/// 60 bytes per point for its time. Fewer than 2^32 points.
std::uint64_t sort_canonically(PointCloud& cloud, const RootCube& root);

/// True when a comes before b: by Morton code, then by x, y, z.
bool canonically_before(Vec3 a, Vec3 b, const RootCube& root);

}  // namespace orbweave
