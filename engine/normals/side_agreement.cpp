// The eight nearest neighbours of a point say whether its normal is that of the surface, and
// whether the normals beside it are on the same side (König and Gumhold 2009, the reflected
// normal).
#include "engine/normals/side_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "engine/geometry/neighbor_search.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

constexpr std::size_t kNeighbors = 8;
/// As many neighbours on the other side lie beyond a line; fewer are strays, turned wrongly.
constexpr std::size_t kSeam = 3;

/// What a neighbour says.
enum class Voice { kNeither, kSameSide, kOtherSide };

/// One that does not lie nearly across both normals says nothing.
Voice voice_of(Vec3 normal_p, Vec3 normal_q, Vec3 q_p) {
  constexpr double kMostAlong = 0.35, kLeastAgreement = 0.8;
  const double length = norm(q_p);
  if (!(length > 0.0)) return Voice::kNeither;
  const double along_p = dot(normal_p, q_p) / length, along_q = dot(normal_q, q_p) / length;
  if (std::abs(along_p) >= kMostAlong || std::abs(along_q) >= kMostAlong) return Voice::kNeither;
  const double agreement = dot(normal_p, normal_q) - 2.0 * along_p * along_q;
  if (std::abs(agreement) < kLeastAgreement) return Voice::kNeither;
  return agreement > 0.0 ? Voice::kSameSide : Voice::kOtherSide;
}

bool is_steep(Vec3 normal, Vec3 q_p) {
  constexpr double kSteep = 0.5;  // the neighbour lies 30 degrees or more off the tangent plane
  return std::abs(dot(normal, q_p)) > kSteep * norm(q_p);
}

class Looker {
 public:
  Looker(std::span<const Vec3> positions, std::span<const Vec3> normals)
      : positions_(positions), normals_(normals) {}

  void look(std::uint32_t point, std::span<const std::uint32_t> neighbors, std::uint64_t number,
            SideFacts& facts) const {
    if (neighbors.size() < kNeighbors) return;
    std::size_t steep = 0, same = 0, other = 0;
    const Vec3 normal = normalized(normals_[point]);
    for (const std::uint32_t n : neighbors) {
      const Vec3 between = positions_[n] - positions_[point];
      if (is_steep(normal, between)) ++steep;
      const Voice voice = voice_of(normal, normalized(normals_[n]), between);
      if (voice == Voice::kSameSide) ++same;
      if (voice == Voice::kOtherSide) ++other;
    }
    constexpr double kLevel = 0.7;
    ++facts.looked;
    if (normal.z > kLevel) ++facts.upward;
    if (normal.z < -kLevel) ++facts.downward;
    if (2 * steep >= kNeighbors) ++facts.steep;
    if (same + other + 1 < kNeighbors) return;
    ++facts.smooth;
    if (other < kSeam) return;
    ++facts.seams;
    if (number >= facts.first_seam) return;
    facts.first_seam = number;
    facts.place = positions_[point];
  }

 private:
  std::span<const Vec3> positions_;
  std::span<const Vec3> normals_;
};

}  // namespace

SideFacts side_agreement(std::span<const Vec3> positions, std::span<const Vec3> normals,
                         const SideCheck& check) {
  constexpr std::uint32_t kBlock = NeighborSearch::kBlock;
  if (check.begin >= check.end) return {};
  const NeighborSearch search(positions);
  const Looker looker(positions, normals);
  const double max_squared = squared_reach(check.reach);
  const std::uint32_t first_block = check.begin / kBlock, last_block = (check.end - 1) / kBlock + 1;
  constexpr std::uint32_t kBlocksAtOnce = 64;
  std::vector<SideFacts> parts((last_block - first_block + kBlocksAtOnce - 1) / kBlocksAtOnce);
  for_each_whole(parts.size(), [&](std::size_t part) {
    NeighborSearch::Query query;
    const auto begin = first_block + static_cast<std::uint32_t>(part) * kBlocksAtOnce;
    for (std::uint32_t block = begin; block < std::min(last_block, begin + kBlocksAtOnce);
         ++block) {
      check_stop(check.stop);
      const std::uint32_t from = std::max(check.begin, block * kBlock);
      const std::uint32_t to = std::min(check.end, (block + 1) * kBlock);
      const auto asked = check.asked.subspan(from - check.begin, to - from);
      if (std::ranges::find(asked, 1) == asked.end()) continue;
      query.find(search, from, to, kNeighbors, max_squared, asked);
      for (std::uint32_t i = from; i < to; ++i)
        if (asked[i - from] != 0)
          looker.look(i, query.of(i), check.first + (i - check.begin), parts[part]);
    }
  });
  SideFacts facts;
  for (const SideFacts& part : parts) facts += part;
  return facts;
}

}  // namespace orbweave
