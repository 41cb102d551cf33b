#include "engine/holes/hole_pass.h"

#include <algorithm>
#include <chrono>
#include <numbers>
#include <utility>

#include "engine/holes/fill_hole.h"
#include "engine/holes/loops/crumbs.h"
#include "engine/holes/loops/islands.h"
#include "engine/holes/loops/neighborhood.h"
#include "engine/holes/loops/open_scenes.h"

namespace orbweave {
namespace {

using Edge64 = std::array<std::uint64_t, 2>;

Triangle64 in_mesh_numbers(const Triangle& t, std::span<const std::uint64_t> vertices) {
  Triangle64 result;
  for (int k = 0; k < 3; ++k) {
    result[k] = t[k] < vertices.size() ? vertices[t[k]] : kNewVertex + (t[k] - vertices.size());
  }
  return result;
}

/// Vertices around a loop that its patch is shaped after. Within twice the radius of a long one,
/// which is wide in one direction alone, there are far more than around a round one of as many
/// edges: of these the rings nearest to the rim are kept.
std::uint32_t most_around(const BoundaryLoop& loop, std::uint32_t most) {
  constexpr std::size_t kLeast = 300;
  constexpr double kRound = 5.0;  // radii; a circle's perimeter is 2 pi of them, a slit's 4
  const bool is_long = loop.perimeter < kRound * loop.radius;
  if (!is_long) return most;
  const std::size_t edges = loop.vertices.size();
  return static_cast<std::uint32_t>(
      std::min<std::size_t>(most, std::max(kLeast, edges * edges / 4)));
}

}  // namespace

LoopPatch fill_loop(const Surface& surface, const BoundaryLoop& loop, std::span<const Edge64> apart,
                    const HoleFacts& known, const FillOptions& options, const StopToken* stop,
                    const LoopManner& manner) {
  const auto begin = std::chrono::steady_clock::now();
  PatchOptions patch_options;
  patch_options.kernel =
      options.kernel == FillKernel::kBiharmonic ? RbfKernel::kBiharmonic : RbfKernel::kTriharmonic;
  patch_options.allow_intersections = options.allow_intersections;
  patch_options.graded = options.graded;
  patch_options.flat = manner.flat;
  patch_options.whole = manner.whole && !options.allow_intersections;
  patch_options.in_scene = manner.in_scene;
  patch_options.stop = stop;
  NeighborhoodOptions around;
  around.radius_factor = options.neighborhood;
  around.max_vertices = most_around(loop, around.max_vertices);
  if (loop.vertices.size() <= patch_options.direct_edges) {
    // Triangles between the corners are chosen by the faces behind them; what else they could meet
    // is looked for only where that matters.
    around.max_rings = 1;
    around.whole_fans = !options.allow_intersections;
  }
  const GatheredHole gathered = gather_hole(surface, loop, apart, around);
  HolePatch patch = fill_hole(gathered.problem, patch_options);

  LoopPatch result;
  HoleFacts& facts = result.facts = known;
  facts.filled = patch.method != FillMethod::kNone;
  facts.reason = std::move(patch.reason);
  facts.open = patch.open;
  if (facts.filled) {
    facts.method = name_of(patch.method);
    facts.sites = patch.sites;
    facts.points_added = patch.positions.size();
    facts.triangles_added = patch.triangles.size();
    facts.open_edges = patch.open_edges;
    facts.area = area_of(gathered.problem, patch);
    facts.residual = patch.residual;
    facts.condition = patch.condition;
    facts.rim_dihedral_deg = patch.rim_dihedral_rad * 180.0 / std::numbers::pi;
    facts.rim_mean_deg = patch.rim_mean_rad * 180.0 / std::numbers::pi;
    facts.confidence = patch.confidence;
    result.triangles.reserve(patch.triangles.size());
    for (const Triangle& t : patch.triangles) {
      result.triangles.push_back(in_mesh_numbers(t, gathered.vertices));
    }
    result.positions = std::move(patch.positions);
    result.normals = std::move(patch.normals);
    result.values = std::move(patch.values);
  }
  facts.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

namespace {

/// The vertices that the loops of the group have in common with others.
std::vector<Edge64> groups_of(const HolePlan& plan, std::span<const std::uint32_t> loops) {
  std::vector<Edge64> apart;
  for (const std::uint32_t l : loops) {
    const std::vector<Edge64> more = plan.shared.groups_on(plan.loops[l], l);
    apart.insert(apart.end(), more.begin(), more.end());
  }
  return apart;
}

}  // namespace

std::vector<std::uint32_t> HolePlan::loops_of(std::uint32_t hole) const {
  std::vector<std::uint32_t> all = {hole};
  all.insert(all.end(), islands[hole].begin(), islands[hole].end());
  return all;
}

HoleFacts HolePlan::facts_of(std::size_t l) const {
  const BoundaryLoop& loop = loops[l];
  HoleFacts facts;
  facts.id = first_id + static_cast<std::int32_t>(l);
  facts.first_vertex = loop.vertices.front();
  facts.edges = loop.vertices.size();
  facts.perimeter = loop.perimeter;
  facts.diameter = 2.0 * loop.radius;
  facts.center = loop.center;
  facts.reason = reasons[l];
  facts.open = open[l];
  return facts;
}

bool HolePlan::is_of_solid(std::size_t loop) const {
  const std::vector<std::uint64_t>& components = loops[loop].components;
  return std::none_of(components.begin(), components.end(),
                      [&](std::uint64_t piece) { return is_scene[piece] != 0; });
}

LoopManner HolePlan::manner_of(std::size_t loop) const {
  // As many edges as the widest gap of a scene is wide: the loop spans a third of that.
  constexpr std::size_t kMostPartlyEdges = 48;
  const bool is_wide = loops[loop].vertices.size() > kMostPartlyEdges;
  return {.whole = is_wide && is_limited && !is_of_solid(loop), .in_scene = !is_object};
}

std::vector<HoleFacts> HolePlan::all_facts() const {
  std::vector<HoleFacts> facts;
  facts.reserve(loops.size());
  for (std::size_t l = 0; l < loops.size(); ++l) facts.push_back(facts_of(l));
  return facts;
}

namespace {

/// Positions are asked for only where islands are joined to the hole around them; of a boundary
/// that is a third of all edges they would be most of what the plan holds.
std::vector<BoundaryVertex> vertices_around_islands(const HolePlan& plan) {
  std::vector<std::uint64_t> wanted;
  for (std::uint32_t hole = 0; hole < plan.loops.size(); ++hole) {
    if (plan.islands[hole].empty()) continue;
    for (const std::uint32_t l : plan.loops_of(hole)) {
      const std::vector<std::uint64_t>& vertices = plan.loops[l].vertices;
      wanted.insert(wanted.end(), vertices.begin(), vertices.end());
    }
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::vector<BoundaryVertex> found;
  found.reserve(wanted.size());
  auto at = plan.vertices.begin();
  for (const std::uint64_t vertex : wanted) {
    at = std::lower_bound(
        at, plan.vertices.end(), vertex,
        [](const BoundaryVertex& known, std::uint64_t number) { return known.vertex < number; });
    found.push_back(*at);
  }
  return found;
}

}  // namespace

namespace {

/// Which loops are to be filled, and which of the others may be islands in them.
struct LoopKinds {
  std::vector<std::uint8_t> is_hole, may_be_island;
};

LoopKinds kinds_of(std::span<const HoleChoice> choices) {
  LoopKinds kinds;
  for (const HoleChoice& choice : choices) {
    kinds.is_hole.push_back(choice.reason.empty() && !choice.opposes_normals ? 1 : 0);
    kinds.may_be_island.push_back(choice.opposes_normals ? 1 : 0);
  }
  return kinds;
}

/// The crumbs among the pieces that are no islands: those are joined to the rest.
std::vector<std::uint8_t> crumbs_of(const HolePlan& plan, std::span<const Piece> pieces,
                                    const FillOptions& options, const StopToken* stop) {
  std::vector<std::uint8_t> crumbs =
      find_crumbs(plan.loops, pieces, outer_borders(plan.loops, pieces));
  if (std::find(crumbs.begin(), crumbs.end(), 1) == crumbs.end()) return crumbs;
  const LoopKinds kinds = kinds_of(choose_holes(plan.loops, pieces, options));
  std::vector<std::uint64_t> islands;
  for (const auto& list :
       find_islands(plan.loops, kinds.is_hole, kinds.may_be_island, plan.vertices, stop))
    for (const std::uint32_t l : list)
      islands.insert(islands.end(), plan.loops[l].components.begin(),
                     plan.loops[l].components.end());
  keep_pieces(plan.loops, islands, crumbs);
  return crumbs;
}

/// Takes the flaps of the loops that are to be filled. Whether there were any.
bool take_flaps(std::span<const HoleChoice> choices, HolePlan& plan, FlapsToTake& to_take,
                const StopToken* stop) {
  std::vector<std::uint8_t> is_wanted;
  for (const HoleChoice& choice : choices) is_wanted.push_back(choice.reason.empty() ? 1 : 0);
  to_take.flaps =
      take_rim_flaps(is_wanted, to_take.surface, plan.loops, to_take.fans, plan.vertices, stop);
  return !to_take.flaps.triangles.empty();
}

}  // namespace

HolePlan plan_holes(std::vector<OpenFan> fans, std::vector<BoundaryVertex> vertices,
                    std::span<const Piece> pieces, const FillOptions& options,
                    const StopToken* stop, FlapsToTake* to_take) {
  HolePlan plan;
  plan.vertices = std::move(vertices);
  plan.loops = trace_loops(std::move(fans), plan.vertices, stop);
  plan.crumbs.resize(pieces.size(), 0);
  if (!options.min_triangles) plan.crumbs = crumbs_of(plan, pieces, options, stop);
  std::erase_if(plan.loops, [&](const BoundaryLoop& loop) {
    return plan.crumbs[loop.components.front()] != 0;
  });
  plan.is_limited = limits_widths(options);
  std::vector<HoleChoice> choices = choose_holes(plan.loops, pieces, options);
  plan.is_scene = pieces_of_scenes(plan.loops, pieces, outer_borders(plan.loops, pieces));
  const auto largest = std::ranges::max_element(pieces, {}, &Piece::triangles);
  plan.is_object = largest == pieces.end() ||
                   plan.is_scene[static_cast<std::size_t>(largest - pieces.begin())] == 0;
  if (to_take != nullptr && !plan.is_object && take_flaps(choices, plan, *to_take, stop))
    choices = choose_holes(plan.loops, pieces, options);
  const LoopKinds kinds = kinds_of(choices);
  for (HoleChoice& choice : choices) {
    plan.is_wanted.push_back(choice.reason.empty() ? 1 : 0);
    plan.reasons.push_back(std::move(choice.reason));
    plan.open.push_back(choice.open);
  }
  choices = {};
  plan.islands = find_islands(plan.loops, kinds.is_hole, kinds.may_be_island, plan.vertices, stop);
  plan.vertices = vertices_around_islands(plan);
  plan.shared = SharedVertices(plan.loops);
  std::vector<std::uint8_t> is_island(plan.loops.size(), 0);
  for (const auto& list : plan.islands) {
    for (const std::uint32_t l : list) is_island[l] = 1;
  }
  for (std::uint32_t l = 0; l < plan.loops.size(); ++l) {
    if (plan.reasons[l].empty() && is_island[l] == 0) plan.groups.push_back(l);
  }
  return plan;
}

std::vector<LoopPatch> fill_group(const Surface& surface, const HolePlan& plan, std::uint32_t hole,
                                  const FillOptions& options, const StopToken* stop) {
  std::vector<LoopPatch> patches;
  const std::vector<std::uint32_t>& islands = plan.islands[hole];
  if (!islands.empty()) {
    const BoundaryLoop joined =
        join_islands(plan.loops[hole], plan.loops, islands, plan.vertices, stop);
    patches.push_back(fill_loop(surface, joined, groups_of(plan, plan.loops_of(hole)),
                                plan.facts_of(hole), options, stop, plan.manner_of(hole)));
    // A patch around an island that is open somewhere may leave the island unjoined.
    if (patches.front().facts.filled && patches.front().facts.open_edges == 0) {
      for (const std::uint32_t l : islands) {
        HoleFacts& facts = patches.emplace_back().facts = plan.facts_of(l);
        facts.filled = true;
        facts.method = patches.front().facts.method;
        facts.reason.clear();
        facts.open = OpenReason::kNone;
        facts.joined_to = plan.facts_of(hole).id;
        facts.confidence = patches.front().facts.confidence;
      }
      return patches;
    }
    patches.clear();
  }
  for (const std::uint32_t l : plan.loops_of(hole)) {
    if (plan.reasons[l].empty()) {
      patches.push_back(fill_loop(surface, plan.loops[l], plan.shared.groups_on(plan.loops[l], l),
                                  plan.facts_of(l), options, stop, plan.manner_of(l)));
    } else {
      patches.emplace_back().facts = plan.facts_of(l);
    }
  }
  return patches;
}

}  // namespace orbweave
