// How much a patch can be relied on.
#pragma once

namespace orbweave {

/// What is known of a patch without the surface that it stands for.
struct PatchEvidence {
  /// Of the hole, in mean lengths of its edges: four times the area by the perimeter. The middle
  /// of the patch is half as far from the nearest point of the scan.
  double width = 0.0;
  /// Mean angle between the faces behind the rim and those of the patch before it, radians. Small
  /// where the surface goes on; large where it ends in a crease or the rim is crumpled, so that
  /// the patch is no continuation.
  double rim_angle = 0.0;
  double open_share = 0.0;  ///< of the rim's edges, at which the patch is open
};

/// From 0 to 1: about the share of such patches whose points are two spacings or less from the
/// surface, by their root mean square. Fitted to discs that were cut out of meshes of scans
/// (docs/holes.md).
double patch_confidence(const PatchEvidence& evidence);

}  // namespace orbweave
