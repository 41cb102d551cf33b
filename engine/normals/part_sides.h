// Which side a part of the cloud shows that no vote connects with another one, and whether that is
// known or guessed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/normals/free_space.h"
#include "engine/normals/orientation_graph.h"
#include "engine/normals/patch_sums.h"
#include "engine/normals/scanner_density.h"
#include "io/stop_token.h"

namespace orbweave {

/// What a part is taken for.
enum class PartKind : std::uint8_t {
  kLandscape,  ///< open and mostly level: points up
  kSheet,      ///< open, and not level: which side is seen is a guess
  kShell,      ///< encloses a volume: points outward
  kInterior    ///< encloses a volume, and free space says that it was seen from there
};

struct OrientedPart {
  std::uint32_t first = 0;  ///< its smallest row
  Vec3 center;              ///< of its bounds
  double area = 0.0;        ///< sum of the sizes of its patches' area vectors
  PartKind kind = PartKind::kShell;
  bool is_turned = false;    ///< against the signs that its votes gave it
  bool is_doubtful = false;  ///< the side is a guess
  double openness = 0.0;     ///< size of the area vector per area
  double bulge = 0.0;  ///< flux per area and half diagonal of the bounds, as oriented in the end
  PartSpace space;     ///< as oriented before free space was asked; empty for small parts
  DensityFit density;  ///< of shells that free space says nothing about
};

struct PartSideOptions {
  double cell = 0.0;                ///< OrientationOptions::cell
  bool inward = false;              ///< closed surfaces point inward, whatever free space says
  bool looks_for_interiors = true;  ///< free space is asked
  const StopToken* stop = nullptr;
};

/// All parts by their smallest row. `parts`: of the sums' rows; more rows are ignored. What
/// is_settled (by the smallest row) has its sides already: it is not turned, and others may follow
/// it.
std::vector<OrientedPart> sides_of_parts(std::span<const PatchSum> sums, const SignedParts& parts,
                                         std::span<const std::uint8_t> is_settled,
                                         const PartSideOptions& options);

}  // namespace orbweave
