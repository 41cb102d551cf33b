#include "engine/holes/loops/loop_parts.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

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

/// Edges inside a part's patch between given vertices, in the whole problem's numbers, smaller
/// vertex first.
std::vector<Edge> chords_of(const Part& part, const HolePatch& patch) {
  std::vector<Edge> chords;
  for (const Triangle& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (std::max(a, b) < part.vertices.size())
        chords.push_back({part.vertices[std::min(a, b)], part.vertices[std::max(a, b)]});
    }
  }
  return chords;
}

/// The triangles that a part's patch may touch or follow: those at its corners, and those near it.
std::vector<Triangle> sheet_near(const HoleProblem& problem,
                                 const std::vector<std::uint32_t>& loop) {
  constexpr double kReach = 2.0;  // radii of the part
  const Vec3 first = problem.positions[loop[0]];
  Vec3 sum;
  for (const std::uint32_t v : loop) sum = sum + (problem.positions[v] - first);
  const Vec3 center = first + sum / static_cast<double>(loop.size());
  double squared = 0.0;
  for (const std::uint32_t v : loop)
    squared = std::max(squared, squared_norm(problem.positions[v] - center));
  std::vector<char> near(problem.positions.size(), 0);
  for (std::size_t v = 0; v < near.size(); ++v)
    near[v] = squared_norm(problem.positions[v] - center) <= kReach * kReach * squared ? 1 : 0;
  for (const std::uint32_t v : loop) near[v] = 1;
  std::vector<Triangle> triangles;
  for (const Triangle& t : problem.sheet)
    if (near[t[0]] != 0 || near[t[1]] != 0 || near[t[2]] != 0) triangles.push_back(t);
  return triangles;
}

/// What a part's patch depends on: most parts of a large loop are small, and each would look at
/// all that is around the whole of it.
Part part_of(const HoleProblem& problem, const std::vector<std::uint32_t>& loop,
             const std::set<Edge>& more_forbidden) {
  constexpr std::uint32_t kNone = UINT32_MAX;
  Part part;
  HoleProblem& own = part.problem;
  own.sheet = sheet_near(problem, loop);
  part.vertices = loop;
  for (const Triangle& t : own.sheet) part.vertices.insert(part.vertices.end(), t.begin(), t.end());
  std::sort(part.vertices.begin(), part.vertices.end());
  part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()), part.vertices.end());
  std::vector<std::uint32_t> number(problem.positions.size(), kNone);
  own.channels = problem.channels;
  for (const std::uint32_t v : part.vertices) {
    number[v] = static_cast<std::uint32_t>(own.positions.size());
    own.positions.push_back(problem.positions[v]);
    own.normals.push_back(problem.normals[v]);
    const auto row = problem.values.begin() + std::ptrdiff_t{v} * problem.channels;
    own.values.insert(own.values.end(), row, row + problem.channels);
  }
  for (Triangle& t : own.sheet)
    for (std::uint32_t& v : t) v = number[v];
  for (const std::uint32_t v : loop) own.loop.push_back(number[v]);
  const auto forbid = [&](const Edge& edge) {
    if (number[edge[0]] != kNone && number[edge[1]] != kNone)
      own.forbidden.push_back({number[edge[0]], number[edge[1]]});
  };
  for (const Edge& edge : problem.forbidden) forbid(edge);
  for (const Edge& edge : more_forbidden) forbid(edge);
  std::sort(own.forbidden.begin(), own.forbidden.end());
  return part;
}

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

HolePatch fill_by_parts(const HoleProblem& problem,
                        const std::function<HolePatch(const HoleProblem&)>& fill) {
  HolePatch whole;
  std::set<Edge> chords;  // of the parts before
  for (std::vector<std::uint32_t>& loop : simple_parts(problem.loop)) {
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    const Part part = part_of(problem, loop, chords);
    HolePatch patch = fill(part.problem);
    if (patch.method == FillMethod::kNone) return patch;
    for (const Edge& chord : chords_of(part, patch)) chords.insert(chord);
    append(problem, part, std::move(patch), whole);
  }
  return whole;
}

}  // namespace orbweave
