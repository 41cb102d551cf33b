// A hole's rim: the sheet's faces along it, and how a triangulated disc becomes its patch.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The rim corner by corner. Positions are relative to `center`, so that a hole far from the
/// origin loses nothing.
struct Rim {
  Vec3 center;           ///< mean of the corners, world
  double spacing = 0.0;  ///< mean length of the edges
  double radius = 0.0;   ///< largest distance of a corner from the centre
  std::vector<Vec3> corners;
  /// Unit normals of the sheet's faces behind edges (i, i + 1); zero where there is none (an edge
  /// that the loop uses in both directions) or the face has no area.
  std::vector<Vec3> face_normals;
  /// The sheet's triangles that have two vertices on the rim at least, in the sheet's order.
  std::vector<Triangle> faces;
};
Rim find_rim(const HoleProblem& problem);

/// The mean of the loop's corners.
Vec3 center_of_loop(const HoleProblem& problem);

/// The triangles of the sheet that have a corner. It is not whole at corners of a vertex that the
/// loop visits several times: which triangles belong to which visit is not asked.
RimSheet sheet_at_rim(const HoleProblem& problem, const Rim& rim);

/// A patch from a disc whose corners are the loop's: triangles in the problem's numbers, the new
/// vertices that they use, and the faces' normals at these. Method and reason are left to the
/// caller.
HolePatch patch_of_disc(const HoleProblem& problem, const Rim& rim, std::span<const Vec3> positions,
                        std::span<const CornerTriangle> triangles);
HolePatch patch_of_disc(const HoleProblem& problem, const Rim& rim, const PatchMesh& disc);
/// The same, without normals.
HolePatch shape_of_disc(const HoleProblem& problem, const Rim& rim, const PatchMesh& disc);

/// Angles between the faces behind the rim and the patch's faces before it, radians.
struct RimAngles {
  double largest = 0.0;
  double mean = 0.0;
};
RimAngles rim_angles(const HoleProblem& problem, const HolePatch& patch);
/// The same; `rim_faces` as Rim::faces.
RimAngles rim_angles(const HoleProblem& problem, std::span<const Triangle> rim_faces,
                     const HolePatch& patch);

/// Unit normals of the patch's new vertices from its faces, weighted by area.
std::vector<Vec3> normals_of_patch(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave
