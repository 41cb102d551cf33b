#include "engine/stitching/triangle_fans.h"

#include <algorithm>
#include <utility>

#include "engine/geometry/disjoint_sets.h"

namespace orbweave {
namespace {

/// A triangle (vertex, first, second), at its vertex.
struct Corner {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  std::uint32_t triangle = 0;
};

/// The corners at each vertex: those of vertex v are all[begin[v]] to all[begin[v + 1]].
struct Corners {
  std::vector<std::size_t> begin;
  std::vector<Corner> all;

  Corners(std::span<const Triangle> triangles, std::size_t points) : begin(points + 2, 0) {
    for (const Triangle& t : triangles)
      for (const std::uint32_t v : t) ++begin[v + 2];
    for (std::size_t i = 2; i < begin.size(); ++i) begin[i] += begin[i - 1];
    all.resize(3 * triangles.size());
    for (std::uint32_t i = 0; i < triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        all[begin[triangles[i][k] + 1]++] = {triangles[i][(k + 1) % 3], triangles[i][(k + 2) % 3],
                                             i};
    begin.pop_back();
  }

  std::span<Corner> of(std::uint32_t vertex) {
    return std::span(all).subspan(begin[vertex], begin[vertex + 1] - begin[vertex]);
  }
};

/// The fans of one vertex: its corners, in fans, each from its first to its last.
class VertexFans {
 public:
  struct Fan {
    std::size_t begin = 0, end = 0;  ///< of the corners
    bool is_closed = false;
  };

  /// Puts the corners in the order of the fans.
  void find(std::span<Corner> corners) {
    fans_.clear();
    std::sort(corners.begin(), corners.end(),
              [](const Corner& a, const Corner& b) { return a.first < b.first; });
    before_.assign(corners.begin(), corners.end());
    done_.assign(corners.size(), 0);
    std::size_t end = 0;
    // Open fans from the corners that none leads to, then the rest, which is closed.
    for (const bool open : {true, false}) {
      for (std::size_t i = 0; i < before_.size(); ++i) {
        if (done_[i] != 0 || (open && is_led_to(before_[i].first))) continue;
        const std::size_t begin = end;
        for (std::size_t at = i; at < before_.size() && done_[at] == 0;
             at = place_of(before_[at].second)) {
          done_[at] = 1;
          corners[end++] = before_[at];
        }
        fans_.push_back({begin, end, !open});
      }
    }
  }
  std::span<const Fan> fans() const { return fans_; }

 private:
  std::size_t place_of(std::uint32_t first) const {
    const auto found =
        std::lower_bound(before_.begin(), before_.end(), first,
                         [](const Corner& corner, std::uint32_t f) { return corner.first < f; });
    return found != before_.end() && found->first == first
               ? static_cast<std::size_t>(found - before_.begin())
               : before_.size();
  }
  bool is_led_to(std::uint32_t first) const {
    return std::any_of(before_.begin(), before_.end(),
                       [&](const Corner& corner) { return corner.second == first; });
  }

  std::vector<Corner> before_;
  std::vector<std::uint8_t> done_;
  std::vector<Fan> fans_;
};

}  // namespace

void turn_to_normals(std::span<const Vec3> positions, std::span<const Vec3> normals,
                     std::vector<Triangle>& triangles, const StopToken* stop) {
  if (normals.empty()) return;
  Corners corners(triangles, positions.size());
  DisjointSets sets(triangles.size());
  VertexFans fans;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (v % kStopBlock == 0) check_stop(stop);
    const std::span<Corner> here = corners.of(v);
    fans.find(here);
    for (const VertexFans::Fan& fan : fans.fans())
      for (std::size_t i = fan.begin + 1; i < fan.end; ++i)
        sets.unite(here[i - 1].triangle, here[i].triangle);
  }
  std::vector<double> agreement(triangles.size(), 0.0);
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const Vec3 area = cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
    agreement[sets.find(i)] += dot(area, normals[t[0]] + normals[t[1]] + normals[t[2]]);
  }
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    if (agreement[sets.find(i)] < 0.0) std::swap(triangles[i][1], triangles[i][2]);
  std::sort(triangles.begin(), triangles.end());
}

BallPivotingResult with_fans(std::vector<Triangle> triangles, std::size_t points,
                             const StopToken* stop) {
  BallPivotingResult result;
  result.fans.assign(points, 0);
  Corners corners(triangles, points);
  VertexFans fans;
  for (std::uint32_t v = 0; v < points; ++v) {
    if (v % kStopBlock == 0) check_stop(stop);
    const std::span<Corner> here = corners.of(v);
    fans.find(here);
    constexpr std::size_t kMost = 255;
    result.fans[v] = static_cast<std::uint8_t>(std::min(fans.fans().size(), kMost));
    for (const VertexFans::Fan& fan : fans.fans()) {
      if (!fan.is_closed)
        result.boundary.push_back({here[fan.end - 1].second, v, here[fan.begin].first});
      if (fans.fans().size() < 2) continue;
      std::uint32_t least = here[fan.begin].first;
      for (std::size_t i = fan.begin; i < fan.end; ++i) least = std::min(least, here[i].first);
      for (std::size_t i = fan.begin; i < fan.end; ++i)
        result.fan_members.push_back({v, here[i].first, least});
    }
  }
  std::sort(result.boundary.begin(), result.boundary.end(),
            [](const BoundaryFan& a, const BoundaryFan& b) {
              return std::pair(a.vertex, a) < std::pair(b.vertex, b);
            });
  std::sort(result.fan_members.begin(), result.fan_members.end());
  result.triangles = std::move(triangles);
  return result;
}

}  // namespace orbweave
