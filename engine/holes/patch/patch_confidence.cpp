#include "engine/holes/patch/patch_confidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace orbweave {

double patch_confidence(const PatchEvidence& evidence) {
  constexpr double kHalfRight = 60.0;  // width of holes of which half are right
  constexpr double kOfTurn = 0.15;     // of the width that a turned rim may lead astray by
  constexpr double kMostAngle = 0.9 * std::numbers::pi;
  const double of_width = evidence.width / kHalfRight;
  const double turn = std::tan(0.5 * std::min(evidence.rim_angle, kMostAngle));
  const double of_turn = kOfTurn * evidence.width * turn;
  const double error = of_width * of_width + of_turn * of_turn;
  return (1.0 - evidence.open_share) / (1.0 + error);
}

}  // namespace orbweave
