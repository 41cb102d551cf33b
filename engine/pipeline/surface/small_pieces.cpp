#include "engine/pipeline/surface/small_pieces.h"

#include <algorithm>
#include <set>

namespace orbweave {
namespace {

bool share_edge(const Triangle64& t, std::uint64_t tail, std::uint64_t head) {
  return (t[0] == head && t[1] == tail) || (t[1] == head && t[2] == tail) ||
         (t[2] == head && t[0] == tail);
}

/// All triangles that hang together with the first one.
std::set<Triangle64> triangles_of_piece(const Triangle64& first, const Surface& surface) {
  std::set<Triangle64> seen = {first};
  std::vector<Triangle64> next = {first};
  std::vector<Triangle64> around;
  while (!next.empty()) {
    const Triangle64 t = next.back();
    next.pop_back();
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t tail = t[k], head = t[(k + 1) % 3];
      around.clear();
      surface.triangles_at(tail, around);
      for (const Triangle64& other : around)
        if (share_edge(other, tail, head) && seen.insert(other).second) next.push_back(other);
    }
  }
  return seen;
}

double area_of(const Triangle64& t, const Surface& surface) {
  const Vec3 a = surface.position(t[0]);
  return 0.5 * norm(cross(surface.position(t[1]) - a, surface.position(t[2]) - a));
}

/// Vertices of removed triangles that no other triangle uses.
std::vector<std::uint64_t> freed_vertices(std::span<const Triangle64> removed,
                                          const Surface& surface) {
  std::vector<std::uint64_t> vertices;
  for (const Triangle64& t : removed) vertices.insert(vertices.end(), t.begin(), t.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Triangle64> around;
  std::erase_if(vertices, [&](std::uint64_t vertex) {
    around.clear();
    surface.triangles_at(vertex, around);
    return !std::all_of(around.begin(), around.end(), [&](const Triangle64& t) {
      return std::binary_search(removed.begin(), removed.end(), t);
    });
  });
  return vertices;
}

}  // namespace

std::vector<std::uint8_t> small_pieces(std::span<const ChunkPiece> pieces,
                                       std::uint64_t min_triangles) {
  std::vector<std::uint8_t> is_small;
  is_small.reserve(pieces.size());
  for (const ChunkPiece& piece : pieces)
    is_small.push_back(piece.triangles < min_triangles ? 1 : 0);
  return is_small;
}

RemovedPieces find_removed(std::span<const ChunkPiece> pieces,
                           std::span<const std::uint8_t> is_removed, const Surface& surface,
                           double area) {
  RemovedPieces removed;
  removed.area_left = area;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    if (is_removed[p] == 0) continue;
    const std::set<Triangle64> triangles = triangles_of_piece(pieces[p].first, surface);
    for (const Triangle64& t : triangles) removed.area_left -= area_of(t, surface);
    removed.triangles.insert(removed.triangles.end(), triangles.begin(), triangles.end());
  }
  std::sort(removed.triangles.begin(), removed.triangles.end());
  removed.freed = freed_vertices(removed.triangles, surface);
  return removed;
}

}  // namespace orbweave
