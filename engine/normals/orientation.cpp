// The signs of all patches, from their votes and from what they enclose.
#include "engine/normals/orientation.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/normals/orientation_graph.h"

namespace orbweave {
namespace {

/// Votes for a patch's sign should be at least this to one against it.
constexpr double kClear = 3.0;

std::uint32_t row_of(const std::vector<PatchSum>& sums, PatchId patch) {
  const auto at = std::lower_bound(sums.begin(), sums.end(), patch,
                                   [](const PatchSum& s, PatchId id) { return s.patch < id; });
  if (at == sums.end() || at->patch != patch) return static_cast<std::uint32_t>(sums.size());
  return static_cast<std::uint32_t>(at - sums.begin());
}

std::vector<SignedEdge> edges_of(const std::vector<PatchSum>& sums, std::vector<PatchVote> votes) {
  std::sort(votes.begin(), votes.end(), [](const PatchVote& a, const PatchVote& b) {
    return std::tie(a.from, a.to, a.votes, a.weight) < std::tie(b.from, b.to, b.votes, b.weight);
  });
  std::vector<SignedEdge> edges;
  edges.reserve(votes.size());
  for (const PatchVote& v : votes) {
    const std::uint32_t a = row_of(sums, v.from), b = row_of(sums, v.to);
    if (a < sums.size() && b < sums.size()) edges.push_back({a, b, v.votes, v.weight});
  }
  return edges;
}

/// Of a part of the cloud, as its votes orient it.
struct Enclosed {
  Vec3 lowest, highest;
  Vec3 area_normal;
  double area = 0.0;  // summed without regard to directions, patch by patch
  double flux = 0.0;  // through the part, of the vectors from the centre of its bounds
};

/// A sheet whose area vector is this many times its flux per diagonal of the bounds is no shell:
/// which side bulges says little.
constexpr double kSheet = 20.0;
/// So much of a landscape's area adds up to an area vector, and that stands so upright; whatever
/// grows on it encloses next to nothing. A closed surface's adds up to nothing.
constexpr double kOpen = 0.15;
constexpr double kUpright = 0.7;

/// Upward, or to the back, or to the right where a sheet stands upright.
bool points_down(Vec3 area_normal) {
  for (const double component : {area_normal.z, area_normal.y, area_normal.x})
    if (std::abs(component) > 0.1 * norm(area_normal)) return component < 0.0;
  return false;
}

bool points_inward(const Enclosed& e) {
  const double bulge = std::abs(e.flux), open = norm(e.area_normal);
  if (open > kOpen * e.area && std::abs(e.area_normal.z) > kUpright * open)
    return e.area_normal.z < 0.0;
  const double diagonal = norm(e.highest - e.lowest);
  if (open * diagonal > kSheet * bulge) return points_down(e.area_normal);
  return e.flux < 0.0;
}

std::vector<Enclosed> enclosed(const std::vector<PatchSum>& sums, const SignedParts& parts) {
  std::vector<Enclosed> of(sums.size());
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    Enclosed& e = of[parts.part[v]];
    if (parts.part[v] == v) e = {sums[v].lowest, sums[v].highest, {}, 0.0, 0.0};
    for (int axis = 0; axis < 3; ++axis) {
      e.lowest[axis] = std::min(e.lowest[axis], sums[v].lowest[axis]);
      e.highest[axis] = std::max(e.highest[axis], sums[v].highest[axis]);
    }
  }
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    Enclosed& e = of[parts.part[v]];
    const double sign = parts.turn[v] ? -1.0 : 1.0;
    const Vec3 center = e.lowest + 0.5 * (e.highest - e.lowest);
    e.area_normal = e.area_normal + sign * sums[v].area_normal;
    e.area += norm(sums[v].area_normal);
    e.flux += sign * (sums[v].flux + dot(sums[v].area_normal, sums[v].flux_origin - center));
  }
  return of;
}

void turn_outward(const std::vector<PatchSum>& sums, SignedParts& parts) {
  const std::vector<Enclosed> of = enclosed(sums, parts);
  for (std::uint32_t v = 0; v < sums.size(); ++v)
    if (points_inward(of[parts.part[v]])) parts.turn[v] ^= 1;
}

/// How far the votes are satisfied, in all and by patch.
void count_votes(const std::vector<SignedEdge>& edges, const std::vector<std::uint8_t>& turn,
                 PatchOrientation& result) {
  std::vector<double> pro(turn.size()), contra(turn.size());
  double satisfied = 0.0, total = 0.0;
  for (const SignedEdge& e : edges) {
    const double votes = turn[e.a] == turn[e.b] ? e.votes : -e.votes;
    const double agree = 0.5 * (e.weight + votes), against = 0.5 * (e.weight - votes);
    for (const std::uint32_t v : {e.a, e.b}) {
      pro[v] += agree;
      contra[v] += against;
    }
    satisfied += agree;
    total += e.weight;
  }
  for (std::size_t v = 0; v < turn.size(); ++v)
    if (pro[v] < kClear * contra[v]) ++result.contested;
  if (total > 0.0) result.satisfied = satisfied / total;
}

}  // namespace

PatchOrientation orient_patch_graph(std::vector<PatchSum> sums, std::vector<PatchVote> votes,
                                    const StopToken* stop) {
  std::sort(sums.begin(), sums.end(),
            [](const PatchSum& a, const PatchSum& b) { return a.patch < b.patch; });
  const std::vector<SignedEdge> edges = edges_of(sums, std::move(votes));
  SignedParts parts = join_by_votes(static_cast<std::uint32_t>(sums.size()), edges, 0.0, stop);
  turn_outward(sums, parts);
  PatchOrientation result;
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    result.patches.push_back(sums[v].patch);
    if (parts.part[v] == v) ++result.components;
  }
  count_votes(edges, parts.turn, result);
  result.turn = std::move(parts.turn);
  return result;
}

std::vector<std::uint8_t> whole_turns(std::span<const PatchId> patch_of,
                                      std::vector<std::uint8_t> turn,
                                      const PatchOrientation& orientation) {
  for (std::size_t i = 0; i < turn.size(); ++i) {
    const auto at =
        std::lower_bound(orientation.patches.begin(), orientation.patches.end(), patch_of[i]);
    if (at == orientation.patches.end() || *at != patch_of[i]) continue;
    turn[i] ^= orientation.turn[static_cast<std::size_t>(at - orientation.patches.begin())];
  }
  return turn;
}

}  // namespace orbweave
