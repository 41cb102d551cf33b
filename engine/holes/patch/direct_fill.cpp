#include "engine/holes/patch/direct_fill.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "engine/holes/patch/patch_values.h"

namespace orbweave {
namespace {

using Edge = std::array<std::uint32_t, 2>;

Edge edge_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

bool visits_twice(const HoleProblem& problem) {
  std::vector<std::uint32_t> sorted = problem.loop;
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
}

/// Edges of the mesh that the chords of a triangulation would use more than once: corners of one
/// vertex are different corners of the disc.
std::vector<Edge> repeated_chords(const HoleProblem& problem,
                                  const std::vector<CornerTriangle>& triangles) {
  const auto n = static_cast<std::uint32_t>(problem.loop.size());
  std::vector<Edge> chords;
  for (const CornerTriangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      // Every chord is met from both sides; the rim's edges from one.
      if (a >= b || b - a == 1 || b - a == n - 1) continue;
      chords.push_back(edge_of(problem.loop[a], problem.loop[b]));
      if (chords.back()[0] == chords.back()[1]) chords.push_back(chords.back());
    }
  }
  std::sort(chords.begin(), chords.end());
  std::vector<Edge> repeated;
  for (std::size_t i = 1; i < chords.size(); ++i) {
    if (chords[i] == chords[i - 1]) repeated.push_back(chords[i]);
  }
  return repeated;
}

/// Triangles between the corners such that no edge is forbidden, joins vertices that are to stay
/// apart, or is used twice over; empty where none were found.
std::vector<CornerTriangle> sound_triangles(const HoleProblem& problem, const Rim& rim,
                                            std::vector<Edge> forbidden,
                                            std::span<const Edge> apart) {
  constexpr int kAttempts = 8;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::vector<CornerTriangle> triangles =
        triangulate_loop({rim.corners, problem.loop, rim.face_normals, forbidden, apart});
    if (triangles.empty()) return {};
    const std::vector<Edge> repeated = repeated_chords(problem, triangles);
    if (repeated.empty()) return triangles;
    forbidden.insert(forbidden.end(), repeated.begin(), repeated.end());
    std::sort(forbidden.begin(), forbidden.end());
    forbidden.erase(std::unique(forbidden.begin(), forbidden.end()), forbidden.end());
  }
  return {};
}

bool is_in_sheet(const HoleProblem& problem) {
  Triangle wanted = {problem.loop[0], problem.loop[1], problem.loop[2]};
  std::sort(wanted.begin(), wanted.end());
  return std::any_of(problem.sheet.begin(), problem.sheet.end(), [&](Triangle t) {
    std::sort(t.begin(), t.end());
    return t == wanted;
  });
}

struct Disc {
  std::vector<Vec3> positions;
  std::vector<CornerTriangle> triangles;
};

Disc fan_about_center(const Rim& rim) {
  const auto n = static_cast<std::uint32_t>(rim.corners.size());
  Disc disc{rim.corners, {}};
  disc.positions.push_back({});  // the corners' mean is the origin
  for (std::uint32_t i = 0; i < n; ++i) disc.triangles.push_back({i, (i + 1) % n, n});
  return disc;
}

/// A ring of new points, one per edge of the loop, and the fan about the centre inside it. Sound
/// for any loop: an edge at a corner ends at a point that no other corner has.
Disc fan_inside_ring(const Rim& rim) {
  const auto n = static_cast<std::uint32_t>(rim.corners.size());
  Disc disc{rim.corners, {}};
  for (std::uint32_t i = 0; i < n; ++i) {
    disc.positions.push_back(0.25 * (rim.corners[i] + rim.corners[(i + 1) % n]));
  }
  disc.positions.push_back({});
  const std::uint32_t center = 2 * n;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    disc.triangles.push_back({i, next, n + i});
    disc.triangles.push_back({next, n + next, n + i});
    disc.triangles.push_back({n + i, n + next, center});
  }
  return disc;
}

Disc fan(const HoleProblem& problem, const Rim& rim) {
  return visits_twice(problem) ? fan_inside_ring(rim) : fan_about_center(rim);
}

HolePatch patch_of(const HoleProblem& problem, const Rim& rim, const Disc& disc) {
  HolePatch patch = patch_of_disc(problem, rim, disc.positions, disc.triangles);
  patch.method = FillMethod::kDirect;
  patch.values = values_from_corners(problem, patch.positions);
  return patch;
}

}  // namespace

LoopTriangles triangles_of_loop(const HoleProblem& problem) {
  return triangles_of_loop(problem, find_rim(problem));
}

LoopTriangles triangles_of_loop(const HoleProblem& problem, Rim rim) {
  LoopTriangles start{std::move(rim), {}, {}};
  if (problem.loop.size() > 3)
    start.sound = sound_triangles(problem, start.rim, problem.forbidden, problem.apart);
  if (start.sound.empty() && (!problem.forbidden.empty() || !problem.apart.empty()))
    start.loose = sound_triangles(problem, start.rim, {}, {});
  return start;
}

HolePatch direct_fill(const HoleProblem& problem) {
  const std::size_t n = problem.loop.size();
  if (n < 3) {
    HolePatch patch;
    patch.reason = "fewer than three edges";
    return patch;
  }
  if (n == 3 && !visits_twice(problem) && !is_in_sheet(problem)) {
    HolePatch patch;
    patch.method = FillMethod::kDirect;
    patch.triangles.push_back({problem.loop[0], problem.loop[1], problem.loop[2]});
    return patch;
  }
  return direct_fill(problem, triangles_of_loop(problem));
}

HolePatch direct_fill(const HoleProblem& problem, const LoopTriangles& start) {
  const Rim& rim = start.rim;
  if (start.sound.empty()) return patch_of(problem, rim, fan(problem, rim));
  return patch_of(problem, rim, {rim.corners, start.sound});
}

bool is_closed_directly(const HoleProblem& problem, const PatchOptions& options) {
  return problem.loop.size() <= options.direct_edges || !(rim_spacing(problem) > 0.0);
}

LoopTriangles rough_triangles_of_loop(const HoleProblem& problem) {
  constexpr std::uint32_t kExactCorners = 32;
  LoopTriangles rough{find_rim(problem), {}, {}};
  rough.sound = triangulate_loop(
      {rough.rim.corners, problem.loop, rough.rim.face_normals, problem.forbidden, problem.apart},
      kExactCorners);
  return rough;
}

PatchMesh disc_of_loop(const HoleProblem& problem, const LoopTriangles& start) {
  const Rim& rim = start.rim;
  Disc disc{rim.corners, start.sound.empty() ? start.loose : start.sound};
  if (disc.triangles.empty() || disc.triangles.size() == 1) disc = fan(problem, rim);
  PatchMesh mesh(std::move(disc.positions), problem.loop, disc.triangles, problem.forbidden,
                 problem.apart);
  mesh.split_forbidden_chords();
  return mesh;
}

}  // namespace orbweave
