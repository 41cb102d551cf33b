// What the hole pass is about: a loop to close, what is known around it, and the patch that
// closes it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "io/open_reason.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

enum class RbfKernel { kBiharmonic, kTriharmonic };

/// How a hole is filled. World units where not said otherwise.
struct PatchOptions {
  RbfKernel kernel = RbfKernel::kBiharmonic;
  /// Loops of at most this many edges are closed without an interpolant.
  std::uint32_t direct_edges = 4;
  /// Most sites of a dense solve; above it centres are chosen greedily.
  std::uint32_t max_sites = 1200;
  /// Greedy centre choice ends when no site is further from the surface than this, in rim
  /// spacings.
  double tolerance = 0.01;
  /// Where every patch crosses the surface: the one that does so least is taken whole (true), or
  /// only its part that crosses nothing (false).
  bool allow_intersections = false;
  /// The loop stays open where every patch crosses the surface, instead of being closed in part:
  /// what is crossed stands in the gap, and what lies beside it is a guess. A flat patch of which
  /// at most one edge in four stays open closes the loop in part all the same. The loop also stays
  /// open where the patch is doubtful (kDoubtful) and 8 mean edge lengths wide or more, 16 where
  /// the rim is that of an opening in a wall (RimShape::is_in_wall), 24 where the patch is flat.
  bool whole = false;
  /// The hole is one of an open scene. A patch that folds back over the sheet around it
  /// (is_folded()) is taken only where every other does so, or crosses the surface, and its reason
  /// says so. What is missing lies in the shadow of something: a rough rim lowers the confidence.
  bool in_scene = false;
  /// A membrane or triangles between the corners, whatever a smooth patch would be.
  bool flat = false;
  /// Most new points of a hole; a larger one is reported and stays open.
  std::uint32_t max_new_points = 2'000'000;
  /// Whether triangles grow with their distance from the rim in a large patch.
  bool graded = true;
  const StopToken* stop = nullptr;  ///< looked at several times a second; may be null
};

/// The values of vertices of a problem, row by row in the order in which they are asked for.
using ValuesOf = std::function<std::vector<double>(std::span<const std::uint32_t>)>;

/// A loop and its neighbourhood. Vertices are numbered from 0 in canonical order, so that the
/// patch does not depend on how the neighbourhood was gathered.
struct HoleProblem {
  std::vector<Vec3> positions;  ///< rim and neighbourhood on the same sheet
  std::vector<Vec3> normals;    ///< unit, from the faces; zero where there is none
  std::vector<Triangle> sheet;  ///< triangles among them; all of those at rim vertices
  /// The rim in the direction in which patch triangles use its edges (against that of the
  /// triangles of the sheet); begins at the smallest corner. May visit a vertex several times.
  std::vector<std::uint32_t> loop;
  /// Edges (smaller vertex first, sorted) that a patch must not use inside, because the mesh has
  /// them already or another hole may use them.
  std::vector<std::array<std::uint32_t, 2>> forbidden;
  /// (vertex, group), sorted. A patch must not join two vertices of one group inside: the group is
  /// what another hole has in common with this one, and the patch of that hole may join them.
  std::vector<std::array<std::uint32_t, 2>> apart = {};
  /// What is to be interpolated to the new vertices: rows of `channels` values. Asked for only
  /// where there are new ones; not empty where there are channels.
  ValuesOf values_of;
  std::uint32_t channels = 0;
};

enum class FillMethod : std::uint8_t { kNone, kDirect, kPlane, kImplicit, kCreased };
const char* name_of(FillMethod method);  ///< "none", "direct", "plane", "implicit", "creased"

/// What closes a loop. Triangles use indices below problem.positions.size() for given vertices,
/// and from there on new ones.
struct HolePatch {
  FillMethod method = FillMethod::kNone;
  std::string reason;                   ///< why it stays open (kNone) or why not the simpler method
  OpenReason open = OpenReason::kNone;  ///< what keeps it open (kNone)
  std::vector<Vec3> positions;          ///< new vertices
  std::vector<Vec3> normals;            ///< unit, theirs
  std::vector<double> values;           ///< new vertices x channels
  /// There are none yet: they follow from the corners' (give_values()) once the patch is taken.
  bool lacks_values = false;
  std::vector<Triangle> triangles;  ///< oriented like the sheet
  std::uint32_t sites = 0;          ///< of the interpolant; 0: none was needed
  double residual = 0.0;            ///< largest distance of a site from it, world units
  double condition = 0.0;           ///< estimate for the linear system; 0: none
  double rim_dihedral_rad = 0.0;    ///< largest angle between a rim face and its patch face
  double rim_mean_rad = 0.0;        ///< mean of these angles
  /// A membrane over a rim at which the surface ends in a crease (FlatCall::is_crease); of a patch
  /// in parts, most of its area is.
  bool is_flat = false;
  double confidence = 0.0;  ///< how much it can be relied on (patch_confidence.h)
  /// Edges at which a filled hole is still open, because triangles there would cross the surface;
  /// 0: the patch closes the whole loop.
  std::uint32_t open_edges = 0;
};

/// The mean length of the loop's edges, world units.
double rim_spacing(const HoleProblem& problem);

/// Of a vertex of the problem, or of a new one behind these.
inline Vec3 position_of(const HoleProblem& problem, const HolePatch& patch, std::uint32_t v) {
  const std::size_t given = problem.positions.size();
  return v < given ? problem.positions[v] : patch.positions[v - given];
}

/// Twice the area vector of a triangle of such vertices.
inline Vec3 doubled_area(const HoleProblem& problem, const HolePatch& patch, const Triangle& t) {
  const Vec3 a = position_of(problem, patch, t[0]);
  return cross(position_of(problem, patch, t[1]) - a, position_of(problem, patch, t[2]) - a);
}

/// Of the patch's triangles, world units.
double area_of(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave
