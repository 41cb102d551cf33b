#include "engine/holes/loops/loop_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <utility>

#include "io/box.h"

namespace orbweave {
namespace {

using Edge = std::array<std::uint32_t, 2>;

/// A part of a problem in numbers of its own.
struct Part {
  HoleProblem problem;
  std::vector<std::uint32_t> vertices;  ///< of the whole problem, ascending
};

/// Appends a part's patch; its new vertices get the next numbers.
void append(const HoleProblem& problem, const Part& part, HolePatch patch, HolePatch& whole) {
  const auto own = static_cast<std::uint32_t>(part.vertices.size());
  const auto next =
      static_cast<std::uint32_t>(problem.positions.size() + whole.positions.size()) - own;
  for (Triangle& t : patch.triangles) {
    for (std::uint32_t& v : t) v = v < own ? part.vertices[v] : v + next;
    whole.triangles.push_back(t);
  }
  whole.positions.insert(whole.positions.end(), patch.positions.begin(), patch.positions.end());
  whole.normals.insert(whole.normals.end(), patch.normals.begin(), patch.normals.end());
  whole.values.insert(whole.values.end(), patch.values.begin(), patch.values.end());
  whole.method = std::max(whole.method, patch.method);
  whole.sites += patch.sites;
  whole.residual = std::max(whole.residual, patch.residual);
  whole.condition = std::max(whole.condition, patch.condition);
}

/// Edges that parts must not use, by their smaller vertex in the whole problem's numbers.
class ForbiddenEdges {
 public:
  explicit ForbiddenEdges(const HoleProblem& problem) : given_(problem.forbidden) {}

  /// Adds the edges between given vertices of a part's patch.
  void add(const Part& part, const HolePatch& patch) {
    for (const Triangle& t : patch.triangles) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        if (std::max(a, b) < part.vertices.size())
          of_parts_.insert({part.vertices[std::min(a, b)], part.vertices[std::max(a, b)]});
      }
    }
  }

  /// Calls visit(larger vertex) for the edges of a vertex.
  template <class Visit>
  void for_each(std::uint32_t vertex, const Visit& visit) const {
    const Edge first = {vertex, 0};
    for (auto e = std::lower_bound(given_.begin(), given_.end(), first);
         e != given_.end() && (*e)[0] == vertex; ++e)
      visit((*e)[1]);
    for (auto e = of_parts_.lower_bound(first); e != of_parts_.end() && (*e)[0] == vertex; ++e)
      visit((*e)[1]);
  }

 private:
  std::span<const Edge> given_;  // sorted
  std::set<Edge> of_parts_;
};

/// Cuts parts out of a problem. Most parts of a large loop are small: none looks at all that is
/// around the whole of it.
class PartCutter {
 public:
  PartCutter(const HoleProblem& problem, const BoxTree& sheet)
      : problem_(problem),
        sheet_(sheet),
        number_(problem.positions.size(), kNone),
        is_corner_(problem.positions.size(), 0) {}

  /// What a part's patch depends on. May be moved, not copied. The whole problem must outlive it.
  Part part_of(const std::vector<std::uint32_t>& loop, const ForbiddenEdges& forbidden) {
    Part part;
    HoleProblem& own = part.problem;
    own.sheet = sheet_near(loop);
    take_vertices(loop, part);
    own.channels = problem_.channels;
    own.positions.reserve(part.vertices.size());
    own.normals.reserve(part.vertices.size());
    for (const std::uint32_t v : part.vertices) {
      number_[v] = static_cast<std::uint32_t>(own.positions.size());
      own.positions.push_back(problem_.positions[v]);
      own.normals.push_back(problem_.normals[v]);
    }
    if (own.channels > 0) {
      own.values_of = [&whole = problem_, vertices = std::span<const std::uint32_t>(part.vertices)](
                          std::span<const std::uint32_t> wanted) {
        std::vector<std::uint32_t> of_whole;
        for (const std::uint32_t v : wanted) of_whole.push_back(vertices[v]);
        return whole.values_of(of_whole);
      };
    }
    for (Triangle& t : own.sheet)
      for (std::uint32_t& v : t) v = number_[v];
    for (const std::uint32_t v : loop) own.loop.push_back(number_[v]);
    // Only edges between corners matter.
    for (const std::uint32_t v : loop) is_corner_[v] = 1;
    for (const std::uint32_t v : loop) {
      forbidden.for_each(v, [&](std::uint32_t other) {
        if (is_corner_[other] != 0) own.forbidden.push_back({number_[v], number_[other]});
      });
    }
    for (const std::uint32_t v : loop) is_corner_[v] = 0;
    std::sort(own.forbidden.begin(), own.forbidden.end());
    add_apart(loop, own);
    for (const std::uint32_t v : part.vertices) number_[v] = kNone;
    return part;
  }

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  /// The groups of the part's corners.
  void add_apart(const std::vector<std::uint32_t>& loop, HoleProblem& own) const {
    const std::vector<Edge>& all = problem_.apart;
    for (const std::uint32_t v : loop)
      for (auto at = std::lower_bound(all.begin(), all.end(), Edge{v, 0});
           at != all.end() && (*at)[0] == v; ++at)
        own.apart.push_back({number_[v], (*at)[1]});
    std::sort(own.apart.begin(), own.apart.end());
  }

  /// Those of the loop and of the part's sheet, ascending.
  void take_vertices(const std::vector<std::uint32_t>& loop, Part& part) {
    const auto take = [&](std::uint32_t v) {
      if (number_[v] != kNone) return;
      number_[v] = 0;
      part.vertices.push_back(v);
    };
    for (const std::uint32_t v : loop) take(v);
    for (const Triangle& t : part.problem.sheet)
      for (const std::uint32_t v : t) take(v);
    std::sort(part.vertices.begin(), part.vertices.end());
  }

  /// The triangles that a part's patch may touch or follow: those with a vertex near it, and so
  /// those at its corners.
  std::vector<Triangle> sheet_near(const std::vector<std::uint32_t>& loop) const {
    constexpr double kReach = 2.0;  // radii of the part
    const std::vector<Vec3>& at = problem_.positions;
    const Vec3 first = at[loop[0]];
    Vec3 sum;
    for (const std::uint32_t v : loop) sum = sum + (at[v] - first);
    const Vec3 center = first + sum / static_cast<double>(loop.size());
    double squared = 0.0;
    for (const std::uint32_t v : loop) squared = std::max(squared, squared_norm(at[v] - center));
    squared *= kReach * kReach;
    Box box;
    box.extend(center);
    std::vector<Triangle> triangles;
    for (const std::uint32_t i : sheet_.near(box.grown(std::sqrt(squared)))) {
      const Triangle& t = problem_.sheet[i];
      const bool is_near = std::any_of(t.begin(), t.end(), [&](std::uint32_t v) {
        return squared_norm(at[v] - center) <= squared;
      });
      if (is_near) triangles.push_back(t);
    }
    return triangles;
  }

  const HoleProblem& problem_;
  const BoxTree& sheet_;
  std::vector<std::uint32_t> number_;    // of the part's vertices, while it is cut
  std::vector<std::uint8_t> is_corner_;  // of the part, while it is cut
};

}  // namespace

std::vector<std::vector<std::uint32_t>> simple_parts(const std::vector<std::uint32_t>& loop) {
  std::vector<std::vector<std::uint32_t>> parts;
  std::vector<std::uint32_t> open;  // visited, not yet in a part
  for (const std::uint32_t vertex : loop) {
    const auto at = std::find(open.begin(), open.end(), vertex);
    if (at != open.end()) {
      parts.emplace_back(at, open.end());
      open.erase(at, open.end());
    }
    open.push_back(vertex);
  }
  if (parts.empty()) return {};
  parts.push_back(std::move(open));
  const bool is_cut =
      std::all_of(parts.begin(), parts.end(), [](const auto& part) { return part.size() >= 3; });
  return is_cut ? parts : std::vector<std::vector<std::uint32_t>>{};
}

HolePatch fill_by_parts(const HoleProblem& problem, const BoxTree& sheet,
                        const std::function<HolePatch(const HoleProblem&, std::size_t)>& fill) {
  HolePatch whole;
  double area = 0.0, flat = 0.0, confidence = 0.0;  // the last weighted by area
  PartCutter cutter(problem, sheet);
  ForbiddenEdges forbidden(problem);
  std::size_t number = 0;
  for (std::vector<std::uint32_t>& loop : simple_parts(problem.loop)) {
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    const Part part = cutter.part_of(loop, forbidden);
    HolePatch patch = fill(part.problem, number++);
    if (patch.method == FillMethod::kNone) return patch;
    forbidden.add(part, patch);
    const double size = area_of(part.problem, patch);
    area += size;
    if (patch.is_flat) flat += size;
    confidence += patch.confidence * size;
    append(problem, part, std::move(patch), whole);
  }
  if (area > 0.0) whole.confidence = confidence / area;
  whole.is_flat = 2.0 * flat > area;
  return whole;
}

}  // namespace orbweave
