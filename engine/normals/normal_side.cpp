#include "engine/normals/normal_side.h"

namespace orbweave {

Orientation side_of_normals(const NormalOptions& options, std::uint64_t points_without_view) {
  const bool ground = options.orientation == Orientation::kGround;
  if (options.orientation != Orientation::kAuto && !ground) return options.orientation;
  if (points_without_view == 0) return Orientation::kScanner;
  if (options.viewpoint) return Orientation::kViewpoint;
  if (ground) return Orientation::kGround;
  return options.up ? Orientation::kUp : Orientation::kPropagate;
}

bool asks_for_scanner(Orientation rule) {
  return rule == Orientation::kAuto || rule == Orientation::kGround ||
         rule == Orientation::kScanner;
}

bool is_propagated(Orientation rule) {
  return rule == Orientation::kPropagate || rule == Orientation::kGround ||
         rule == Orientation::kInward;
}

PatchGraphOptions graph_options(Orientation rule, const NormalOptions& options,
                                const OrientationOptions& patches) {
  return {.inward = rule == Orientation::kInward,
          .ground = rule == Orientation::kGround,
          .up = normalized(options.up.value_or(Vec3{0.0, 0.0, 1.0})),
          .cell = patches.cell,
          .stop = patches.stop};
}

}  // namespace orbweave
