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
  for (const auto& t : triangles) {
    if (std::max({t[0], t[1], t[2]}) >= vertices) return false;
    add(t[0], t[1], t[2]);
  }
  const auto low_of = [&](std::uint32_t h) { return std::min(origin[h], target(h)); };
  // Edges by their smaller end, in few of which there is anything to sort.
  std::vector<std::uint32_t> first(vertices + std::size_t{1}, 0);
  for (std::uint32_t h = 0; h < size(); ++h) ++first[low_of(h) + 1];
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  struct Edge {
    std::uint32_t high, h;
    auto operator<=>(const Edge&) const = default;
  };
  std::vector<Edge> edges(size());
  std::vector<std::uint32_t> place(first.begin(), first.end() - 1);
  for (std::uint32_t h = 0; h < size(); ++h)
    edges[place[low_of(h)]++] = {std::max(origin[h], target(h)), h};
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const std::span<Edge> at = std::span(edges).subspan(first[v], first[v + 1] - first[v]);
    std::sort(at.begin(), at.end());
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
      if (at[i].high != at[i + 1].high) continue;
      if (origin[at[i].h] == origin[at[i + 1].h]) return false;
      if (i + 2 < at.size() && at[i].high == at[i + 2].high) return false;
      link(at[i].h, at[i + 1].h);
    }
  }
  return true;
}

void HalfEdges::drop_removed() {
  std::vector<std::uint32_t> number(size() / 3, kNone32);
  std::uint32_t kept = 0;
  for (std::uint32_t t = 0; t < number.size(); ++t)
    if (origin[3 * t] != kNone32) number[t] = kept++;
  std::fill(from.begin(), from.end(), kNone32);
  for (std::uint32_t h = 0; h < size(); ++h) {
    if (number[h / 3] == kNone32) continue;
    const std::uint32_t to = 3 * number[h / 3] + h % 3;
    origin[to] = origin[h];
    twin[to] = twin[h] == kNone32 ? kNone32 : 3 * number[twin[h] / 3] + twin[h] % 3;
    from[origin[to]] = to;
  }
  origin.resize(std::size_t{3} * kept);
  twin.resize(std::size_t{3} * kept);
}

}  // namespace orbweave
