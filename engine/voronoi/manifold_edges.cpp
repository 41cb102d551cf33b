#include "engine/voronoi/manifold_edges.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace orbweave::voronoi {
namespace {

/// A side of a triangle, kept with the smaller of its ends.
struct EdgeUse {
  std::uint32_t larger = 0;
  std::uint32_t triangle = 0;
  bool is_reversed = false;  ///< runs from the larger end to the smaller
};

/// The sides of all triangles, those of one smaller end together.
class EdgeUses {
 public:
  explicit EdgeUses(std::span<const Triangle> triangles) {
    for (const Triangle& t : triangles)
      for (const std::uint32_t v : t)
        if (v + 2 >= begin_.size()) begin_.resize(v + 3, 0);
    visit(triangles, [&](std::uint32_t smaller, const EdgeUse&) { ++begin_[smaller + 2]; });
    for (std::size_t i = 2; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    uses_.resize(3 * triangles.size());
    visit(triangles,
          [&](std::uint32_t smaller, const EdgeUse& use) { uses_[begin_[smaller + 1]++] = use; });
  }

  /// Calls visit(smaller end, uses) for every edge.
  template <class Visit>
  void edges(const Visit& visit) {
    for (std::size_t v = 0; v + 1 < begin_.size(); ++v) {
      const std::span<EdgeUse> uses(uses_.data() + begin_[v], begin_[v + 1] - begin_[v]);
      std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return std::tie(a.larger, a.triangle) < std::tie(b.larger, b.triangle);
      });
      for (std::size_t i = 0; i < uses.size();) {
        std::size_t end = i + 1;
        while (end < uses.size() && uses[end].larger == uses[i].larger) ++end;
        visit(static_cast<std::uint32_t>(v), std::span<const EdgeUse>(uses.subspan(i, end - i)));
        i = end;
      }
    }
  }

 private:
  template <class Visit>
  static void visit(std::span<const Triangle> triangles, const Visit& visit) {
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
        visit(std::min(a, b), EdgeUse{std::max(a, b), i, b < a});
      }
    }
  }

  std::vector<std::size_t> begin_ = {0, 0};
  std::vector<EdgeUse> uses_;
};

bool is_manifold(std::span<const EdgeUse> uses) {
  return uses.size() == 1 || (uses.size() == 2 && uses[0].is_reversed != uses[1].is_reversed);
}

}  // namespace

double squared_circumradius(Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 u = b - a, v = c - a, w = c - b;
  const double area = squared_norm(cross(u, v));
  if (!(area > 0.0)) return std::numeric_limits<double>::infinity();
  return squared_norm(u) * squared_norm(v) / area * squared_norm(w) / 4.0;
}

std::vector<MeshEdge> crowded_edges(std::span<const Triangle> triangles) {
  std::vector<MeshEdge> edges;
  EdgeUses(triangles).edges([&](std::uint32_t smaller, std::span<const EdgeUse> uses) {
    if (uses.size() > 2) edges.push_back({smaller, uses[0].larger, uses[0].triangle});
  });
  return edges;
}

void keep_manifold_edges(std::span<const Vec3> points, std::span<const std::uint8_t> suspects,
                         std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> places;  // of the triangles that a suspect edge may have
  std::vector<Triangle> near;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    if (suspects[t[0]] + suspects[t[1]] + suspects[t[2]] < 2) continue;
    places.push_back(i);
    near.push_back(t);
  }
  const auto badness = [&](std::uint32_t i) {
    const Triangle& t = near[i];
    return std::tuple(squared_circumradius(points[t[0]], points[t[1]], points[t[2]]), t);
  };
  std::vector<std::uint8_t> all_gone(triangles.size(), 0);
  for (bool removes = true; removes;) {
    std::vector<std::uint8_t> goes(near.size(), 0);
    removes = false;
    EdgeUses(near).edges([&](std::uint32_t, std::span<const EdgeUse> uses) {
      if (is_manifold(uses)) return;
      std::uint32_t worst = uses.front().triangle;
      for (const EdgeUse& use : uses)
        if (badness(use.triangle) > badness(worst)) worst = use.triangle;
      goes[worst] = 1;
      removes = true;
    });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (goes[i] != 0) {
        all_gone[places[i]] = 1;
        continue;
      }
      near[kept] = near[i];
      places[kept++] = places[i];
    }
    near.resize(kept);
    places.resize(kept);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (all_gone[i] == 0) triangles[kept++] = triangles[i];
  triangles.resize(kept);
}

}  // namespace orbweave::voronoi
