#include "engine/holes/loops/loop_parts.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace orbweave {
namespace {

using Edge = std::array<std::uint32_t, 2>;

/// Appends a part's patch; its new vertices get the next numbers.
void append(const HoleProblem& problem, HolePatch part, HolePatch& whole) {
  const auto given = static_cast<std::uint32_t>(problem.positions.size());
  const auto before = static_cast<std::uint32_t>(whole.positions.size());
  for (Triangle& t : part.triangles) {
    for (std::uint32_t& v : t) v += v < given ? 0 : before;
    whole.triangles.push_back(t);
  }
  whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
  whole.normals.insert(whole.normals.end(), part.normals.begin(), part.normals.end());
  whole.values.insert(whole.values.end(), part.values.begin(), part.values.end());
  whole.method = std::max(whole.method, part.method);
  whole.sites += part.sites;
  whole.residual = std::max(whole.residual, part.residual);
  whole.condition = std::max(whole.condition, part.condition);
}

/// Edges inside a patch between vertices of the rim, smaller vertex first.
std::vector<Edge> chords_of(const HoleProblem& problem, const HolePatch& patch) {
  std::vector<Edge> chords;
  for (const Triangle& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (std::max(a, b) < problem.positions.size())
        chords.push_back({std::min(a, b), std::max(a, b)});
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
  double radius = 0.0;
  std::vector<char> near(problem.positions.size(), 0);
  for (const std::uint32_t v : loop) radius = std::max(radius, norm(problem.positions[v] - center));
  for (std::size_t v = 0; v < near.size(); ++v)
    near[v] = norm(problem.positions[v] - center) <= kReach * radius ? 1 : 0;
  for (const std::uint32_t v : loop) near[v] = 1;
  std::vector<Triangle> triangles;
  for (const Triangle& t : problem.sheet)
    if (near[t[0]] != 0 || near[t[1]] != 0 || near[t[2]] != 0) triangles.push_back(t);
  return triangles;
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
  HoleProblem part = problem;
  for (std::vector<std::uint32_t>& loop : simple_parts(problem.loop)) {
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    part.sheet = sheet_near(problem, loop);
    part.loop = std::move(loop);
    HolePatch patch = fill(part);
    if (patch.method == FillMethod::kNone) return patch;
    for (const Edge& chord : chords_of(problem, patch)) part.forbidden.push_back(chord);
    std::sort(part.forbidden.begin(), part.forbidden.end());
    append(problem, std::move(patch), whole);
  }
  return whole;
}

}  // namespace orbweave
