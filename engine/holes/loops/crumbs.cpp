#include "engine/holes/loops/crumbs.h"

#include <algorithm>

#include "engine/geometry/disjoint_sets.h"
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

/// Pieces that share loops, because they touch in a vertex, are one.
DisjointSets pieces_that_touch(std::span<const BoundaryLoop> loops, std::size_t pieces) {
  DisjointSets touching(pieces);
  for (const BoundaryLoop& loop : loops)
    for (const std::uint64_t piece : loop.components)
      touching.unite(static_cast<std::uint32_t>(loop.components.front()),
                     static_cast<std::uint32_t>(piece));
  return touching;
}

/// By piece: of all that touch it, together.
std::vector<Piece> whole_pieces(std::span<const Piece> pieces, DisjointSets& touching) {
  std::vector<Piece> whole(pieces.size());
  for (std::uint32_t p = 0; p < pieces.size(); ++p) {
    Piece& all = whole[touching.find(p)];
    all.triangles += pieces[p].triangles;
    all.box.extend(pieces[p].box.min);
    all.box.extend(pieces[p].box.max);
  }
  return whole;
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
  DisjointSets touching = pieces_that_touch(loops, pieces.size());
  const std::vector<Piece> whole = whole_pieces(pieces, touching);
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (is_border[l] == 0) continue;
    const std::uint32_t root =
        touching.find(static_cast<std::uint32_t>(loops[l].components.front()));
    const Piece& piece = whole[root];
    if (piece.triangles < most &&
        lies_within(piece.box, largest->box, kNear * loop_spacing(loops[l])))
      crumbs[root] = 1;
  }
  for (std::uint32_t p = 0; p < pieces.size(); ++p) crumbs[p] = crumbs[touching.find(p)];
  return crumbs;
}

void keep_pieces(std::span<const BoundaryLoop> loops, std::span<const std::uint64_t> kept,
                 std::span<std::uint8_t> crumbs) {
  DisjointSets touching = pieces_that_touch(loops, crumbs.size());
  for (const std::uint64_t piece : kept)
    crumbs[touching.find(static_cast<std::uint32_t>(piece))] = 0;
  for (std::uint32_t p = 0; p < crumbs.size(); ++p)
    if (crumbs[touching.find(p)] == 0) crumbs[p] = 0;
}

}  // namespace orbweave
