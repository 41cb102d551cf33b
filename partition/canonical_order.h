// The canonical order: one total order on points that depends on nothing but the points and
// the cloud's bounds. docs/canonical-order.md.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/point_cloud.h"
#include "partition/root_cube.h"

namespace orbweave {

/// Fine Morton code of a point (x lowest bit of each triple), 63 bits. Points outside the cube
/// are clamped to it.
std::uint64_t morton_code(Vec3 p, const RootCube& root);
/// Interleaves three 21-bit cell coordinates.
std::uint64_t interleave(std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// Sorts a cloud canonically: by Morton code, then x, y, z, then the bytes of normal and
/// attributes; then collapses exact duplicates (equal x, y, z; -0 equals 0) to the first of
/// them. Returns the number of points that were merged away.
std::uint64_t sort_canonically(PointCloud& cloud, const RootCube& root);

/// True when a comes before b: by Morton code, then by x, y, z.
bool canonically_before(Vec3 a, Vec3 b, const RootCube& root);

}  // namespace orbweave
