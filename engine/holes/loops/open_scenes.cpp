#include "engine/holes/loops/open_scenes.h"

namespace orbweave {

std::vector<std::uint8_t> pieces_of_scenes(std::span<const BoundaryLoop> loops,
                                           std::span<const Piece> pieces,
                                           std::span<const std::uint8_t> is_border) {
  // Small borders are crumpled rims as often as they are borders.
  constexpr double kWideBorder = 0.25;
  std::vector<std::uint8_t> is_scene(pieces.size(), 0);
  // How far the rims' normals look away from the middle of the piece, by length of rim.
  std::vector<double> outward(pieces.size(), 0.0);
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const BoundaryLoop& loop = loops[l];
    for (const std::uint64_t piece : loop.components) {
      const Box& box = pieces[piece].box;
      if (is_border[l] != 0 && 2.0 * loop.radius >= kWideBorder * box.diagonal())
        is_scene[piece] = 1;
      outward[piece] += loop.perimeter * dot(loop.mean_normal, loop.center - box.center());
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
