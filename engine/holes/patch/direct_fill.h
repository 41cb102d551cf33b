// Closing a loop without an interpolant: by triangles between its corners, or about a new vertex.
#pragma once

#include <vector>

#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// A loop's rim, and triangles between its corners. Several methods start from them.
struct LoopTriangles {
  Rim rim;
  /// They use no edge twice or one that must not be used; none where none were found.
  std::vector<CornerTriangle> sound;
  /// Where none were found: those that use no edge twice.
  std::vector<CornerTriangle> loose;
};
LoopTriangles triangles_of_loop(const HoleProblem& problem);
LoopTriangles triangles_of_loop(const HoleProblem& problem, Rim rim);
/// Nearly the same, made in a fraction of the time where the loop is long: to look at, not to start
/// from.
LoopTriangles rough_triangles_of_loop(const HoleProblem& problem);

/// Triangles between the loop's corners where that is possible (triangulate_loop), else about one
/// new vertex in their middle, else (the loop visits a vertex twice) about a ring of them. For
/// loops of three edges or more this never fails; FillMethod::kNone with a reason for shorter
/// ones. Values of new vertices are means of the corners' values.
HolePatch direct_fill(const HoleProblem& problem);
HolePatch direct_fill(const HoleProblem& problem, const LoopTriangles& start);

/// Whether nothing but direct_fill is tried: the loop has few edges or no extent.
bool is_closed_directly(const HoleProblem& problem, const PatchOptions& options);

/// The disc to start from: triangles between the corners; where these cannot do without a chord
/// that must not be used, it is split at its middle; at last a fan about new vertices. No edge of
/// it is used twice over by the mesh's vertices, whatever the loop.
PatchMesh disc_of_loop(const HoleProblem& problem, const LoopTriangles& start);

}  // namespace orbweave
