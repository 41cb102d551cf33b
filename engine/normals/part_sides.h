// Which side a part of the cloud shows that no vote connects with another one, and whether that is
// known or guessed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/normals/free_space.h"
#include "engine/normals/orientation_graph.h"
#include "engine/normals/part_shape.h"
#include "engine/normals/patch_sums.h"
#include "engine/normals/scanner_density.h"
#include "io/stop_token.h"

namespace orbweave {

/// How the side of a part was found.
enum class PartSide : std::uint8_t {
  kShape,     ///< by the part's shape alone: up or outward
  kSettled,   ///< it was settled before: the ground's
  kInterior,  ///< free space or density says that the part was seen from its inside
  kFacing     ///< the part shows its front to an interior that it lies in
};

/// Why the side of a part is a guess.
enum class PartDoubt : std::uint8_t {
  kNone,
  kSheet,      ///< open and not level: both sides may have been seen
  kBowl,       ///< open, nearly closed: a valley or the outer side of a bowl
  kHalfOpen,   ///< neither open nor closed
  kTube,       ///< open at both ends: a pipe or a tunnel
  kBox,        ///< an even box: a block or an empty room
  kFreeSpace,  ///< what lies on both sides speaks for inside and for outside
  kNested      ///< lies within another part, or another part lies within it
};

struct OrientedPart {
  PartShape shape;
  PartSide side = PartSide::kShape;
  PartDoubt doubt = PartDoubt::kNone;
  bool is_turned = false;  ///< against the signs that its votes gave it
  PartSpace space;         ///< as oriented by shape; empty for small parts
  DensityFit density;      ///< of parts that free space does not decide
};

struct PartSideOptions {
  double cell = 0.0;    ///< OrientationOptions::cell; 0: free space is not asked
  bool inward = false;  ///< closed surfaces point inward, whatever free space says
  const StopToken* stop = nullptr;
};

/// All parts by their smallest row. `parts`: of the sums' rows; more rows are ignored. What
/// is_settled (by the smallest row) has its sides already: it is not turned.
std::vector<OrientedPart> sides_of_parts(std::span<const PatchSum> sums, const SignedParts& parts,
                                         std::span<const std::uint8_t> is_settled,
                                         const PartSideOptions& options);

}  // namespace orbweave
