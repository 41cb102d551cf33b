#include "engine/validation/boundary_loops.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "engine/geometry/loop_path.h"

namespace orbweave {
namespace {

/// Ends are numbered 2 * edge + (0 or 1).
constexpr std::uint64_t kNoEnd = std::numeric_limits<std::uint64_t>::max();

std::vector<std::uint64_t> partners(std::span<const BoundaryEdge> edges) {
  std::vector<std::pair<std::uint32_t, std::uint64_t>> ends;  // fan, end
  ends.reserve(2 * edges.size());
  for (std::uint64_t e = 0; e < edges.size(); ++e)
    for (int side = 0; side < 2; ++side) ends.emplace_back(edges[e].fans[side], 2 * e + side);
  std::sort(ends.begin(), ends.end());
  std::vector<std::uint64_t> partner(ends.size(), kNoEnd);
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (ends[i].first != ends[i - 1].first) continue;
    partner[ends[i].second] = ends[i - 1].second;
    partner[ends[i - 1].second] = ends[i].second;
  }
  return partner;
}

class LoopCounter {
 public:
  explicit LoopCounter(std::span<const BoundaryEdge> edges)
      : edges_(edges), partner_(partners(edges)), done_(edges.size(), false) {}

  std::uint64_t count() {
    for (std::uint64_t end = 0; end < partner_.size(); ++end)
      if (partner_[end] == kNoEnd && !done_[end / 2]) walk(end);
    for (std::uint64_t e = 0; e < edges_.size(); ++e)
      if (!done_[e]) walk(2 * e);
    return path_.loops();
  }

 private:
  std::uint32_t vertex(std::uint64_t end) const { return edges_[end / 2].vertices[end % 2]; }

  /// Walks from an end through its edge and on, as far as unwalked edges go.
  void walk(std::uint64_t end) {
    path_.begin(vertex(end));
    while (end != kNoEnd && !done_[end / 2]) {
      done_[end / 2] = true;
      path_.arrive(vertex(end ^ 1));
      end = partner_[end ^ 1];
    }
    path_.end();
  }

  std::span<const BoundaryEdge> edges_;
  std::vector<std::uint64_t> partner_;
  std::vector<bool> done_;
  LoopPath<std::uint32_t> path_;
};

}  // namespace

std::uint64_t count_boundary_loops(std::span<const BoundaryEdge> edges) {
  return LoopCounter(edges).count();
}

}  // namespace orbweave
