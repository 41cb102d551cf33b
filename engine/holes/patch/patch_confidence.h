// How much a patch can be relied on.
#pragma once

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// What is known of a patch without the surface that it stands for.
struct PatchEvidence {
  /// Four times the patch's area by the loop's length, in mean lengths of the loop's edges: of a
  /// disc the diameter. The middle of the patch is half as far from the nearest point of the scan.
  double width = 0.0;
  /// Mean angle between the faces behind the rim and those of the patch before it, radians. Small
  /// where the surface goes on; large where it ends in a crease or the rim is crumpled, so that
  /// the patch is no continuation.
  double rim_angle = 0.0;
  /// Root of the mean squared distance of the rim's corners from the rim's plane, in mean lengths
  /// of the loop's edges. Large where the rim runs over several surfaces, as the outline of a
  /// shadow does.
  double roughness = 0.0;
  /// The patch is flat and closes an opening in a wall: a pane. Neither its width nor the turn at
  /// the rim leads such a patch astray.
  bool is_pane = false;
  /// The hole is one of an object seen from all around: nothing else hides in it, and its rim is
  /// rough because the surface curves.
  bool in_object = false;
};

/// From 0 to 1: about the share of such patches whose points are two spacings or less from the
/// surface, by their root mean square. Fitted to discs that were cut out of meshes of scans, and to
/// rooms whose truth is known (docs/holes.md).
double patch_confidence(const PatchEvidence& evidence);

/// The evidence of a patch that closes its loop. Precondition: the loop has an extent.
PatchEvidence evidence_of(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave
