#include "engine/voronoi/tight_cocone.h"

#include <algorithm>
#include <array>
#include <queue>
#include <tuple>
#include <utility>

#include "engine/voronoi/manifold_edges.h"
#include "engine/voronoi/umbrellas.h"

namespace orbweave::voronoi {
namespace {

std::size_t at(int place) { return static_cast<std::size_t>(place); }

/// The sides of the umbrellas at all good points, in the places of the stars.
struct PointSides {
  std::vector<std::uint8_t> good;   ///< well sampled, with an umbrella
  std::vector<UmbrellaSide> sides;  ///< per place of the stars

  std::span<const UmbrellaSide> of(const Stars& stars, std::uint32_t p) const {
    return std::span(sides).subspan(stars.begin[p], stars.of(p).size());
  }
};

/// What the centres of the tetrahedra tell of the umbrellas at their points. Where no centre lies
/// in the cocone of a point, the edges of its Voronoi cell in the cocone are those between centres
/// above and below, and the centres on either side hang together: the cell is convex. So the
/// point has an umbrella exactly where all facets that these edges are dual to are flagged.
class UmbrellasByCenters {
 public:
  UmbrellasByCenters(const Tetrahedra& tetrahedra, std::span<const CenterSides> sides,
                     const CoconeEdges& edges, const FacetFlags& cocone, std::size_t points)
      : sides_(sides), known_(points, 0) {
    for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
      const auto& vertices = tetrahedra.vertices[c];
      for (int k = 0; k < 4; ++k)
        if (vertices[at(k)] != kInfinite) known_[vertices[at(k)]] |= side_of(c, k);
      for (int place = 0; place < 4 && edges[c] != 0; ++place) {
        const unsigned passing = (static_cast<unsigned>(edges[c]) >> (4 * place)) & 15U;
        if (passing == 0 || cocone.has({c, place})) continue;
        for (int k = 0; k < 4; ++k)
          if (((passing >> k) & 1U) != 0) known_[vertices[at(k)]] |= kBroken;
      }
    }
  }

  bool knows(std::uint32_t p) const { return (known_[p] & kInside) == 0; }
  bool separate(std::uint32_t p) const { return known_[p] == (kAbove | kBelow); }
  /// At a point that has an umbrella.
  UmbrellaSide side(std::uint32_t cell, int place) const {
    return sides_[cell].is_above(place) ? UmbrellaSide::kAbove : UmbrellaSide::kBelow;
  }

 private:
  /// Some centre is above, below, in the cocone; a facet between above and below is not flagged.
  static constexpr std::uint8_t kAbove = 1, kBelow = 2, kInside = 4, kBroken = 8;

  std::uint8_t side_of(std::uint32_t cell, int place) const {
    if (sides_[cell].is_above(place)) return kAbove;
    return sides_[cell].is_below(place) ? kBelow : kInside;
  }

  std::span<const CenterSides> sides_;
  std::vector<std::uint8_t> known_;
};

/// The sides at good points that the centres tell of. Stars have their tetrahedra in ascending
/// order: what is next in each of them is known without a search.
void add_sides_by_centers(const Tetrahedra& tetrahedra, const Stars& stars,
                          const UmbrellasByCenters& by_centers, PointSides& found) {
  std::vector<std::uint32_t> next(stars.begin.begin(), stars.begin.end());
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t p = tetrahedra.vertices[c][at(k)];
      if (p == kInfinite) continue;
      const std::uint32_t slot = next[p]++;
      if (found.good[p] != 0 && by_centers.knows(p)) found.sides[slot] = by_centers.side(c, k);
    }
  }
}

PointSides find_sides(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                      const Stars& stars, const Poles& poles, const UmbrellasByCenters& by_centers,
                      const FacetFlags& cocone, std::span<const std::uint8_t> flat,
                      const StopToken* stop) {
  PointSides found;
  found.good.assign(points.size(), 0);
  found.sides.assign(stars.cells.size(), UmbrellaSide::kNeither);
  StarFinder finder(tetrahedra, points.size());
  Umbrellas umbrellas(points, tetrahedra, finder, poles.normals, cocone);
  for (std::uint32_t p = 0; p < points.size(); ++p) {
    if (p % kStopBlock == 0) check_stop(stop);
    if (flat[p] == 0) continue;
    if (by_centers.knows(p)) {
      found.good[p] = by_centers.separate(p) ? 1 : 0;
      continue;
    }
    if (!umbrellas.separate(p)) continue;
    found.good[p] = 1;
    const auto sides = umbrellas.sides();
    std::copy(sides.begin(), sides.end(),
              found.sides.begin() + static_cast<std::ptrdiff_t>(stars.begin[p]));
  }
  add_sides_by_centers(tetrahedra, stars, by_centers, found);
  return found;
}

/// Votes of points on their tetrahedra: above 0, outside.
class Marks {
 public:
  Marks(const Tetrahedra& tetrahedra, const Stars& stars, const PointSides& sides)
      : tetrahedra_(tetrahedra),
        stars_(stars),
        sides_(sides),
        waits_(sides.good),
        votes_(tetrahedra.size(), 0) {
    for (std::uint32_t c = 0; c < tetrahedra.size(); ++c)
      if (!tetrahedra.is_finite(c)) votes_[c] = kAtInfinity;
  }

  std::vector<std::int8_t> take(const StopToken* stop) {
    for (std::uint32_t p = 0; p < waits_.size(); ++p)
      if (waits_[p] != 0 && lean(p) != 0) queue_.push_back(p);
    spread(stop);
    // What tetrahedra at infinity say nothing of: one point takes what is above it for outside.
    for (std::uint32_t p = 0; p < waits_.size(); ++p) {
      if (waits_[p] == 0) continue;
      vote(p, UmbrellaSide::kAbove);
      spread(stop);
    }
    return std::move(votes_);
  }

 private:
  static constexpr std::int8_t kAtInfinity = 100;
  static constexpr std::uint8_t kWaits = 1, kQueued = 2;

  /// Above 0: what is known says that what is above p is outside.
  int lean(std::uint32_t p) const {
    int sum = 0;
    const auto star = stars_.of(p);
    const auto sides = sides_.of(stars_, p);
    for (std::size_t i = 0; i < star.size(); ++i) {
      const int vote = std::clamp<int>(votes_[star[i]], -1, 1);
      sum += sides[i] == UmbrellaSide::kAbove ? vote : sides[i] == UmbrellaSide::kBelow ? -vote : 0;
    }
    return sum;
  }

  void vote(std::uint32_t p, UmbrellaSide outside) {
    waits_[p] = 0;
    const auto star = stars_.of(p);
    const auto sides = sides_.of(stars_, p);
    for (std::size_t i = 0; i < star.size(); ++i) {
      const std::uint32_t cell = star[i];
      if (sides[i] == UmbrellaSide::kNeither) continue;
      if (votes_[cell] != kAtInfinity)
        votes_[cell] = static_cast<std::int8_t>(votes_[cell] + (sides[i] == outside ? 1 : -1));
    }
    const std::size_t before = queue_.size();
    for (const std::uint32_t cell : star)
      for (const std::uint32_t q : tetrahedra_.vertices[cell])
        if (q != kInfinite && waits_[q] == kWaits) {
          waits_[q] = kQueued;
          queue_.push_back(q);
        }
    std::sort(queue_.begin() + static_cast<std::ptrdiff_t>(before), queue_.end());
  }

  /// Breadth first. A point that nothing is known at waits for its next neighbour.
  void spread(const StopToken* stop) {
    for (std::size_t i = 0; i < queue_.size(); ++i) {
      if (i % kStopBlock == 0) check_stop(stop);
      const std::uint32_t p = queue_[i];
      if (waits_[p] == 0) continue;
      const int sum = lean(p);
      waits_[p] = kWaits;
      if (sum != 0) vote(p, sum > 0 ? UmbrellaSide::kAbove : UmbrellaSide::kBelow);
    }
    queue_.clear();
  }

  const Tetrahedra& tetrahedra_;
  const Stars& stars_;
  const PointSides& sides_;
  std::vector<std::uint8_t> waits_;  // a good point that has not voted; kQueued: and is queued
  std::vector<std::int8_t> votes_;
  std::vector<std::uint32_t> queue_;
};

using CellKey = std::array<std::uint32_t, 4>;

/// Which tetrahedra stay.
class Peeling {
 public:
  Peeling(const Tetrahedra& tetrahedra, const Stars& stars, std::span<const std::int8_t> votes,
          std::span<const std::uint8_t> marked)
      : tetrahedra_(tetrahedra), votes_(votes), marked_(marked), stays_(tetrahedra.size(), 1) {
    left_.resize(stars.begin.size() - 1);
    for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
      if (is_out(c)) stays_[c] = 0;
      if (stays_[c] == 0) continue;
      for (const std::uint32_t v : tetrahedra.vertices[c]) ++left_[v];
    }
  }

  std::vector<std::uint8_t> run(const StopToken* stop) {
    for (std::uint32_t c = 0; c < tetrahedra_.size(); ++c)
      if (stays_[c] == 0) reach_from(c);
    for (std::size_t n = 0; !queue_.empty(); ++n) {
      if (n % kStopBlock == 0) check_stop(stop);
      const std::uint32_t cell = queue_.top().cell;
      queue_.pop();
      if (stays_[cell] == 0 || is_last_of_a_point(cell)) continue;
      stays_[cell] = 0;
      for (const std::uint32_t v : tetrahedra_.vertices[cell]) --left_[v];
      reach_from(cell);
    }
    return std::move(stays_);
  }

 private:
  struct Reached {
    double radius = 0.0;
    CellKey key{};
    std::uint32_t cell = 0;
    friend bool operator<(const Reached& a, const Reached& b) {
      return std::tie(a.radius, b.key) < std::tie(b.radius, a.key);
    }
  };

  bool is_out(std::uint32_t c) const {
    return !tetrahedra_.is_finite(c) || (marked_[c] != 0 && votes_[c] > 0);
  }

  bool is_last_of_a_point(std::uint32_t cell) const {
    const auto& vertices = tetrahedra_.vertices[cell];
    return std::any_of(vertices.begin(), vertices.end(),
                       [&](std::uint32_t v) { return left_[v] == 1; });
  }

  void reach_from(std::uint32_t cell) {
    for (const std::uint32_t next : tetrahedra_.neighbors[cell]) {
      if (stays_[next] == 0 || marked_[next] != 0) continue;
      CellKey key = tetrahedra_.vertices[next];
      std::sort(key.begin(), key.end());
      queue_.push({tetrahedra_.radii[next], key, next});
    }
  }

  const Tetrahedra& tetrahedra_;
  std::span<const std::int8_t> votes_;
  std::span<const std::uint8_t> marked_;
  std::vector<std::uint8_t> stays_;
  std::vector<std::uint32_t> left_;  // tetrahedra of a point that stay
  std::priority_queue<Reached> queue_;
};

/// The facets between tetrahedra that stay and those that do not, seen from outside.
std::vector<FacetSide> boundary_sides(const Tetrahedra& tetrahedra,
                                      std::span<const std::uint8_t> stays) {
  std::vector<FacetSide> sides;
  sides.reserve(tetrahedra.size() / 3);  // scans have fewer
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (stays[c] != 0) continue;
    for (int place = 0; place < 4; ++place)
      if (stays[tetrahedra.neighbors[c][at(place)]] != 0) sides.push_back({c, place});
  }
  return sides;
}

std::vector<Triangle> triangles_of(const Tetrahedra& tetrahedra, std::span<const FacetSide> sides) {
  std::vector<Triangle> triangles;
  triangles.reserve(sides.size());
  for (const FacetSide side : sides)
    triangles.push_back(smallest_first(corners_of(tetrahedra, side)));
  return triangles;
}

/// Tetrahedra around an edge that are outside, between two facets of the surface.
struct Wedge {
  std::vector<std::uint32_t> cells;
  double largest_radius = 0.0;
  bool is_at_infinity = false;
};

/// Closes edges of more than two triangles.
class EdgeRepair {
 public:
  EdgeRepair(const Tetrahedra& tetrahedra, std::vector<std::uint8_t>& stays)
      : tetrahedra_(tetrahedra), stays_(stays) {}

  void run(const StopToken* stop) {
    for (std::vector<CellEdge> crowded = all_crowded(); !crowded.empty();
         crowded = crowded_after_changes()) {
      check_stop(stop);
      changed_.clear();
      for (const CellEdge& edge : crowded)
        repair(edge.cell, tetrahedra_.place_of_vertex(edge.cell, edge.a),
               tetrahedra_.place_of_vertex(edge.cell, edge.b));
    }
  }

 private:
  /// An edge, with one of its tetrahedra.
  struct CellEdge {
    std::uint32_t a = 0, b = 0;  ///< ascending
    std::uint32_t cell = 0;
  };

  std::vector<CellEdge> all_crowded() const {
    const std::vector<FacetSide> sides = boundary_sides(tetrahedra_, stays_);
    std::vector<CellEdge> crowded;
    for (const MeshEdge& edge : crowded_edges(triangles_of(tetrahedra_, sides)))
      crowded.push_back({edge.a, edge.b, sides[edge.triangle].cell});
    return crowded;
  }

  /// Only edges of tetrahedra that were put back can have become crowded, or still be.
  std::vector<CellEdge> crowded_after_changes() const {
    std::vector<CellEdge> edges;
    for (const std::uint32_t cell : changed_) {
      const auto& v = tetrahedra_.vertices[cell];
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j)
          edges.push_back({std::min(v[i], v[j]), std::max(v[i], v[j]), cell});
    }
    const auto ends = [](const CellEdge& edge) { return std::tie(edge.a, edge.b); };
    std::sort(edges.begin(), edges.end(),
              [&](const CellEdge& x, const CellEdge& y) { return ends(x) < ends(y); });
    edges.erase(
        std::unique(edges.begin(), edges.end(),
                    [&](const CellEdge& x, const CellEdge& y) { return ends(x) == ends(y); }),
        edges.end());
    std::erase_if(edges, [&](const CellEdge& edge) { return !is_crowded(edge); });
    return edges;
  }

  bool is_crowded(const CellEdge& edge) const {
    int triangles = 0;
    std::uint32_t around = edge.cell;
    do {
      const std::uint32_t next = next_around_edge(around, edge.a, edge.b);
      triangles += stays_[around] != stays_[next] ? 1 : 0;
      around = next;
    } while (around != edge.cell);
    return triangles > 2;
  }

  void repair(std::uint32_t cell, int i, int j) {
    wedges_.clear();
    const std::uint32_t a = tetrahedra_.vertices[cell][at(i)];
    const std::uint32_t b = tetrahedra_.vertices[cell][at(j)];
    // A wedge is taken from its first tetrahedron on: the way begins inside the surface.
    std::uint32_t first = cell;
    while (stays_[first] == 0) first = next_around_edge(first, a, b);
    bool was_outside = false;
    std::uint32_t around = first;
    do {
      const bool is_outside = stays_[around] == 0;
      if (is_outside && !was_outside) wedges_.emplace_back();
      if (is_outside) add(around, wedges_.back());
      was_outside = is_outside;
      around = next_around_edge(around, a, b);
    } while (around != first);
    if (wedges_.size() > 1) close_all_but_widest();
  }

  std::uint32_t next_around_edge(std::uint32_t cell, std::uint32_t a, std::uint32_t b) const {
    const int k =
        next_place(tetrahedra_.place_of_vertex(cell, a), tetrahedra_.place_of_vertex(cell, b));
    return tetrahedra_.neighbors[cell][at(k)];
  }

  void add(std::uint32_t cell, Wedge& wedge) const {
    wedge.cells.push_back(cell);
    if (tetrahedra_.is_finite(cell))
      wedge.largest_radius = std::max(wedge.largest_radius, tetrahedra_.radii[cell]);
    else
      wedge.is_at_infinity = true;
  }

  void close_all_but_widest() {
    const auto key = [&](const Wedge& wedge) {
      CellKey least = {kInfinite, kInfinite, kInfinite, kInfinite};
      for (const std::uint32_t cell : wedge.cells) {
        CellKey own = tetrahedra_.vertices[cell];
        std::sort(own.begin(), own.end());
        least = std::min(least, own);
      }
      return std::tuple(wedge.is_at_infinity, wedge.largest_radius, least);
    };
    const auto widest =
        std::max_element(wedges_.begin(), wedges_.end(),
                         [&](const Wedge& a, const Wedge& b) { return key(a) < key(b); });
    for (auto wedge = wedges_.begin(); wedge != wedges_.end(); ++wedge) {
      if (wedge == widest) continue;
      for (const std::uint32_t cell : wedge->cells) stays_[cell] = 1;
      changed_.insert(changed_.end(), wedge->cells.begin(), wedge->cells.end());
    }
  }

  const Tetrahedra& tetrahedra_;
  std::vector<std::uint8_t>& stays_;
  std::vector<Wedge> wedges_;
  std::vector<std::uint32_t> changed_;  // tetrahedra that the last round has put back
};

/// Tetrahedra that a point has voted on.
std::vector<std::uint8_t> marked_cells(const Tetrahedra& tetrahedra, const Stars& stars,
                                       const PointSides& sides) {
  std::vector<std::uint8_t> marked(tetrahedra.size(), 0);
  for (std::size_t i = 0; i < sides.sides.size(); ++i)
    if (sides.sides[i] != UmbrellaSide::kNeither) marked[stars.cells[i]] = 1;
  return marked;
}

}  // namespace

std::vector<Triangle> tight_cocone(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                   const Stars& stars, const Poles& poles,
                                   std::span<const CenterSides> sides, const CoconeEdges& edges,
                                   const FacetFlags& cocone, std::span<const std::uint8_t> flat,
                                   const StopToken* stop) {
  const UmbrellasByCenters by_centers(tetrahedra, sides, edges, cocone, points.size());
  const PointSides found =
      find_sides(points, tetrahedra, stars, poles, by_centers, cocone, flat, stop);
  const std::vector<std::uint8_t> marked = marked_cells(tetrahedra, stars, found);
  const std::vector<std::int8_t> votes = Marks(tetrahedra, stars, found).take(stop);
  std::vector<std::uint8_t> stays = Peeling(tetrahedra, stars, votes, marked).run(stop);
  EdgeRepair(tetrahedra, stays).run(stop);
  std::vector<Triangle> triangles = triangles_of(tetrahedra, boundary_sides(tetrahedra, stays));
  sort_triangles(points.size(), triangles);
  return triangles;
}

}  // namespace orbweave::voronoi
