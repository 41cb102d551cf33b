// What is known of a hole and of the patch that closes it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/open_reason.h"
#include "io/vec3.h"

namespace orbweave {

/// A patch of less confidence is doubtful: as likely wrong as right.
inline constexpr double kDoubtful = 0.5;

/// A boundary loop of the stitched mesh and what became of it.
struct HoleFacts {
  std::int32_t id = 0;             ///< rank among all loops, from 1; the faces' `hole`
  std::uint64_t first_vertex = 0;  ///< smallest vertex of the loop, in the output's numbers
  std::uint64_t edges = 0;
  double perimeter = 0.0;             ///< world units
  double diameter = 0.0;              ///< of the ball around the loop's centre, world units
  Vec3 center;                        ///< mean of the loop's vertices
  std::vector<std::uint32_t> chunks;  ///< that the loop's vertices lie in, ascending
  bool filled = false;
  std::int32_t joined_to = 0;  ///< of an island: the hole whose patch it bounds as well; 0: none
  std::string method;          ///< "direct", "plane", "implicit" or "creased"; empty: stays open
  std::string reason;          ///< why it stays open, or why the simpler method did not do
  OpenReason open = OpenReason::kNone;  ///< what keeps it open, where that is known
  std::uint64_t sites = 0;              ///< of the interpolant
  std::uint64_t points_added = 0;
  std::uint64_t triangles_added = 0;
  double area = 0.0;  ///< of the patch, square world units
  /// Edges at which a filled hole is open, because every patch would cross the surface there.
  std::uint64_t open_edges = 0;
  double residual = 0.0;          ///< largest distance of a site from the interpolant
  double condition = 0.0;         ///< of the linear system, estimated; 0: none was solved
  double rim_dihedral_deg = 0.0;  ///< largest angle between a patch face and the face at the rim
  double rim_mean_deg = 0.0;      ///< mean of these angles
  /// Of the patch, from 0 to 1 (docs/holes.md); 0 where the hole stays open.
  double confidence = 0.0;
  double seconds = 0.0;
};

}  // namespace orbweave
