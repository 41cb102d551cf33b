#include "partition/root_cube.h"

#include <cmath>

#include "io/error.h"

namespace orbweave {
namespace {

double snapped_down(double value, double step) { return std::floor(value / step) * step; }

}  // namespace

double RootCube::cell(int depth) const { return std::ldexp(side, -depth); }

RootCube root_cube(const Box& bounds) {
  double extent = bounds.largest_extent();
  if (!(extent > 0.0)) {
    // A single point: any cube that its coordinates resolve will do.
    double magnitude = 1.0;
    for (int axis = 0; axis < 3; ++axis)
      magnitude = std::max(magnitude, std::abs(bounds.min[axis]));
    extent = magnitude * 1e-6;
  }
  // Cells of side / 2^21 and their reciprocals must be doubles, and the far side of the cube.
  if (!(extent < 0x1p1000))
    throw_bad_input("the cloud is too large", {.found = "an extent beyond 1e301",
                                               .expected = "coordinates of a scan",
                                               .advice = "Look for a damaged coordinate"});
  extent = std::max(extent, 0x1p-900);
  RootCube root;
  root.side = std::exp2(std::ceil(std::log2(extent)));
  while (root.side < extent) root.side *= 2.0;
  // Snapping the origin down may push the far side out; then the next power of two holds it.
  for (;; root.side *= 2.0) {
    const double step = root.side / 256.0;
    bool holds = true;
    for (int axis = 0; axis < 3; ++axis) {
      root.origin[axis] = snapped_down(bounds.min[axis], step);
      holds = holds && bounds.max[axis] < root.origin[axis] + root.side;
    }
    if (holds) return root;
  }
}

}  // namespace orbweave
