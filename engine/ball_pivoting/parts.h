// Ball pivoting of points that lie too far apart for exact coordinates about one origin: in parts,
// each with its halo, as chunks are (docs/dev/halo.md), so that the parts' results are the whole's.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "engine/ball_pivoting/pivoting_result.h"
#include "io/box.h"
#include "io/stop_token.h"

namespace orbweave {

/// Points of equal number; `owned` may be empty: all.
struct PivotInput {
  std::span<const Vec3> positions;
  std::span<const Vec3> normals;
  std::span<const std::uint8_t> owned;
};

/// Calls `pivot` with points whose box, which it is given too, has no extent beyond `most`: with
/// all of `input`, or with parts of it whose owned points are disjoint. Returns the result for all.
/// `most` must be two halos or more. O(n log n), in memory for n points but for the halos; `stop`
/// may be null.
BallPivotingResult pivot_in_parts(
    const PivotInput& input, double halo_width, double most,
    const std::function<BallPivotingResult(const PivotInput&, const Box&)>& pivot,
    const StopToken* stop = nullptr);

}  // namespace orbweave
