#include "engine/pipeline/stage/algorithm_options.h"

namespace orbweave {

PrepareOptions prepare_options(const CleaningChoice& choice) {
  PrepareOptions options;
  options.outlier_sigma = choice.outlier_sigma;
  options.smooth_radius = choice.smooth_radius;
  options.smooth_passes = choice.smooth_passes;
  options.thin_to_spacing = choice.thin_to_spacing;
  return options;
}

}  // namespace orbweave
