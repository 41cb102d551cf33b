// One hole, one patch: chooses the method and tries the next where one does not do.
// Abdel-Wahab, Hussein, Taha, Gaber: An Enhanced Algorithm for Surface Reconstruction from a Cloud
// of Points, GVIP 2005, section 3. docs/dev/hole-pass.md says what is done otherwise, and why.
#pragma once

#include <cstdint>

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// Fills a hole. Loops of at most options.direct_edges edges: by triangles between their corners
/// (direct_fill). Loops that touch themselves: in parts (fill_by_parts). Others by the first of
/// these that gives a sound patch clear of itself and of the gathered sheet: along planes that meet
/// in an edge (creased_fill), a membrane where the surface ends in a crease, over a plane
/// (plane_fill), a thin plate or the zero set of an implicit function (implicit_fill), a membrane,
/// triangles between the corners. Where none is clear, the two with the fewest contacts are moved
/// out of the way (untangle), and the better one is taken: whole if options.allow_intersections,
/// else its part that crosses nothing (sound_part), or none. A hole that calls for more points than
/// options.max_new_points stays open, and with options.whole one whose patch is wide and doubtful.
/// With options.in_scene a patch that folds back over the sheet (is_folded) is the last that is
/// taken, and says so. The result does not depend on where the loop begins. A pure function of its
/// arguments; never throws for what the hole is like: a loop that cannot be closed comes back with
/// FillMethod::kNone and a reason. Guarantees for a filled hole without open_edges: the patch's
/// boundary is the loop, edge by edge and against the sheet's direction. For every filled hole: no
/// edge inside is in `forbidden` or used by more than two triangles of the patch; given vertices
/// are used by index only.
HolePatch fill_hole(const HoleProblem& problem, const PatchOptions& options = {});

/// About how many new points a patch has at most, whose rim has so many edges: an estimate for the
/// memory that the hole takes.
std::uint64_t expected_new_points(std::uint64_t edges, bool graded);

}  // namespace orbweave
