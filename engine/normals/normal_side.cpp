#include "engine/normals/normal_side.h"

namespace orbweave {

Orientation side_of_normals(const NormalOptions& options, std::uint64_t points_without_view) {
  if (options.orientation != Orientation::kAuto) return options.orientation;
  if (points_without_view == 0) return Orientation::kScanner;
  if (options.viewpoint) return Orientation::kViewpoint;
  return options.up ? Orientation::kUp : Orientation::kPropagate;
}

}  // namespace orbweave
