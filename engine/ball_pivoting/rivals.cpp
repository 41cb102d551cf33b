#include "engine/ball_pivoting/rivals.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <limits>
#include <tuple>

namespace orbweave {
namespace {

struct DirectedEdge {
  std::uint32_t tail = 0;
  std::uint32_t head = 0;
  std::uint32_t triangle = 0;
  friend auto operator<=>(const DirectedEdge&, const DirectedEdge&) = default;
};

/// Order of two vertices by their coordinates: the same wherever coordinates are counted from.
bool lies_before(const RivalContext& context, std::uint32_t a, std::uint32_t b) {
  const Vec3 p = context.local[a], q = context.local[b];
  return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
}

/// The triangle, turned so that the vertex of the smallest coordinates is the first.
Triangle from_first_position(const RivalContext& context, Triangle t) {
  while (lies_before(context, t[1], t[0]) || lies_before(context, t[2], t[0]))
    t = {t[1], t[2], t[0]};
  return t;
}

/// A total order of triangles that depends on their coordinates alone.
bool comes_first(const RivalContext& context, const Triangle& a, const Triangle& b) {
  const Triangle p = from_first_position(context, a), q = from_first_position(context, b);
  for (int k = 0; k < 3; ++k) {
    if (lies_before(context, p[k], q[k])) return true;
    if (lies_before(context, q[k], p[k])) return false;
  }
  return false;
}

std::vector<DirectedEdge> sorted_edges(std::span<const Triangle> triangles) {
  std::vector<DirectedEdge> edges;
  edges.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      edges.push_back({triangles[t][k], triangles[t][(k + 1) % 3], t});
    }
  }
  tbb::parallel_sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

double agreement(const RivalContext& context, const Triangle& t) {
  const Triangle from = from_first_position(context, t);
  const Vec3 a = context.local[from[0]];
  const Vec3 normal = normalized(cross(context.local[from[1]] - a, context.local[from[2]] - a));
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t vertex : t) {
    least = std::min(least, dot(normal, normalized(context.normals[vertex])));
  }
  return least;
}

std::size_t best_rival(const RivalContext& context, std::span<const Triangle> rivals) {
  std::size_t best = 0;
  double best_score = agreement(context, rivals[0]);
  for (std::size_t r = 1; r < rivals.size(); ++r) {
    const double score = agreement(context, rivals[r]);
    if (score > best_score ||
        (score == best_score && comes_first(context, rivals[r], rivals[best]))) {
      best = r;
      best_score = score;
    }
  }
  return best;
}

std::vector<std::uint8_t> find_losers(const RivalContext& context,
                                      std::span<const Triangle> triangles) {
  std::vector<std::uint8_t> lost(triangles.size(), 0);
  const std::vector<DirectedEdge> edges = sorted_edges(triangles);
  std::vector<Triangle> rivals;
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    last = first + 1;
    while (last < edges.size() && edges[last].tail == edges[first].tail &&
           edges[last].head == edges[first].head) {
      ++last;
    }
    if (last - first == 1) continue;
    rivals.clear();
    for (std::size_t e = first; e < last; ++e) rivals.push_back(triangles[edges[e].triangle]);
    const std::size_t best = best_rival(context, rivals);
    for (std::size_t e = first; e < last; ++e) {
      if (e - first != best) lost[edges[e].triangle] = 1;
    }
  }
  return lost;
}

}  // namespace orbweave
