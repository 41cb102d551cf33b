#include "engine/holes/patch/patch_confidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "engine/holes/patch/crease.h"
#include "engine/holes/patch/rim.h"

namespace orbweave {

double patch_confidence(const PatchEvidence& evidence) {
  // Widths of holes in smooth surfaces of which half are right.
  constexpr double kHalfRight = 60.0, kHalfRightOfObject = 80.0;
  constexpr double kOfTurn = 0.15;       // of the width that a turned rim may lead astray by
  constexpr double kOfRoughness = 0.1;   // of the width, by the roughness
  constexpr double kRoughestPane = 1.0;  // roughness of panes of which half are right
  constexpr double kMostAngle = 0.9 * std::numbers::pi;
  if (evidence.is_pane) {
    const double of_roughness = evidence.roughness / kRoughestPane;
    return 1.0 / (1.0 + of_roughness * of_roughness);
  }
  const double of_width = evidence.width / (evidence.in_object ? kHalfRightOfObject : kHalfRight);
  const double turn = std::tan(0.5 * std::min(evidence.rim_angle, kMostAngle));
  const double of_turn = kOfTurn * evidence.width * turn;
  const double of_roughness =
      evidence.in_object ? 0.0 : kOfRoughness * evidence.width * evidence.roughness;
  return 1.0 / (1.0 + of_width * of_width + of_turn * of_turn + of_roughness * of_roughness);
}

PatchEvidence evidence_of(const HoleProblem& problem, const HolePatch& patch) {
  const double spacing = rim_spacing(problem);
  const double length = spacing * static_cast<double>(problem.loop.size());
  const RimShape rim = rim_shape(problem);
  PatchEvidence evidence{.width = 4.0 * area_of(problem, patch) / (length * spacing),
                         .rim_angle = rim_angles(problem, patch).mean,
                         .roughness = rim.roughness,
                         .is_pane = patch.is_flat && rim.is_in_wall};
  if (!evidence.is_pane) return evidence;
  if (const std::optional<RecessedPlane> recess = recessed_plane(problem))
    evidence.roughness = std::min(evidence.roughness, roughness_of_recess(problem, *recess));
  return evidence;
}

}  // namespace orbweave
