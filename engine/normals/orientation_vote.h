// What a point says about the sign of a neighbour's normal.
#pragma once

#include "io/vec3.h"

namespace orbweave {

/// The normal at p, reflected in the plane that is perpendicular to the edge to q, times the
/// normal at q: the sign that agrees if the surface between them is an arc. Two sheets back to back
/// vote to be opposite. Edges that leave both tangent planes count less, by the squared cosines:
/// there layers of one sheet, scanned twice, look like two sheets. In [-1, 1]; sizes well below 1
/// where no arc fits. `q_p`: q - p.
inline double vote(Vec3 normal_p, Vec3 normal_q, Vec3 q_p) {
  const double squared = squared_norm(q_p);
  if (!(squared > 0.0)) return 0.0;
  const double along_p = dot(normal_p, q_p), along_q = dot(normal_q, q_p);
  const double agreement = dot(normal_p, normal_q) - 2.0 * along_p * along_q / squared;
  return agreement * (1.0 - along_p * along_p / squared) * (1.0 - along_q * along_q / squared);
}

}  // namespace orbweave
