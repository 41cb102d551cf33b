#include "engine/holes/loops/open_scenes.h"

namespace orbweave {
namespace {

/// How far a rim at a side of the piece's box looks out of the box; 0 where it lies inside, as one
/// on the inner side of a ring does, which says nothing.
double outlook(const BoundaryLoop& loop, const Box& box) {
  constexpr double kAtSide = 0.1;  // of the extent
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double near = kAtSide * (box.max[axis] - box.min[axis]);
    if (box.max[axis] - loop.center[axis] <= near) sum += loop.mean_normal[axis];
    if (loop.center[axis] - box.min[axis] <= near) sum -= loop.mean_normal[axis];
  }
  return sum;
}

}  // namespace

std::vector<std::uint8_t> pieces_of_scenes(std::span<const BoundaryLoop> loops,
                                           std::span<const Piece> pieces,
                                           std::span<const std::uint8_t> is_border) {
  // Small borders are crumpled rims as often as they are borders.
  constexpr double kWideBorder = 0.25;
  std::vector<std::uint8_t> is_scene(pieces.size(), 0);
  std::vector<double> outward(pieces.size(), 0.0);  // by length of rim
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const BoundaryLoop& loop = loops[l];
    for (const std::uint64_t piece : loop.components) {
      const Box& box = pieces[piece].box;
      if (is_border[l] != 0 && 2.0 * loop.radius >= kWideBorder * box.diagonal())
        is_scene[piece] = 1;
      outward[piece] += loop.perimeter * outlook(loop, box);
    }
  }
  for (std::size_t piece = 0; piece < pieces.size(); ++piece)
    if (outward[piece] < 0.0) is_scene[piece] = 1;
  return is_scene;
}

double loop_width(const BoundaryLoop& loop) {
  return loop.perimeter > 0.0 ? 4.0 * norm(loop.area_vector) / loop.perimeter : 0.0;
}

double loop_spacing(const BoundaryLoop& loop) {
  return loop.perimeter / static_cast<double>(loop.vertices.size());
}

}  // namespace orbweave
