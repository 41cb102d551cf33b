#include "engine/holes/loops/bridges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace orbweave {
namespace {

using Edge = std::array<std::uint32_t, 2>;

/// Directed edges of the loop that it also runs along the other way, sorted.
std::vector<Edge> bridges_of(const std::vector<std::uint32_t>& loop) {
  std::vector<Edge> edges, bridges;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    edges.push_back({loop[i], loop[(i + 1) % loop.size()]});
  }
  std::sort(edges.begin(), edges.end());
  for (const Edge& edge : edges) {
    if (std::binary_search(edges.begin(), edges.end(), Edge{edge[1], edge[0]})) {
      bridges.push_back(edge);
    }
  }
  return bridges;
}

}  // namespace

bool has_bridges(const HoleProblem& problem) { return !bridges_of(problem.loop).empty(); }

BridgedProblem cut_bridges(const HoleProblem& problem, double spacing,
                           const std::function<Vec3(std::uint32_t, std::uint32_t, double)>& place) {
  constexpr double kMostPieces = 10'000.0;
  BridgedProblem bridged{problem, 0};
  HoleProblem& cut = bridged.problem;
  std::map<Edge, std::vector<std::uint32_t>> between;
  for (const auto& [a, b] : bridges_of(problem.loop)) {
    if (a > b) continue;
    const double length = norm(problem.positions[b] - problem.positions[a]);
    const double pieces = std::clamp(std::round(length / spacing), 1.0, kMostPieces);
    std::vector<std::uint32_t> points;
    for (double k = 1.0; k < pieces; k += 1.0) {
      points.push_back(static_cast<std::uint32_t>(cut.positions.size()));
      cut.positions.push_back(place(a, b, k / pieces));
      cut.normals.emplace_back();
    }
    between[{a, b}] = points;
    between[{b, a}] = {points.rbegin(), points.rend()};
  }
  cut.loop.clear();
  for (std::size_t i = 0; i < problem.loop.size(); ++i) {
    const Edge edge{problem.loop[i], problem.loop[(i + 1) % problem.loop.size()]};
    cut.loop.push_back(edge[0]);
    const auto points = between.find(edge);
    if (points == between.end()) continue;
    cut.loop.insert(cut.loop.end(), points->second.begin(), points->second.end());
  }
  bridged.points = static_cast<std::uint32_t>(cut.positions.size() - problem.positions.size());
  return bridged;
}

void give_bridge_points(const BridgedProblem& bridged, HolePatch& patch) {
  // New vertices are numbered from the problem's last on: those of the bridges come first.
  const auto& at = bridged.problem.positions;
  patch.positions.insert(patch.positions.begin(), at.end() - bridged.points, at.end());
  patch.normals.insert(patch.normals.begin(), bridged.points, Vec3{});
}

}  // namespace orbweave
