// What a point says about the sign of a neighbour's normal.
#pragma once

#include "io/vec3.h"

namespace orbweave {

/// The normal at p, reflected in the plane that is perpendicular to the edge to q, times the
/// normal at q: the sign that agrees if the surface between them is an arc. Two sheets back to back
/// vote to be opposite. In [-1, 1]; sizes well below 1 where the arc does not fit.
/// `q_p`: q - p.
inline double agreement(Vec3 normal_p, Vec3 normal_q, Vec3 q_p) {
  const double squared = squared_norm(q_p);
  const double along =
      squared > 0.0 ? 2.0 * dot(normal_p, q_p) * dot(normal_q, q_p) / squared : 0.0;
  return dot(normal_p, normal_q) - along;
}

/// A vote counts by the cube of the agreement.
inline double vote(Vec3 normal_p, Vec3 normal_q, Vec3 q_p) {
  const double a = agreement(normal_p, normal_q, q_p);
  return a * a * a;
}

}  // namespace orbweave
