#include "engine/options/hole_options.h"

namespace orbweave {

HoleOptions hole_options(const FillOptions& fill) {
  return {.kernel = fill.kernel == FillKernel::kBiharmonic ? RbfKernel::kBiharmonic
                                                           : RbfKernel::kTriharmonic,
          .neighborhood = fill.neighborhood,
          .max_diameter = fill.max_diameter,
          .max_perimeter = fill.max_perimeter,
          .max_edges = fill.max_edges,
          .allow_intersections = fill.allow_intersections,
          .keep_outer_border = fill.keep_outer_border,
          .min_triangles = fill.min_triangles};
}

}  // namespace orbweave
