// A point with a weight: a ball by its centre and its squared radius.
#pragma once

#include "io/vec3.h"

namespace orbweave::voronoi {

struct WeightedVec {
  Vec3 position;
  double weight = 0.0;
};

}  // namespace orbweave::voronoi
