#include "engine/holes/loops/crumbs.h"

#include <algorithm>

#include "engine/holes/loops/open_scenes.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kShare = 500;
constexpr std::uint64_t kMostTriangles = 1000;
/// A sheet this far from the object's box is another object. Spacings.
constexpr double kNear = 12.0;

bool lies_within(const Box& box, const Box& other, double distance) {
  for (int axis = 0; axis < 3; ++axis) {
    if (box.min[axis] < other.min[axis] - distance) return false;
    if (box.max[axis] > other.max[axis] + distance) return false;
  }
  return true;
}

}  // namespace

std::vector<std::uint8_t> find_crumbs(std::span<const BoundaryLoop> loops,
                                      std::span<const Piece> pieces,
                                      std::span<const std::uint8_t> is_border) {
  std::vector<std::uint8_t> crumbs(pieces.size(), 0);
  const auto largest =
      std::max_element(pieces.begin(), pieces.end(),
                       [](const Piece& a, const Piece& b) { return a.triangles < b.triangles; });
  if (largest == pieces.end()) return crumbs;
  const std::uint64_t most = std::min(kMostTriangles, largest->triangles / kShare);
  const auto object = static_cast<std::size_t>(largest - pieces.begin());
  if (most == 0 || pieces_of_scenes(loops, pieces, is_border)[object] != 0) return crumbs;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (is_border[l] == 0 || loops[l].components.size() != 1) continue;
    const Piece& piece = pieces[loops[l].components.front()];
    if (piece.triangles < most &&
        lies_within(piece.box, largest->box, kNear * loop_spacing(loops[l])))
      crumbs[loops[l].components.front()] = 1;
  }
  for (const BoundaryLoop& loop : loops)
    if (loop.components.size() > 1)
      for (const std::uint64_t piece : loop.components) crumbs[piece] = 0;
  return crumbs;
}

}  // namespace orbweave
