#include "engine/pipeline/surface/small_pieces.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

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

/// A piece that is removed.
struct TakenPiece {
  std::vector<Triangle64> triangles;
  std::vector<double> areas;  ///< of the triangles
};

TakenPiece take_piece(const Triangle64& first, const Surface& surface) {
  const std::set<Triangle64> triangles = triangles_of_piece(first, surface);
  TakenPiece piece{{triangles.begin(), triangles.end()}, {}};
  std::vector<std::uint64_t> vertices;
  for (const Triangle64& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Vec3> positions(vertices.size());
  surface.positions(vertices, positions);
  const auto position = [&](std::uint64_t vertex) {
    return positions[std::lower_bound(vertices.begin(), vertices.end(), vertex) - vertices.begin()];
  };
  for (const Triangle64& t : triangles) {
    const Vec3 a = position(t[0]);
    piece.areas.push_back(0.5 * norm(cross(position(t[1]) - a, position(t[2]) - a)));
  }
  return piece;
}

/// Vertices that one thread looks at.
constexpr std::size_t kGrain = 256;

/// Vertices of removed triangles that no other triangle uses.
std::vector<std::uint64_t> freed_vertices(std::span<const Triangle64> removed,
                                          const Surface& surface) {
  std::vector<std::uint64_t> vertices;
  for (const Triangle64& t : removed) vertices.insert(vertices.end(), t.begin(), t.end());
  tbb::parallel_sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<std::uint8_t> is_used(vertices.size(), 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      std::vector<Triangle64> around;
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        around.clear();
                        surface.triangles_at(vertices[i], around);
                        is_used[i] =
                            !std::all_of(around.begin(), around.end(), [&](const Triangle64& t) {
                              return std::binary_search(removed.begin(), removed.end(), t);
                            });
                      }
                    });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (is_used[i] == 0) vertices[kept++] = vertices[i];
  vertices.resize(kept);
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
  std::vector<std::size_t> small;
  for (std::size_t p = 0; p < pieces.size(); ++p)
    if (is_removed[p] != 0) small.push_back(p);
  std::vector<TakenPiece> taken(small.size());
  tbb::parallel_for(std::size_t{0}, small.size(),
                    [&](std::size_t i) { taken[i] = take_piece(pieces[small[i]].first, surface); });
  // In the order of the pieces: a sum of doubles depends on the order.
  for (const TakenPiece& piece : taken) {
    for (const double part : piece.areas) removed.area_left -= part;
    removed.triangles.insert(removed.triangles.end(), piece.triangles.begin(),
                             piece.triangles.end());
  }
  taken = {};
  tbb::parallel_sort(removed.triangles.begin(), removed.triangles.end());
  removed.freed = freed_vertices(removed.triangles, surface);
  return removed;
}

}  // namespace orbweave
