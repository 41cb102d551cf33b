// One loop of a stitched mesh from what is around it to its patch, in the mesh's own numbers.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/holes/loops/hole_choice.h"
#include "engine/holes/loops/shared_vertices.h"
#include "engine/holes/patch/rim_flaps.h"
#include "engine/holes/problem/boundary_loop.h"
#include "engine/holes/problem/hole.h"
#include "engine/holes/problem/surface.h"
#include "io/hole_facts.h"
#include "io/surface_options.h"

namespace orbweave {

/// Vertex numbers of patch triangles from here on are new vertices of the patch.
inline constexpr std::uint64_t kNewVertex = std::uint64_t{1} << 63;

struct LoopPatch {
  std::vector<Vec3> positions;  ///< new vertices
  std::vector<Vec3> normals;
  std::vector<double> values;  ///< new vertices x channels
  std::vector<Triangle64> triangles;
  HoleFacts facts;  ///< all but chunks
};

/// How a loop is filled, beside what the job's options say.
struct LoopManner {
  bool flat = false;      ///< PatchOptions::flat
  bool whole = false;     ///< PatchOptions::whole, unless intersections are allowed
  bool in_scene = false;  ///< PatchOptions::in_scene
};

/// One loop alone, from what is around it. `apart`: vertices that its patch must not join, as
/// for gather_hole(). `known`: what is known of the loop. `stop` may be null.
LoopPatch fill_loop(const Surface& surface, const BoundaryLoop& loop,
                    std::span<const std::array<std::uint64_t, 2>> apart, const HoleFacts& known,
                    const FillOptions& options, const StopToken* stop,
                    const LoopManner& manner = {});

/// The loops of a mesh and what is to become of them.
struct HolePlan {
  std::vector<BoundaryVertex> vertices;  ///< of holes with islands and of these, ascending
  std::vector<BoundaryLoop> loops;
  std::vector<std::string> reasons;  ///< per loop: why it stays open; empty: it is to be filled
  std::vector<OpenReason> open;      ///< per loop: the option that decided
  std::int32_t first_id = 1;         ///< of the first loop
  std::vector<std::vector<std::uint32_t>> islands;  ///< per loop: loops of islands in it
  SharedVertices shared;                            ///< by the loops
  std::vector<std::uint32_t> groups;  ///< loops to be filled, without islands of others
  /// Per piece, whether it is to be removed (find_crumbs); its loops are not among `loops`.
  std::vector<std::uint8_t> crumbs;
  std::vector<std::uint8_t> is_wanted;  ///< per loop, whether it is to be filled
  std::vector<std::uint8_t> is_scene;   ///< per piece, whether it is of one (pieces_of_scenes)
  bool is_of_solid(std::size_t loop) const;
  bool is_limited = false;  ///< whether widths of holes in open scenes are limited
  LoopManner manner_of(std::size_t loop) const;
  /// Whether the largest piece is a closed object. Small closed pieces of a scene are not mended:
  /// they are leaves and clutter, and attempts at them took a tenth of a job.
  bool is_object = true;

  /// A group's loops: the hole, then its islands.
  std::vector<std::uint32_t> loops_of(std::uint32_t hole) const;
  /// A loop's measures, and the reason where it stays open.
  HoleFacts facts_of(std::size_t loop) const;
  /// Those of all loops.
  std::vector<HoleFacts> all_facts() const;
};
/// For plans that take flaps (rim_flaps.h) off the rims of an open scene.
struct FlapsToTake {
  const Surface& surface;      ///< of the boundary; still has the flaps afterwards
  std::vector<OpenFan>& fans;  ///< of the boundary; without them afterwards
  RimFlaps flaps = {};         ///< what was taken
};
/// Crumbs are looked for where FillOptions::min_triangles names no number. `to_take`: null where
/// the triangles stay as they are. `stop`, which may be null, is looked at several times a second.
HolePlan plan_holes(std::vector<OpenFan> fans, std::vector<BoundaryVertex> vertices,
                    std::span<const Piece> pieces, const FillOptions& options,
                    const StopToken* stop = nullptr, FlapsToTake* to_take = nullptr);

/// Gathers the neighbourhood and fills the hole, joining its islands where that is possible. One
/// result per loop of the group; a joined island's has no triangles of its own. The results depend
/// on the mesh alone. `stop`, which may be null, is looked at several times a second.
std::vector<LoopPatch> fill_group(const Surface& surface, const HolePlan& plan, std::uint32_t hole,
                                  const FillOptions& options, const StopToken* stop = nullptr);

}  // namespace orbweave
