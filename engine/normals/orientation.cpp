// The signs of all patches, from their votes and from what they enclose.
#include "engine/normals/orientation.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>

#include "engine/normals/ground_patches.h"
#include "engine/normals/orientation_graph.h"
#include "io/box.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// Votes for a patch's sign should be at least this to one against it.
constexpr double kClear = 3.0;

/// Rows that one thread treats without a break.
constexpr std::size_t kBlock = 16384;

std::size_t blocks_of(std::size_t rows) { return (rows + kBlock - 1) / kBlock; }

/// Chunks come in order and have theirs in order.
template <class T, class Before>
void sort_rows(std::vector<T>& rows, Before before) {
  if (!std::is_sorted(rows.begin(), rows.end(), before))
    tbb::parallel_sort(rows.begin(), rows.end(), before);
}

std::uint32_t row_of(const std::vector<PatchSum>& sums, PatchId patch) {
  const auto at = std::lower_bound(sums.begin(), sums.end(), patch,
                                   [](const PatchSum& s, PatchId id) { return s.patch < id; });
  if (at == sums.end() || at->patch != patch) return static_cast<std::uint32_t>(sums.size());
  return static_cast<std::uint32_t>(at - sums.begin());
}

std::vector<SignedEdge> edges_of(const std::vector<PatchSum>& sums, std::vector<PatchVote> votes) {
  sort_rows(votes, [](const PatchVote& a, const PatchVote& b) {
    return std::tie(a.from, a.to, a.votes, a.weight) < std::tie(b.from, b.to, b.votes, b.weight);
  });
  std::vector<SignedEdge> edges(votes.size());
  for_each_whole(blocks_of(votes.size()), [&](std::size_t block) {
    const std::size_t first = block * kBlock;
    for (std::size_t i = first; i < std::min(first + kBlock, votes.size()); ++i) {
      const PatchVote& v = votes[i];
      const bool is_same = i > first && votes[i - 1].from == v.from;
      const std::uint32_t from = is_same ? edges[i - 1].a : row_of(sums, v.from);
      edges[i] = {from, row_of(sums, v.to), v.votes, v.weight};
    }
  });
  std::erase_if(edges, [&](const SignedEdge& e) { return std::max(e.a, e.b) >= sums.size(); });
  return edges;
}

/// Turns every part to its right side; the part of the sky so that the sky is not turned.
std::vector<OrientedPart> turn_parts(const std::vector<PatchSum>& sums,
                                     const PatchGraphOptions& options, SignedParts& parts) {
  const auto sky = static_cast<std::uint32_t>(sums.size());
  const std::uint8_t sky_turn = parts.turn[sky];
  std::vector<std::uint8_t> is_settled(sums.size() + 1);
  is_settled[parts.part[sky]] = 1;
  for (std::uint32_t v = 0; v < sums.size(); ++v)
    if (parts.part[v] == parts.part[sky]) parts.turn[v] ^= sky_turn;
  std::vector<OrientedPart> sides =
      sides_of_parts(sums, parts, is_settled,
                     {.cell = options.cell, .inward = options.inward, .stop = options.stop});
  std::vector<std::uint8_t> turn_of(sums.size());
  for (const OrientedPart& side : sides) turn_of[side.shape.first] = side.is_turned ? 1 : 0;
  for (std::uint32_t v = 0; v < sums.size(); ++v) parts.turn[v] ^= turn_of[parts.part[v]];
  return sides;
}

/// A point of the ground votes this much for facing up: a patch of n points less than the patches
/// beside it, so that what hangs together is joined first, and the votes of its ground add up. Ten
/// times as much tears the undersides off things that hang in the air.
constexpr double kGroundVotes = 0.1;

/// Edges from patches of the ground to the sky, which comes after all patches.
std::vector<SignedEdge> ground_edges(const std::vector<PatchSum>& sums,
                                     std::span<const std::uint8_t> is_ground, Vec3 up) {
  std::vector<SignedEdge> edges;
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    if (!is_ground[v]) continue;
    const double weight = kGroundVotes * static_cast<double>(sums[v].points);
    const bool faces_up = dot(sums[v].area_normal, up) >= 0.0;
    edges.push_back(
        {v, static_cast<std::uint32_t>(sums.size()), faces_up ? weight : -weight, weight});
  }
  return edges;
}

void count_ground(const std::vector<PatchSum>& sums, std::span<const std::uint8_t> is_ground,
                  Vec3 up, PatchOrientation& result) {
  for (std::size_t v = 0; v < sums.size(); ++v) {
    if (!is_ground[v]) continue;
    ++result.ground;
    if ((dot(sums[v].area_normal, up) < 0.0) == (result.turn[v] == 0)) ++result.ground_down;
  }
}

/// The places with the most of the patches, in cubes of an eighth to a sixteenth of the extent.
std::vector<ContestedPlace> places_of(const std::vector<PatchSum>& sums,
                                      std::span<const std::uint32_t> contested) {
  constexpr std::size_t kPlaces = 3;
  constexpr double kCubes = 16.0;
  Box bounds;
  for (const PatchSum& sum : sums) {
    bounds.extend(sum.lowest);
    bounds.extend(sum.highest);
  }
  const double side = std::exp2(std::ceil(std::log2(bounds.largest_extent() / kCubes)));
  if (!(side > 0.0)) return {{bounds.min, contested.size()}};
  struct Counted {
    std::array<double, 3> corner;
    std::uint64_t patches = 0;
  };
  std::vector<std::array<double, 3>> corners;
  for (const std::uint32_t v : contested) {
    const Vec3 center = center_of(sums[v]);
    corners.push_back(
        {std::floor(center.x / side), std::floor(center.y / side), std::floor(center.z / side)});
  }
  std::sort(corners.begin(), corners.end());
  std::vector<Counted> cubes;
  for (const auto& corner : corners) {
    if (cubes.empty() || cubes.back().corner != corner) cubes.push_back({corner, 0});
    ++cubes.back().patches;
  }
  std::stable_sort(cubes.begin(), cubes.end(),
                   [](const Counted& a, const Counted& b) { return a.patches > b.patches; });
  if (cubes.size() > kPlaces) cubes.resize(kPlaces);
  std::vector<ContestedPlace> places;
  for (const Counted& cube : cubes) {
    const auto [x, y, z] = cube.corner;
    places.push_back({side * Vec3{x + 0.5, y + 0.5, z + 0.5}, cube.patches});
  }
  return places;
}

/// How far the votes are satisfied, in all and by patch.
void count_votes(const std::vector<PatchSum>& sums, const std::vector<SignedEdge>& edges,
                 const std::vector<std::uint8_t>& turn, PatchOrientation& result) {
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
  std::vector<std::uint32_t> contested;
  double area = 0.0, contested_area = 0.0;
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    const double of_patch = surface_area(sums[v]);
    area += of_patch;
    if (pro[v] >= kClear * contra[v]) continue;
    contested.push_back(v);
    contested_area += of_patch;
  }
  result.contested = contested.size();
  if (area > 0.0) result.contested_area = contested_area / area;
  if (!contested.empty()) result.places = places_of(sums, contested);
  if (total > 0.0) result.satisfied = satisfied / total;
}

/// To a place within a few hundredths of the extent, for reading.
Vec3 rounded(Vec3 place, double extent) {
  constexpr double kSteps = 256.0;
  const double step = std::exp2(std::ceil(std::log2(extent / kSteps)));
  if (!(step > 0.0)) return place;
  for (int axis = 0; axis < 3; ++axis) place[axis] = step * std::round(place[axis] / step);
  return place;
}

/// The parts whose side is a guess, in all and the largest of them.
void list_doubtful(const std::vector<PatchSum>& sums, PatchOrientation& result) {
  constexpr std::size_t kListed = 3;
  double surface = 0.0;
  for (const OrientedPart& part : result.parts) surface += part.shape.surface;
  if (!(surface > 0.0)) return;
  std::vector<DoubtfulPart> doubtful;
  for (const OrientedPart& part : result.parts) {
    if (part.side == PartSide::kInterior) ++result.interiors;
    if (part.doubt != PartDoubt::kNone)
      doubtful.push_back({part.shape.center, part.shape.surface / surface, part.doubt});
  }
  for (const WeakJoin& join : result.weak)
    doubtful.push_back({sums[join.node].lowest, join.size / surface, PartDoubt::kNone});
  for (const DoubtfulPart& part : doubtful) result.doubtful_area += part.area;
  result.doubtful_area = std::min(result.doubtful_area, 1.0);
  std::stable_sort(doubtful.begin(), doubtful.end(),
                   [](const DoubtfulPart& a, const DoubtfulPart& b) { return a.area > b.area; });
  if (doubtful.size() > kListed) doubtful.resize(kListed);
  Box bounds;
  for (const PatchSum& sum : sums) {
    bounds.extend(sum.lowest);
    bounds.extend(sum.highest);
  }
  for (DoubtfulPart& part : doubtful) part.center = rounded(part.center, bounds.largest_extent());
  result.doubtful = std::move(doubtful);
}

/// Weak joins are listed for parts of this share of the surface. The sky is as large as all.
JoinOptions join_options(const std::vector<PatchSum>& sums, const StopToken* stop) {
  constexpr double kLarge = 0.02;
  JoinOptions options{.stop = stop};
  double area = 0.0;
  for (const PatchSum& sum : sums) {
    options.sizes.push_back(surface_area(sum));
    area += options.sizes.back();
  }
  options.sizes.push_back(area);
  options.large = kLarge * area;
  return options;
}

}  // namespace

PatchOrientation orient_patch_graph(std::vector<PatchSum> sums, std::vector<PatchVote> votes,
                                    const PatchGraphOptions& options) {
  sort_rows(sums, [](const PatchSum& a, const PatchSum& b) { return a.patch < b.patch; });
  const std::vector<SignedEdge> edges = edges_of(sums, std::move(votes));
  std::vector<SignedEdge> all = edges;
  std::vector<std::uint8_t> is_ground(sums.size());
  if (options.ground) {
    is_ground = find_ground(sums, options.cell, options.up, options.stop);
    leave_out_undersides(sums, edges, options.up, is_ground, options.stop);
    const std::vector<SignedEdge> to_sky = ground_edges(sums, is_ground, options.up);
    all.insert(all.end(), to_sky.begin(), to_sky.end());
  }
  const auto nodes = static_cast<std::uint32_t>(sums.size()) + 1;
  SignedParts parts = join_by_votes(nodes, std::move(all), join_options(sums, options.stop));
  PatchOrientation result;
  result.parts = turn_parts(sums, options, parts);
  result.weak = std::move(parts.weak);
  result.components = result.parts.size();
  list_doubtful(sums, result);
  parts.turn.pop_back();
  for (const PatchSum& sum : sums) result.patches.push_back(sum.patch);
  count_votes(sums, edges, parts.turn, result);
  result.turn = std::move(parts.turn);
  count_ground(sums, is_ground, options.up, result);
  return result;
}

std::vector<std::uint8_t> whole_turns(std::span<const PatchId> patch_of,
                                      std::vector<std::uint8_t> turn,
                                      const PatchOrientation& orientation) {
  for_each_whole(blocks_of(turn.size()), [&](std::size_t block) {
    // Most points are of the patch of the point before.
    PatchId last = 0;
    std::uint8_t turn_of_last = 0;
    const std::size_t begin = block * kBlock;
    for (std::size_t i = begin; i < std::min(turn.size(), begin + kBlock); ++i) {
      if (i == begin || patch_of[i] != last) {
        last = patch_of[i];
        const auto at = std::ranges::lower_bound(orientation.patches, last);
        const bool known = at != orientation.patches.end() && *at == last;
        const auto row = static_cast<std::size_t>(at - orientation.patches.begin());
        turn_of_last = known ? orientation.turn[row] : 0;
      }
      turn[i] ^= turn_of_last;
    }
  });
  return turn;
}

}  // namespace orbweave
