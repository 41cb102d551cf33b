#include "engine/geometry/half_edges.h"

#include <algorithm>
#include <utility>

namespace orbweave {

std::uint32_t HalfEdges::first_of_fan(std::uint32_t h) const {
  for (std::uint32_t g = right_of(h), last = h;; last = g, g = right_of(g)) {
    if (g == kNone32) return last;
    if (g == h) return h;
  }
}

void HalfEdges::link(std::uint32_t h, std::uint32_t g) {
  if (h != kNone32) twin[h] = g;
  if (g != kNone32) twin[g] = h;
}

std::uint32_t HalfEdges::add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::uint32_t h = size();
  origin.insert(origin.end(), {a, b, c});
  twin.insert(twin.end(), {kNone32, kNone32, kNone32});
  from[a] = h;
  from[b] = h + 1;
  from[c] = h + 2;
  return h;
}

void HalfEdges::set(std::uint32_t triangle, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::uint32_t h = 3 * triangle;
  origin[h] = a;
  origin[h + 1] = b;
  origin[h + 2] = c;
  from[a] = h;
  from[b] = h + 1;
  from[c] = h + 2;
}

void HalfEdges::flip(std::uint32_t h) {
  const std::uint32_t g = twin[h];
  const std::uint32_t last_h = prev(h);
  const std::uint32_t last_g = prev(g);
  from[origin[h]] = next(g);
  from[origin[g]] = next(h);
  origin[h] = origin[last_g];
  origin[g] = origin[last_h];
  link(h, twin[last_g]);
  link(g, twin[last_h]);
  link(last_h, last_g);
}

std::uint32_t HalfEdges::split_triangle(std::uint32_t h, std::uint32_t vertex) {
  const std::uint32_t middle = next(h);
  const std::uint32_t last = prev(h);
  const std::uint32_t a = origin[h];
  const std::uint32_t second = add(origin[middle], origin[last], vertex);
  const std::uint32_t third = add(origin[last], a, vertex);
  link(second, twin[middle]);
  link(third, twin[last]);
  link(middle, second + 2);
  link(second + 1, third + 2);
  link(third + 1, last);
  origin[last] = vertex;
  from[a] = h;
  return second;
}

std::uint32_t HalfEdges::split_edge(std::uint32_t h, std::uint32_t vertex) {
  const std::uint32_t g = twin[h];
  const std::uint32_t middle = next(h);
  const std::uint32_t last = prev(g);
  const std::uint32_t b = origin[g];
  const std::uint32_t upper = add(vertex, b, origin[prev(h)]);
  const std::uint32_t lower = add(b, vertex, origin[last]);
  link(upper + 1, twin[middle]);
  link(lower + 2, twin[last]);
  link(upper, lower);
  link(upper + 2, middle);
  link(lower + 1, last);
  origin[middle] = vertex;
  origin[g] = vertex;
  return upper;
}

bool HalfEdges::assign(std::span<const std::array<std::uint32_t, 3>> triangles,
                       std::uint32_t vertices) {
  origin.clear();
  twin.clear();
  from.assign(vertices, kNone32);
  struct Edge {
    std::uint32_t low, high, h;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (const auto& t : triangles) {
    if (std::max({t[0], t[1], t[2]}) >= vertices) return false;
    const std::uint32_t h = add(t[0], t[1], t[2]);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back({low, high, h + k});
    }
  }
  const auto same = [](const Edge& a, const Edge& b) { return a.low == b.low && a.high == b.high; };
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::pair(a.low, a.high) != std::pair(b.low, b.high)
               ? std::pair(a.low, a.high) < std::pair(b.low, b.high)
               : a.h < b.h;
  });
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    if (!same(edges[i], edges[i + 1])) continue;
    if (origin[edges[i].h] == origin[edges[i + 1].h]) return false;
    if (i + 2 < edges.size() && same(edges[i], edges[i + 2])) return false;
    link(edges[i].h, edges[i + 1].h);
  }
  return true;
}

}  // namespace orbweave
