#include "engine/holes/loops/neighborhood.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "io/sort_unique.h"

namespace orbweave {
namespace {

using Edge64 = std::array<std::uint64_t, 2>;

/// Numbers of vertices in the order in which they are reached. Vertices near one another have
/// numbers in the mesh near one another: they lie together here, too.
class ReachedNumbers {
 public:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  explicit ReachedNumbers(std::size_t expected) {
    resize(expected / 2);
    blocks_.reserve(expected / 8);
  }

  /// kNone where the vertex was not reached.
  std::uint32_t of(std::uint64_t vertex) const {
    const std::uint32_t block = slots_[slot_of(vertex / kBlock)].block;
    return block == kNone ? kNone : blocks_[block].numbers[vertex % kBlock];
  }

  /// `number`: how many vertices were reached before.
  void add(std::uint64_t vertex, std::uint32_t number) {
    Slot& slot = slots_[slot_of(vertex / kBlock)];
    if (slot.block == kNone) {
      slot = {vertex / kBlock, static_cast<std::uint32_t>(blocks_.size())};
      blocks_.emplace_back();
      blocks_.back().first = vertex - vertex % kBlock;
      blocks_.back().numbers.fill(kNone);
      blocks_.back().numbers[vertex % kBlock] = number;
      if (2 * blocks_.size() > slots_.size()) resize(2 * slots_.size());
    } else {
      blocks_[slot.block].numbers[vertex % kBlock] = number;
    }
  }

  /// Calls visit(vertex, number) for all that were reached, by ascending vertices.
  template <class Visit>
  void for_each_sorted(const Visit& visit) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order;  // the first vertex, which block
    order.reserve(blocks_.size());
    for (std::uint32_t i = 0; i < blocks_.size(); ++i) order.emplace_back(blocks_[i].first, i);
    std::sort(order.begin(), order.end());
    for (const auto& [first, i] : order)
      for (std::size_t k = 0; k < kBlock; ++k)
        if (blocks_[i].numbers[k] != kNone) visit(first + k, blocks_[i].numbers[k]);
  }

 private:
  static constexpr std::size_t kBlock = 16;  ///< vertices
  struct Block {
    std::uint64_t first = 0;
    std::array<std::uint32_t, kBlock> numbers{};
  };
  struct Slot {
    std::uint64_t key = 0;  ///< the block's first vertex by its size
    std::uint32_t block = kNone;
  };

  void resize(std::size_t least) {
    std::size_t size = 32;
    while (size < least) size *= 2;
    std::vector<Slot> before(size);
    before.swap(slots_);
    for (const Slot& slot : before)
      if (slot.block != kNone) slots_[slot_of(slot.key)] = slot;
  }

  /// Its own slot, or the free one where it would go.
  std::size_t slot_of(std::uint64_t key) const {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = static_cast<std::size_t>((key * kGolden) >> 32) & mask;
    while (slots_[slot].block != kNone && slots_[slot].key != key) slot = (slot + 1) & mask;
    return slot;
  }

  std::vector<Slot> slots_;
  std::vector<Block> blocks_;
};

/// A vertex, and its number in the order in which vertices are reached.
struct Reached {
  std::uint64_t vertex = 0;
  std::uint32_t number = 0;
  friend bool operator<(const Reached& a, const Reached& b) { return a.vertex < b.vertex; }
};

/// Rings of vertices around a loop, and the triangles at them. Each vertex is looked up once per
/// triangle at a ring; everything else goes by numbers in arrays.
class Rings {
 public:
  static constexpr std::uint32_t kNone = ReachedNumbers::kNone;

  Rings(const Surface& surface, const BoundaryLoop& loop)
      : surface_(surface), ring_(loop.vertices), numbers_(16 * loop.vertices.size()) {
    sort_unique(ring_);
    reserve(ring_.size());
    for (const std::uint64_t vertex : ring_) add(vertex, true);
  }

  const std::vector<std::uint64_t>& ring() const { return ring_; }

  /// Adds the triangles at the ring; the vertices beyond it become the next ring.
  void take_triangles() {
    beyond_.clear();
    at_ring_.clear();
    surface_.new_triangles_at(ring_, met_, at_ring_);
    for (const Triangle64& t : at_ring_) take(t);
    if (!surface_.is_at_hand()) std::sort(beyond_.begin(), beyond_.end());
  }

  /// What is taken out of the next ring is not reached, now or later. `is_in` of a position.
  template <class IsIn>
  void keep_of_next(const IsIn& is_in) {
    ring_.clear();
    for (const Reached& each : beyond_) ring_.push_back(each.vertex);
    places_.resize(ring_.size());
    surface_.positions(ring_, places_);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < beyond_.size(); ++i)
      if (is_in(places_[i])) beyond_[kept++] = beyond_[i];
    beyond_.resize(kept);
  }

  void go_on() {
    ring_.clear();
    for (const Reached& each : beyond_) {
      ring_.push_back(each.vertex);
      is_gathered_[each.number] = 1;
    }
  }

  std::uint32_t count() const { return static_cast<std::uint32_t>(is_gathered_.size()); }
  /// Calls visit(vertex, number) for all vertices that triangles have, by ascending vertices.
  template <class Visit>
  void for_each_sorted(const Visit& visit) {
    numbers_.for_each_sorted(visit);
  }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  std::uint32_t number_of(std::uint64_t vertex) const { return numbers_.of(vertex); }
  /// Whether a vertex was in a ring.
  bool is_gathered(std::uint32_t number) const { return is_gathered_[number] != 0; }

 private:
  /// As much as a hole of a few edges needs.
  void reserve(std::size_t ring) {
    constexpr std::size_t kVertices = 8, kTriangles = 12, kPerVertex = 6;
    is_gathered_.reserve(kVertices * ring);
    triangles_.reserve(kTriangles * ring);
    beyond_.reserve(2 * ring);
    at_ring_.reserve(2 * kPerVertex * ring);
  }

  std::uint32_t add(std::uint64_t vertex, bool is_gathered) {
    const std::uint32_t number = count();
    numbers_.add(vertex, number);
    is_gathered_.push_back(is_gathered ? 1 : 0);
    return number;
  }

  void take(const Triangle64& t) {
    Triangle numbers{};
    for (std::size_t k = 0; k < 3; ++k) {
      numbers[k] = numbers_.of(t[k]);
      if (numbers[k] != kNone) continue;
      numbers[k] = add(t[k], false);
      beyond_.push_back({t[k], numbers[k]});
    }
    triangles_.push_back(numbers);
  }

  const Surface& surface_;
  std::vector<std::uint64_t> ring_;  // sorted, unless the surface is at hand
  ReachedNumbers numbers_;
  std::vector<std::uint8_t> is_gathered_;  // per number
  std::vector<Triangle> triangles_;        // in numbers
  std::vector<Reached> beyond_;            // in the order of ring_
  std::vector<Triangle64> at_ring_;
  TriangleMarks met_;
  std::vector<Vec3> places_;
};

void walk_rings(const BoundaryLoop& loop, const NeighborhoodOptions& options, Rings& rings) {
  constexpr std::uint32_t kLeastRings = 2;
  const double limit = options.radius_factor * loop.radius;
  std::size_t gathered = 0;
  for (std::uint32_t depth = 0; !rings.ring().empty(); ++depth) {
    gathered += rings.ring().size();
    const bool is_last = options.max_rings > 0 && depth >= options.max_rings;
    if (is_last && !options.whole_fans) break;
    rings.take_triangles();
    if (is_last) break;
    if (depth >= kLeastRings && gathered > options.max_vertices) break;
    if (depth >= kLeastRings)
      rings.keep_of_next([&](Vec3 place) { return norm(place - loop.center) <= limit; });
    rings.go_on();
  }
}

/// What was reached, in the order of the mesh's numbers.
struct Sorted {
  std::vector<std::uint64_t> vertices;  ///< ascending; those that were not gathered among them
  std::vector<Triangle> triangles;      ///< in places among these, sorted
  std::vector<std::uint32_t> gathered;  ///< per vertex: its number among those gathered, or kNone
  std::vector<std::uint32_t> place_of;  ///< per number in the order reached
};

/// Triangles with one first vertex.
void sort_few(std::vector<Triangle>& triangles, std::size_t begin, std::size_t end) {
  constexpr std::size_t kFew = 16;
  if (end - begin > kFew) {
    std::sort(triangles.begin() + static_cast<std::ptrdiff_t>(begin),
              triangles.begin() + static_cast<std::ptrdiff_t>(end));
    return;
  }
  const auto is_before = [](const Triangle& a, const Triangle& b) {
    return a[1] != b[1] ? a[1] < b[1] : a[2] < b[2];
  };
  for (std::size_t i = begin + 1; i < end; ++i) {
    const Triangle t = triangles[i];
    std::size_t k = i;
    for (; k > begin && is_before(t, triangles[k - 1]); --k) triangles[k] = triangles[k - 1];
    triangles[k] = t;
  }
}

/// By their first vertices, few triangles at each; then these.
void sort_triangles(const std::vector<Triangle>& triangles, std::size_t vertices,
                    std::vector<Triangle>& sorted) {
  std::vector<std::uint32_t> next(vertices + 1, 0);
  for (const Triangle& t : triangles) ++next[t[0] + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  sorted.resize(triangles.size());
  for (const Triangle& t : triangles) sorted[next[t[0]]++] = t;
  // Each vertex's end is the next one's begin by now.
  std::uint32_t begin = 0;
  for (std::size_t v = 0; v < vertices; begin = next[v++]) sort_few(sorted, begin, next[v]);
}

Sorted sorted_by_vertices(Rings& rings) {
  Sorted result;
  result.place_of.resize(rings.count());
  result.vertices.reserve(rings.count());
  result.gathered.reserve(rings.count());
  std::uint32_t next = 0;
  rings.for_each_sorted([&](std::uint64_t vertex, std::uint32_t number) {
    result.place_of[number] = static_cast<std::uint32_t>(result.vertices.size());
    result.vertices.push_back(vertex);
    result.gathered.push_back(rings.is_gathered(number) ? next++ : Rings::kNone);
  });
  std::vector<Triangle> triangles = rings.triangles();
  for (Triangle& t : triangles)
    for (std::uint32_t& v : t) v = result.place_of[v];
  sort_triangles(triangles, rings.count(), result.triangles);
  return result;
}

/// Positions, and unit normals from all faces at each vertex, weighted by area.
void add_vertices(const Surface& surface, const Sorted& sorted, HoleProblem& problem) {
  std::vector<Vec3> positions(sorted.vertices.size());
  surface.positions(sorted.vertices, positions);
  std::vector<Vec3> normals(positions.size());
  for (const Triangle& t : sorted.triangles) {
    const Vec3 a = positions[t[0]];
    const Vec3 area = cross(positions[t[1]] - a, positions[t[2]] - a);
    for (const std::uint32_t v : t) normals[v] = normals[v] + area;
  }
  problem.positions.reserve(positions.size());
  problem.normals.reserve(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (sorted.gathered[v] == Rings::kNone) continue;
    problem.positions.push_back(positions[v]);
    problem.normals.push_back(normalized(normals[v]));
  }
}

/// The triangles between gathered vertices, and the edges between rim vertices that are in use.
void add_triangles(const Sorted& sorted, HoleProblem& problem) {
  std::vector<std::uint8_t> on_rim(problem.positions.size(), 0);
  for (const std::uint32_t v : problem.loop) on_rim[v] = 1;
  problem.sheet.reserve(sorted.triangles.size());
  for (const Triangle& in_places : sorted.triangles) {
    Triangle t{};
    std::array<bool, 3> is_on_rim{};
    bool is_gathered = true;
    for (std::size_t k = 0; k < 3; ++k) {
      t[k] = sorted.gathered[in_places[k]];
      is_gathered = is_gathered && t[k] != Rings::kNone;
      is_on_rim[k] = t[k] != Rings::kNone && on_rim[t[k]] != 0;
    }
    if (is_gathered) problem.sheet.push_back(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      if (is_on_rim[k] && is_on_rim[next])
        problem.forbidden.push_back({std::min(t[k], t[next]), std::max(t[k], t[next])});
    }
  }
}

/// The values of gathered vertices, asked for in the order that a surface wants.
struct ValuesAt {
  const Surface& surface;
  std::span<const std::uint64_t> vertices;

  std::vector<double> operator()(std::span<const std::uint32_t> wanted) const {
    std::vector<std::uint32_t> sorted(wanted.begin(), wanted.end());
    sort_unique(sorted);
    std::vector<std::uint64_t> in_mesh;
    in_mesh.reserve(sorted.size());
    for (const std::uint32_t v : sorted) in_mesh.push_back(vertices[v]);
    const std::vector<double> rows = surface.values(in_mesh);
    const std::size_t channels = surface.channels();
    std::vector<double> values;
    values.reserve(wanted.size() * channels);
    for (const std::uint32_t v : wanted) {
      const auto place = std::lower_bound(sorted.begin(), sorted.end(), v) - sorted.begin();
      const auto row = rows.begin() + place * static_cast<std::ptrdiff_t>(channels);
      values.insert(values.end(), row, row + static_cast<std::ptrdiff_t>(channels));
    }
    return values;
  }
};

}  // namespace

GatheredHole gather_hole(const Surface& surface, const BoundaryLoop& loop,
                         std::span<const Edge64> apart, const NeighborhoodOptions& options) {
  Rings rings(surface, loop);
  walk_rings(loop, options, rings);
  const Sorted sorted = sorted_by_vertices(rings);
  const auto number_of = [&](std::uint64_t vertex) {
    const std::uint32_t number = rings.number_of(vertex);
    return number == Rings::kNone ? Rings::kNone : sorted.gathered[sorted.place_of[number]];
  };
  GatheredHole gathered;
  HoleProblem& problem = gathered.problem;
  add_vertices(surface, sorted, problem);
  for (const std::uint64_t vertex : loop.vertices) problem.loop.push_back(number_of(vertex));
  std::vector<std::uint64_t> groups;
  for (const Edge64& known : apart) groups.push_back(known[1]);
  sort_unique(groups);
  for (const auto& [vertex, group] : apart) {
    const auto at = std::lower_bound(groups.begin(), groups.end(), group) - groups.begin();
    problem.apart.push_back({number_of(vertex), static_cast<std::uint32_t>(at)});
  }
  sort_unique(problem.apart);
  add_triangles(sorted, problem);
  sort_unique(problem.forbidden);
  for (std::size_t i = 0; i < sorted.vertices.size(); ++i)
    if (sorted.gathered[i] != Rings::kNone) gathered.vertices.push_back(sorted.vertices[i]);
  problem.channels = surface.channels();
  if (problem.channels > 0) problem.values_of = ValuesAt{surface, gathered.vertices};
  return gathered;
}

}  // namespace orbweave
