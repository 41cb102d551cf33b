#include "engine/holes/fill_mesh.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <string>
#include <utility>

#include "engine/geometry/crossing_pairs.h"
#include "engine/holes/crossing_patches.h"
#include "engine/holes/hole_pass.h"
#include "engine/holes/loops/mesh_surface.h"
#include "engine/holes/loops/split_vertices.h"
#include "engine/holes/mend_solids.h"
#include "engine/holes/patch/box_tree.h"
#include "engine/holes/patch/numbers_near.h"
#include "engine/holes/patch/patch_vertices.h"
#include "engine/holes/small_pieces.h"
#include "io/error.h"
#include "io/mesh_size.h"

namespace orbweave {
namespace {

/// What is known before anything is filled.
struct Survey {
  std::vector<std::uint8_t> keep;  // per triangle; empty: all
  std::uint64_t pieces_removed = 0;
  MeshSurface surface;  // of the triangles that are kept
  HolePlan plan;
  std::vector<OpenFan> fans;           // by vertex
  std::vector<std::uint32_t> pinched;  // vertices, ascending
  RimFlaps flaps;                      // not among what is kept
};

/// The largest id of a hole that the mesh has already; 0: none.
std::int32_t last_id(const TriangleMesh& mesh) {
  std::int32_t last = 0;
  for (const std::int32_t id : mesh.hole) last = std::max(last, id);
  return last;
}

/// A mesh has fewer loops than triangles, and fewer pinches than vertices.
bool has_room_for_ids(const TriangleMesh& mesh, std::int32_t last) {
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max());
  return last == 0 ||
         mesh.triangles.size() + mesh.vertices.size() <= kMost - static_cast<std::uint64_t>(last);
}

/// Keeps none of these triangles, which are sorted.
void give_up(std::span<const Triangle64> triangles, const TriangleMesh& mesh,
             std::vector<std::uint8_t>& keep) {
  if (triangles.empty()) return;
  if (keep.empty()) keep.assign(mesh.triangles.size(), 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    const Triangle64 known = smallest_first(Triangle64{corners[0], corners[1], corners[2]});
    if (std::binary_search(triangles.begin(), triangles.end(), known)) keep[t] = 0;
  }
}

Survey survey_of(const TriangleMesh& mesh, MeshSurvey whole, const FillOptions& options,
                 const FillMeshSettings& settings) {
  const MeshComponents& components = whole.components;
  Survey survey{{}, 0, std::move(whole.surface), {}, {}, {}, {}};
  const std::uint64_t least = options.min_triangles.value_or(0);
  for (const Piece& piece : components.pieces) {
    survey.pieces_removed += piece.triangles < least ? 1 : 0;
  }
  if (survey.pieces_removed > 0) {
    for (const std::uint32_t piece : components.of_triangle) {
      survey.keep.push_back(components.pieces[piece].triangles < least ? 0 : 1);
    }
    survey.surface = MeshSurface(mesh, survey.keep);
  }
  const MeshSurface& surface = survey.surface;
  for (const std::uint32_t vertex : whole.unusual)
    if (is_pinched(mesh, surface.at(vertex), vertex)) survey.pinched.push_back(vertex);
  MeshBoundary boundary = find_boundary(mesh, surface, whole.unusual, components.of_triangle);
  if (settings.has_point_normals)
    for (BoundaryVertex& known : boundary.vertices)
      known.normal = mesh.vertices.normals[known.vertex];
  FillOptions kept = options;
  kept.min_triangles = least;  // a mesh that is given keeps its crumbs
  survey.fans = boundary.fans;
  FlapsToTake to_take{survey.surface, survey.fans};
  survey.plan =
      plan_holes(std::move(boundary.fans), std::move(boundary.vertices), components.pieces, kept,
                 settings.stop, settings.takes_flaps ? &to_take : nullptr);
  survey.flaps = std::move(to_take.flaps);
  if (!survey.flaps.triangles.empty()) {
    give_up(survey.flaps.triangles, mesh, survey.keep);
    survey.surface = MeshSurface(mesh, survey.keep);
    std::stable_sort(survey.fans.begin(), survey.fans.end(),
                     [](const OpenFan& a, const OpenFan& b) { return a.vertex < b.vertex; });
  }
  // Ids go on after those that the mesh has already.
  if (const std::int32_t last = last_id(mesh); has_room_for_ids(mesh, last))
    survey.plan.first_id += last;
  return survey;
}

/// Takes small pieces out; what is known of the mesh that is left.
MeshSurvey drop_small_pieces(TriangleMesh& mesh, const FillOptions& options,
                             const StopToken* stop) {
  MeshSurvey survey(mesh);
  const std::vector<std::uint8_t> is_removed = small_pieces(mesh, survey, options, stop);
  if (std::find(is_removed.begin(), is_removed.end(), 1) == is_removed.end()) return survey;
  mesh = without_pieces(std::move(mesh), survey.components, is_removed);
  return MeshSurvey(mesh);
}

void remove_triangles(std::span<const std::uint8_t> keep, FilledMesh& filled) {
  if (keep.empty()) return;
  TriangleMesh& mesh = filled.mesh;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (keep[t] == 0) continue;
    if (!mesh.hole.empty()) mesh.hole[kept] = mesh.hole[t];
    mesh.triangles[kept++] = mesh.triangles[t];
  }
  filled.triangles_removed = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  if (!mesh.hole.empty()) mesh.hole.resize(kept);
}

/// Throws where 32 bits do not number what the patches add as well.
void require_room(const TriangleMesh& mesh, std::span<const LoopPatch> patches,
                  std::span<const LoopPatch> mending) {
  std::uint64_t vertices = mesh.vertices.size(), triangles = mesh.triangles.size();
  for (const std::span<const LoopPatch> list : {patches, mending}) {
    for (const LoopPatch& patch : list) {
      vertices += patch.positions.size();
      triangles += patch.triangles.size();
    }
  }
  require_mesh_in_core({}, vertices, triangles);
}

void append(const LoopPatch& patch, std::int32_t id, TriangleMesh& mesh) {
  const std::uint64_t base = mesh.vertices.size();
  mesh.vertices.append(
      patch_vertices(mesh.vertices.schema, patch.positions, patch.normals, patch.values));
  for (const Triangle64& t : patch.triangles) {
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      triangle[k] =
          static_cast<std::uint32_t>(t[k] < kNewVertex ? t[k] : base + (t[k] - kNewVertex));
    }
    mesh.triangles.push_back(triangle);
    mesh.hole.push_back(id);
  }
}

Box box_of(const TriangleMesh& mesh, const LoopPatch& patch) {
  Box box;
  for (const Triangle64& t : patch.triangles)
    for (const std::uint64_t v : t)
      box.extend(v < kNewVertex ? mesh.vertices.positions[v] : patch.positions[v - kNewVertex]);
  return box;
}

/// Pairs of holes whose patches cross, sorted. A hole is filled from its neighbourhood alone. Only
/// the surface near patches is looked at.
std::vector<HolePair> crossing_holes(const TriangleMesh& mesh, std::span<const std::uint8_t> keep,
                                     std::span<const LoopPatch> patches, const StopToken* stop) {
  const std::vector<Vec3>& points = mesh.vertices.positions;
  std::vector<Box> places;
  for (const LoopPatch& patch : patches)
    if (!patch.triangles.empty()) places.push_back(box_of(mesh, patch));
  std::vector<Triangle64> near;
  std::vector<std::int32_t> hole;
  for (const std::uint32_t t :
       numbers_near(static_cast<std::uint32_t>(mesh.triangles.size()), BoxTree(places),
                    [&](std::uint32_t t) { return box_of(points, mesh.triangles[t]); })) {
    const Triangle& corners = mesh.triangles[t];
    if (keep.empty() || keep[t] != 0) near.push_back({corners[0], corners[1], corners[2]});
  }
  hole.resize(near.size(), 0);
  std::vector<Vec3> added;
  for (const LoopPatch& patch : patches) {
    for (const Triangle64& t : patch.triangles) {
      Triangle64& triangle = near.emplace_back(t);
      for (std::uint64_t& vertex : triangle) vertex += vertex < kNewVertex ? 0 : added.size();
      hole.push_back(patch.facts.id);
    }
    added.insert(added.end(), patch.positions.begin(), patch.positions.end());
  }
  std::vector<std::uint64_t> vertices;
  for (const Triangle64& t : near)
    for (const std::uint64_t vertex : t)
      if (vertex < kNewVertex) vertices.push_back(vertex);
  tbb::parallel_sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Vec3> positions;
  positions.reserve(vertices.size() + added.size());
  for (const std::uint64_t vertex : vertices) positions.push_back(points[vertex]);
  positions.insert(positions.end(), added.begin(), added.end());
  std::vector<Triangle> triangles;
  triangles.reserve(near.size());
  for (const Triangle64& t : near) {
    Triangle& triangle = triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const auto known = std::lower_bound(vertices.begin(), vertices.end(), t[k]);
      triangle[k] = static_cast<std::uint32_t>(
          t[k] < kNewVertex ? static_cast<std::uint64_t>(known - vertices.begin())
                            : vertices.size() + (t[k] - kNewVertex));
    }
  }
  return holes_of_pairs(crossing_pairs(positions, triangles, {UINT32_MAX, hole}, stop), hole);
}

/// What is to be mended of the mesh, and done.
Mended mend(const TriangleMesh& mesh, const Survey& survey, std::span<const LoopPatch> patches,
            const FillOptions& options, const StopToken* stop) {
  if (options.allow_intersections) return {};
  std::vector<HoleFacts> holes;
  std::vector<Box> boxes;
  for (const LoopPatch& patch : patches) {
    holes.push_back(patch.facts);
    boxes.push_back(box_of(mesh, patch));
  }
  const std::vector<std::uint64_t> pinched(survey.pinched.begin(), survey.pinched.end());
  const Faults faults{open_loops_of_solids(survey.plan, holes),
                      pinches_of_solids(survey.plan, pinched, survey.fans)};
  if (faults.loops.empty() && faults.pinched.empty()) return {};
  const BoxTree tree(mesh.vertices.positions, mesh.triangles);
  const auto scanned_near = [&](const Box& box, std::vector<Triangle64>& out) {
    tree.for_each(box, [&](std::uint32_t t) {
      const Triangle& corners = mesh.triangles[t];
      if (survey.keep.empty() || survey.keep[t] != 0)
        out.push_back(smallest_first(Triangle64{corners[0], corners[1], corners[2]}));
      return true;
    });
  };
  const auto patch_of = [&](std::size_t l) { return patches[l]; };
  const FilledSurface filled{
      survey.surface,       scanned_near,          survey.plan.loops, holes,
      survey.plan.first_id, survey.plan.is_wanted, std::move(boxes),  patch_of};
  return mend_solids(filled, faults, options, stop);
}

/// Takes out what mending gave up: triangles by `keep`, patches from their list. The patches that
/// mended come last in it.
void apply(const Mended& mended, const TriangleMesh& mesh, std::int32_t first_id,
           std::vector<std::uint8_t>& keep, std::vector<LoopPatch>& patches) {
  give_up(mended.taken, mesh, keep);
  for (std::size_t l = 0; l < mended.is_replaced.size(); ++l)
    if (mended.is_replaced[l] != 0) patches[l] = {};
  const auto set_facts = [&](const HoleFacts& facts) {
    const auto l = static_cast<std::size_t>(facts.id - first_id);
    if (l >= patches.size()) patches.resize(l + 1);
    patches[l].facts = facts;
  };
  for (const LoopPatch& patch : mended.patches) set_facts(patch.facts);
  for (const HoleFacts& facts : mended.joined) set_facts(facts);
}

/// Takes vertices out; triangles and holes get the numbers of those that are left.
void remove_vertices(std::span<const std::uint64_t> some, std::span<const std::uint64_t> others,
                     FilledMesh& filled) {
  TriangleMesh& mesh = filled.mesh;
  if (some.empty() && others.empty()) return;
  std::vector<std::uint8_t> is_kept(mesh.vertices.size(), 1);
  for (const std::uint64_t vertex : some) is_kept[vertex] = 0;
  for (const std::uint64_t vertex : others) is_kept[vertex] = 0;
  std::vector<std::uint32_t> number(is_kept.size());
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < is_kept.size(); ++v) {
    number[v] = count;
    count += is_kept[v];
  }
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& vertex : t) vertex = number[vertex];
  for (HoleFacts& hole : filled.holes) hole.first_vertex = number[hole.first_vertex];
  PointCloud kept;
  kept.schema = mesh.vertices.schema;
  for (std::size_t v = 0; v < is_kept.size(); ++v)
    if (is_kept[v] != 0) kept.append(mesh.vertices, v);
  mesh.vertices = std::move(kept);
}

/// Leaves holes open whose patches cross the mesh or the patches of others.
void drop_crossing_patches(const TriangleMesh& mesh, std::span<const std::uint8_t> keep,
                           const HolePlan& plan, std::span<LoopPatch> patches,
                           const StopToken* stop) {
  const DroppedHoles dropped = patches_to_drop(crossing_holes(mesh, keep, patches, stop));
  for (std::size_t l = 0; l < patches.size(); ++l) {
    const HoleFacts& facts = patches[l].facts;
    const auto found = dropped.find(facts.joined_to != 0 ? facts.joined_to : facts.id);
    if (found == dropped.end()) continue;
    patches[l] = {};
    patches[l].facts = plan.facts_of(l);
    patches[l].facts.reason = found->second;
  }
}

/// Given vertices whose triangles may be others after the fill, or which were pinched before.
std::vector<std::uint32_t> changed_vertices(const TriangleMesh& mesh, const Survey& survey,
                                            std::span<const LoopPatch> patches,
                                            std::span<const LoopPatch> mending) {
  std::vector<std::uint32_t> changed = survey.pinched;
  const auto add_rims = [&](std::span<const LoopPatch> list) {
    for (const LoopPatch& patch : list)
      for (const Triangle64& t : patch.triangles)
        for (const std::uint64_t vertex : t)
          if (vertex < kNewVertex) changed.push_back(static_cast<std::uint32_t>(vertex));
  };
  add_rims(patches);
  add_rims(mending);
  for (std::size_t t = 0; t < survey.keep.size(); ++t)
    if (survey.keep[t] == 0)
      changed.insert(changed.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
  return changed;
}

/// Doubles vertices where several fans are left. Only these are looked at.
void split_pinches(std::span<const std::uint32_t> vertices, FilledMesh& filled) {
  const VertexStars stars(filled.mesh, vertices);
  std::vector<std::uint32_t> pinched;
  for (const std::uint32_t vertex : stars.vertices())
    if (is_pinched(filled.mesh, stars.at(vertex), vertex)) pinched.push_back(vertex);
  filled.pinches = pinched.size();
  filled.vertices_doubled = split_vertices(filled.mesh, stars, pinched);
}

}  // namespace

std::vector<HoleFacts> list_holes(const TriangleMesh& mesh, const FillOptions& options) {
  require_mesh_in_core({}, mesh.vertices.size(), mesh.triangles.size());
  return survey_of(mesh, MeshSurvey(mesh), options, {}).plan.all_facts();
}

void require_room_for_ids(const std::filesystem::path& file, const TriangleMesh& mesh) {
  const std::int32_t last = last_id(mesh);
  if (has_room_for_ids(mesh, last)) return;
  throw_bad_input("the ids of its filled holes leave no room for those of further holes",
                  {.file = file.string(),
                   .place = "property hole of the faces",
                   .found = std::to_string(last),
                   .expected = "ids that begin at 1, as orbweave writes them",
                   .advice = "Write the mesh without that property."});
}

FilledMesh fill_mesh(TriangleMesh mesh, const FillOptions& options,
                     const FillMeshSettings& settings) {
  const StopToken* stop = settings.stop;
  require_mesh_in_core({}, mesh.vertices.size(), mesh.triangles.size());
  require_room_for_ids({}, mesh);
  Survey survey = survey_of(
      mesh, settings.drops_small_pieces ? drop_small_pieces(mesh, options, stop) : MeshSurvey(mesh),
      options, settings);
  const HolePlan& plan = survey.plan;
  std::vector<LoopPatch> patches(plan.loops.size());
  for (std::size_t l = 0; l < patches.size(); ++l) patches[l].facts = plan.facts_of(l);
  std::atomic<std::uint64_t> done{0};
  if (settings.progress) settings.progress(0, plan.groups.size());
  tbb::parallel_for(std::size_t{0}, plan.groups.size(), [&](std::size_t g) {
    check_stop(stop);
    std::vector<LoopPatch> group = fill_group(survey.surface, plan, plan.groups[g], options, stop);
    const std::vector<std::uint32_t> loops = plan.loops_of(plan.groups[g]);
    for (std::size_t i = 0; i < loops.size(); ++i) patches[loops[i]] = std::move(group[i]);
    if (settings.progress) settings.progress(done.fetch_add(1) + 1, plan.groups.size());
  });
  const bool any = std::any_of(patches.begin(), patches.end(),
                               [](const LoopPatch& patch) { return !patch.triangles.empty(); });
  if (any && !options.allow_intersections)
    drop_crossing_patches(mesh, survey.keep, plan, patches, stop);
  const Mended mended = mend(mesh, survey, patches, options, stop);
  if (!mended.empty()) apply(mended, mesh, plan.first_id, survey.keep, patches);
  std::vector<std::uint32_t> changed = changed_vertices(mesh, survey, patches, mended.patches);
  require_room(mesh, patches, mended.patches);
  auto new_vertex = static_cast<std::uint32_t>(mesh.vertices.size());
  FilledMesh filled;
  filled.mesh = std::move(mesh);
  filled.pieces_removed = survey.pieces_removed + mended.pieces_gone;
  filled.triangles_mended = mended.taken.size() + survey.flaps.triangles.size();
  remove_triangles(survey.keep, filled);
  filled.triangles_removed -= filled.triangles_mended;
  filled.mesh.hole.resize(filled.mesh.triangles.size(), 0);
  for (const std::uint32_t group : plan.groups) {
    for (const std::uint32_t l : plan.loops_of(group)) {
      append(patches[l], patches[l].facts.id, filled.mesh);
    }
  }
  for (const LoopPatch& patch : mended.patches) append(patch, patch.facts.id, filled.mesh);
  for (LoopPatch& patch : patches) filled.holes.push_back(std::move(patch.facts));
  for (; new_vertex < filled.mesh.vertices.size(); ++new_vertex) changed.push_back(new_vertex);
  split_pinches(changed, filled);
  remove_vertices(mended.freed, survey.flaps.freed, filled);
  return filled;
}

}  // namespace orbweave
