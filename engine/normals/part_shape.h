// What the shape of a part of the cloud says about its sides.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/normals/orientation_graph.h"
#include "engine/normals/patch_sums.h"
#include "io/vec3.h"

namespace orbweave {

/// What a part is taken for.
enum class PartKind : std::uint8_t {
  kLandscape,  ///< open and mostly level: points up
  kSheet,      ///< open, and not level
  kShell       ///< encloses a volume
};

/// Of a part, as its votes orient it.
struct PartShape {
  std::uint32_t first = 0;  ///< its smallest row
  Vec3 center;              ///< of its bounds
  double area = 0.0;        ///< of its patches' area vectors, by size
  double surface = 0.0;     ///< of those that are surfaces; see surface_area
  Vec3 area_normal;
  double flux = 0.0;  ///< through it, of the vectors from the centre
  PartKind kind = PartKind::kShell;
  double openness = 0.0;  ///< size of the area vector per area: 0 closed, 1 a plane
  double bulge = 0.0;     ///< flux per area and half diagonal: positive where normals point outward
  bool is_tube = false;   ///< open at two ends across from each other
  bool is_box = false;    ///< level and upright planes, these at right angles to each other
};

/// All parts by their smallest row. `parts`: of the sums' rows; more rows are ignored.
std::vector<PartShape> shapes_of_parts(std::span<const PatchSum> sums, const SignedParts& parts);

/// Whether a part shows the wrong side, as its shape has it: a landscape points up, any other open
/// sheet up or else to positive y or x, a shell outward, or inward where that is asked.
bool shows_wrong_side(const PartShape& shape, bool inward);

}  // namespace orbweave
