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

std::vector<std::uint64_t> vertices_of(std::span<const Triangle64> triangles) {
  std::vector<std::uint64_t> vertices;
  vertices.reserve(3 * triangles.size());
  for (const Triangle64& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
  tbb::parallel_sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

/// The triangles at some vertices, asked for at once: the surface locks what it keeps per call.
class TrianglesAt {
 public:
  /// `vertices` ascend, and outlive the object.
  TrianglesAt(std::span<const std::uint64_t> vertices, const Surface& surface)
      : vertices_(vertices) {
    surface.triangles_at(vertices, triangles_, ends_);
  }
  std::span<const Triangle64> operator[](std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends_[i - 1];
    return std::span(triangles_).subspan(begin, ends_[i] - begin);
  }
  std::span<const Triangle64> of(std::uint64_t vertex) const {
    const auto at = std::lower_bound(vertices_.begin(), vertices_.end(), vertex);
    return (*this)[static_cast<std::size_t>(at - vertices_.begin())];
  }

 private:
  std::span<const std::uint64_t> vertices_;
  std::vector<Triangle64> triangles_;
  std::vector<std::size_t> ends_;  // of the triangles at each vertex
};

/// All triangles that hang together with the first one: those beside the ones found last, until
/// there are no more.
std::set<Triangle64> triangles_of_piece(const Triangle64& first, const Surface& surface) {
  std::set<Triangle64> seen = {first};
  std::vector<Triangle64> last = {first};
  while (!last.empty()) {
    const std::vector<std::uint64_t> vertices = vertices_of(last);
    const TrianglesAt around(vertices, surface);
    std::vector<Triangle64> next;
    for (const Triangle64& t : last)
      for (int k = 0; k < 3; ++k)
        for (const Triangle64& other : around.of(t[k]))
          if (share_edge(other, t[k], t[(k + 1) % 3]) && seen.insert(other).second)
            next.push_back(other);
    last = std::move(next);
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
  const std::vector<std::uint64_t> vertices = vertices_of(piece.triangles);
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

/// Vertices of removed triangles that no other triangle uses.
std::vector<std::uint64_t> freed_vertices(std::span<const Triangle64> removed,
                                          const Surface& surface) {
  constexpr std::size_t kGrain = 1024;  // vertices that one thread looks at
  std::vector<std::uint64_t> vertices = vertices_of(removed);
  std::vector<std::uint8_t> is_used(vertices.size(), 0);
  const auto is_left = [&](const Triangle64& t) {
    return !std::binary_search(removed.begin(), removed.end(), t);
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      const auto some = std::span(vertices).subspan(range.begin(), range.size());
                      const TrianglesAt around(some, surface);
                      for (std::size_t i = 0; i < some.size(); ++i)
                        is_used[range.begin() + i] =
                            std::any_of(around[i].begin(), around[i].end(), is_left) ? 1 : 0;
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
  // Read before threads ask for it: one that waits for another to read it cannot help.
  if (!small.empty()) surface.position(pieces[small.front()].first.front());
  constexpr std::size_t kHeld = 4096;  // pieces at a time
  std::vector<TakenPiece> taken(std::min(kHeld, small.size()));
  for (std::size_t begin = 0; begin < small.size(); begin += kHeld) {
    const std::size_t count = std::min(kHeld, small.size() - begin);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      taken[i] = take_piece(pieces[small[begin + i]].first, surface);
    });
    // In the order of the pieces: a sum of doubles depends on the order.
    for (std::size_t i = 0; i < count; ++i) {
      for (const double part : taken[i].areas) removed.area_left -= part;
      removed.triangles.insert(removed.triangles.end(), taken[i].triangles.begin(),
                               taken[i].triangles.end());
    }
  }
  taken = {};
  tbb::parallel_sort(removed.triangles.begin(), removed.triangles.end());
  removed.freed = freed_vertices(removed.triangles, surface);
  return removed;
}

}  // namespace orbweave
