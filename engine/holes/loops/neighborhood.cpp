#include "engine/holes/loops/neighborhood.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace orbweave {
namespace {

using Edge64 = std::array<std::uint64_t, 2>;

template <class T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// Vertices reached, and the triangles at them.
struct Reached {
  std::vector<std::uint64_t> vertices;  // sorted
  std::vector<Triangle64> triangles;    // sorted by sort_triangles
};

/// Marks of vertices, by their numbers.
class Marks {
 public:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  explicit Marks(std::size_t expected) { resize(2 * expected); }

  /// kNone where the vertex has none.
  std::uint32_t of(std::uint64_t vertex) const { return slots_[slot_of(vertex)].mark; }

  void set(std::uint64_t vertex, std::uint32_t mark) {
    Slot& slot = slots_[slot_of(vertex)];
    const bool is_new = slot.mark == kNone;
    slot = {vertex, mark};
    if (is_new && 2 * ++used_ > slots_.size()) resize(2 * slots_.size());
  }

 private:
  struct Slot {
    std::uint64_t vertex = 0;
    std::uint32_t mark = kNone;
  };

  void resize(std::size_t least) {
    std::size_t size = 64;
    while (size < least) size *= 2;
    std::vector<Slot> before(size);
    before.swap(slots_);
    for (const Slot& slot : before)
      if (slot.mark != kNone) slots_[slot_of(slot.vertex)] = slot;
  }

  /// Its own slot, or the free one where it would go.
  std::size_t slot_of(std::uint64_t vertex) const {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = static_cast<std::size_t>((vertex * kGolden) >> 32) & mask;
    while (slots_[slot].mark != kNone && slots_[slot].vertex != vertex) slot = (slot + 1) & mask;
    return slot;
  }

  std::vector<Slot> slots_;
  std::size_t used_ = 0;
};

/// Rings of vertices around a loop, marked by their numbers.
class Rings {
 public:
  Rings(const Surface& surface, const BoundaryLoop& loop)
      : surface_(surface), ring_(loop.vertices), marks_(16 * loop.vertices.size()) {
    sort_unique(ring_);
    for (const std::uint64_t vertex : ring_) marks_.set(vertex, 0);
  }

  bool empty() const { return ring_.empty(); }
  const std::vector<std::uint64_t>& ring() const { return ring_; }

  /// Adds the triangles at the ring; returns the vertices beyond it, sorted.
  std::vector<std::uint64_t> take_triangles(std::vector<Triangle64>& triangles) {
    std::vector<std::uint64_t> beyond;
    at_ring_.clear();
    ends_.clear();
    surface_.triangles_at(ring_, at_ring_, ends_);
    std::size_t i = 0;
    for (std::size_t k = 0; k < ring_.size(); ++k) {
      for (; i < ends_[k]; ++i) {
        const Triangle64& t = at_ring_[i];
        if (was_seen(t, ring_[k])) continue;
        triangles.push_back(t);
        for (const std::uint64_t vertex : t) {
          if (marks_.of(vertex) != Marks::kNone) continue;
          marks_.set(vertex, kBeyond);
          beyond.push_back(vertex);
        }
      }
    }
    std::sort(beyond.begin(), beyond.end());
    return beyond;
  }

  /// What is not in the ring is not reached, now or later.
  void go_on_with(std::vector<std::uint64_t> ring) {
    ring_ = std::move(ring);
    ++depth_;
    for (const std::uint64_t vertex : ring_) marks_.set(vertex, depth_);
  }

 private:
  static constexpr std::uint32_t kBeyond = Marks::kNone - 1;

  /// At a vertex of a ring before, or at a smaller one of this ring.
  bool was_seen(const Triangle64& t, std::uint64_t vertex) const {
    return std::any_of(t.begin(), t.end(), [&](std::uint64_t other) {
      if (other == vertex) return false;
      const std::uint32_t mark = marks_.of(other);
      return mark < depth_ || (mark == depth_ && other < vertex);
    });
  }

  const Surface& surface_;
  std::vector<std::uint64_t> ring_;  // sorted
  Marks marks_;
  std::uint32_t depth_ = 0;
  std::vector<Triangle64> at_ring_;
  std::vector<std::size_t> ends_;
};

Reached walk_rings(const Surface& surface, const BoundaryLoop& loop,
                   const NeighborhoodOptions& options) {
  constexpr std::uint32_t kLeastRings = 2;
  Reached reached;
  const double limit = options.radius_factor * loop.radius;
  Rings rings(surface, loop);
  for (std::uint32_t depth = 0; !rings.empty(); ++depth) {
    const std::vector<std::uint64_t>& ring = rings.ring();
    reached.vertices.insert(reached.vertices.end(), ring.begin(), ring.end());
    const bool is_last = options.max_rings > 0 && depth >= options.max_rings;
    if (is_last && !options.whole_fans) break;
    std::vector<std::uint64_t> beyond = rings.take_triangles(reached.triangles);
    if (is_last) break;
    if (depth >= kLeastRings && reached.vertices.size() > options.max_vertices) break;
    if (depth >= kLeastRings) {
      std::vector<Vec3> places(beyond.size());
      surface.positions(beyond, places);
      std::size_t kept = 0;
      for (std::size_t i = 0; i < beyond.size(); ++i)
        if (norm(places[i] - loop.center) <= limit) beyond[kept++] = beyond[i];
      beyond.resize(kept);
    }
    rings.go_on_with(std::move(beyond));
  }
  std::sort(reached.vertices.begin(), reached.vertices.end());
  return reached;
}

/// Numbers of the gathered vertices.
class Numbers {
 public:
  static constexpr std::uint32_t kNone = Marks::kNone;

  explicit Numbers(std::span<const std::uint64_t> vertices) : marks_(vertices.size()) {
    for (std::uint32_t i = 0; i < vertices.size(); ++i) marks_.set(vertices[i], i);
  }

  /// kNone where the vertex was not gathered.
  std::uint32_t of(std::uint64_t vertex) const { return marks_.of(vertex); }

  Triangle of(const Triangle64& t) const { return {of(t[0]), of(t[1]), of(t[2])}; }

 private:
  Marks marks_;
};

/// By the places of their first vertices among those gathered, few triangles at each; then these.
void sort_triangles(const Numbers& numbers, Reached& reached) {
  const std::vector<std::uint64_t>& vertices = reached.vertices;
  // Odd places are vertices, even ones the gaps between them.
  const auto place_of = [&](std::uint64_t vertex) {
    const std::uint32_t number = numbers.of(vertex);
    if (number != Numbers::kNone) return std::size_t{2} * number + 1;
    const auto gap = std::lower_bound(vertices.begin(), vertices.end(), vertex) - vertices.begin();
    return 2 * static_cast<std::size_t>(gap);
  };
  std::vector<std::size_t> places(reached.triangles.size());
  std::vector<std::size_t> next(2 * vertices.size() + 2, 0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i] = place_of(reached.triangles[i][0]);
    ++next[places[i] + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<Triangle64> sorted(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) sorted[next[places[i]]++] = reached.triangles[i];
  // Each place's end is the next one's begin by now.
  std::size_t begin = 0;
  for (std::size_t place = 0; place + 1 < next.size(); begin = next[place++]) {
    if (next[place] - begin > 1)
      std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(begin),
                sorted.begin() + static_cast<std::ptrdiff_t>(next[place]));
  }
  reached.triangles = std::move(sorted);
}

bool is_gathered(const Triangle& t) {
  return t[0] != Numbers::kNone && t[1] != Numbers::kNone && t[2] != Numbers::kNone;
}

/// Where the vertices lie that triangles have but that were not gathered.
class OuterPlaces {
 public:
  OuterPlaces(const Surface& surface, const Reached& reached, std::span<const Triangle> triangles) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k)
        if (triangles[i][k] == Numbers::kNone) vertices_.push_back(reached.triangles[i][k]);
    }
    sort_unique(vertices_);
    places_.resize(vertices_.size());
    surface.positions(vertices_, places_);
  }
  Vec3 of(std::uint64_t vertex) const {
    return places_[std::lower_bound(vertices_.begin(), vertices_.end(), vertex) -
                   vertices_.begin()];
  }

 private:
  std::vector<std::uint64_t> vertices_;  // sorted
  std::vector<Vec3> places_;
};

/// Positions, and unit normals from all faces at each vertex, weighted by area.
void add_vertices(const Surface& surface, const Reached& reached,
                  std::span<const Triangle> triangles, HoleProblem& problem) {
  problem.positions.resize(reached.vertices.size());
  surface.positions(reached.vertices, problem.positions);
  problem.normals.resize(reached.vertices.size());
  const OuterPlaces outer(surface, reached, triangles);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const auto at = [&](int k) {
      return t[k] != Numbers::kNone ? problem.positions[t[k]] : outer.of(reached.triangles[i][k]);
    };
    const Vec3 a = at(0);
    const Vec3 area = cross(at(1) - a, at(2) - a);
    for (const std::uint32_t v : t)
      if (v != Numbers::kNone) problem.normals[v] = problem.normals[v] + area;
  }
  for (Vec3& normal : problem.normals) normal = normalized(normal);
}

/// Edges between rim vertices that are in use.
void add_used_edges(std::span<const Triangle> triangles, HoleProblem& problem) {
  std::vector<std::uint8_t> on_rim(problem.positions.size(), 0);
  for (const std::uint32_t v : problem.loop) on_rim[v] = 1;
  const auto is_on_rim = [&](std::uint32_t v) { return v != Numbers::kNone && on_rim[v] != 0; };
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (is_on_rim(a) && is_on_rim(b))
        problem.forbidden.push_back({std::min(a, b), std::max(a, b)});
    }
  }
}

}  // namespace

GatheredHole gather_hole(const Surface& surface, const BoundaryLoop& loop,
                         std::span<const Edge64> taken, const NeighborhoodOptions& options) {
  Reached reached = walk_rings(surface, loop, options);
  GatheredHole gathered;
  HoleProblem& problem = gathered.problem;
  const Numbers numbers(reached.vertices);
  sort_triangles(numbers, reached);
  std::vector<Triangle> triangles;
  triangles.reserve(reached.triangles.size());
  for (const Triangle64& t : reached.triangles) triangles.push_back(numbers.of(t));
  add_vertices(surface, reached, triangles, problem);
  for (const std::uint64_t vertex : loop.vertices) problem.loop.push_back(numbers.of(vertex));
  for (const Edge64& edge : taken)
    problem.forbidden.push_back({numbers.of(edge[0]), numbers.of(edge[1])});
  add_used_edges(triangles, problem);
  sort_unique(problem.forbidden);
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(problem.sheet), is_gathered);
  problem.channels = surface.channels();
  if (problem.channels > 0) problem.values = surface.values(reached.vertices);
  gathered.vertices = std::move(reached.vertices);
  return gathered;
}

}  // namespace orbweave
