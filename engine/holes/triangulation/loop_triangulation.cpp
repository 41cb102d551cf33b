#include "engine/holes/triangulation/loop_triangulation.h"

#include <algorithm>

#include "engine/geometry/vertex_groups.h"
#include "engine/holes/triangulation/loop_chords.h"

namespace orbweave {

LoopChords::LoopChords(const LoopInSpace& loop)
    : vertices_(loop.vertices), forbidden_(loop.forbidden), apart_(loop.apart) {
  std::vector<std::uint32_t> sorted(vertices_.begin(), vertices_.end());
  std::sort(sorted.begin(), sorted.end());
  touches_ = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
  if (!touches_) return;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    more_.push_back(vertex_pair(vertices_[i], vertices_[(i + 1) % vertices_.size()]));
  }
  std::sort(more_.begin(), more_.end());
}

bool LoopChords::allows(std::uint32_t a, std::uint32_t b) const {
  const VertexPair pair = vertex_pair(vertices_[a], vertices_[b]);
  return pair[0] != pair[1] && !std::binary_search(forbidden_.begin(), forbidden_.end(), pair) &&
         !std::binary_search(more_.begin(), more_.end(), pair) &&
         !share_a_group(apart_, pair[0], pair[1]);
}

bool LoopChords::forbid_repeated(std::span<const CornerTriangle> triangles) {
  if (!touches_) return false;
  const auto n = static_cast<std::uint32_t>(vertices_.size());
  std::vector<VertexPair> chords;
  for (const CornerTriangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k];
      const std::uint32_t b = t[(k + 1) % 3];
      if (a > b || b - a == 1 || b - a == n - 1) continue;  // one of two sides; no rim edges
      chords.push_back(vertex_pair(vertices_[a], vertices_[b]));
    }
  }
  std::sort(chords.begin(), chords.end());
  const std::size_t before = more_.size();
  for (std::size_t i = 1; i < chords.size(); ++i) {
    if (chords[i] == chords[i - 1]) more_.push_back(chords[i]);
  }
  const bool found = more_.size() > before;
  std::sort(more_.begin(), more_.end());
  return found;
}

namespace {

std::vector<CornerTriangle> attempt(const LoopInSpace& loop, const LoopChords& chords,
                                    std::uint32_t exact_corners) {
  // The exact way is still affordable (1 s) where this number of corners has no ear to cut.
  constexpr std::size_t kMostExact = 640;
  std::vector<CornerTriangle> triangles;
  const LoopRest rest = cut_ears(loop, chords, std::max(exact_corners, 3U), triangles);
  if (rest.ring.size() > std::max<std::size_t>(exact_corners, kMostExact)) return {};
  if (!triangulate_exactly(loop, chords, rest.ring, rest.behind, triangles)) return {};
  return triangles;
}

}  // namespace

std::vector<CornerTriangle> triangulate_loop(const LoopInSpace& loop, std::uint32_t exact_corners) {
  const std::size_t n = loop.corners.size();
  if (n < 3 || loop.vertices.size() != n) return {};
  if (!loop.rim_normals.empty() && loop.rim_normals.size() != n) return {};
  LoopChords chords(loop);
  // Chords that were repeated are forbidden in the next attempt; more of them than a loop touches
  // itself are not met in practice.
  constexpr int kAttempts = 16;
  for (int i = 0; i < kAttempts; ++i) {
    std::vector<CornerTriangle> triangles = attempt(loop, chords, exact_corners);
    if (!chords.forbid_repeated(triangles)) return triangles;
  }
  return {};
}

}  // namespace orbweave
