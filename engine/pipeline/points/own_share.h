// The rows of a cloud that one member of a team reads.
#pragma once

#include <cstdint>
#include <memory>

#include "io/points/point_source.h"
#include "partition/communicator.h"

namespace orbweave {

/// The member's share of a source's rows but the first `read_before` points of it. Where the input
/// has no rows to be shared (text, compressed files alone), the leader gets all of it and the
/// others nothing. `rows_are_points`: every row declared holds a point.
std::unique_ptr<PointSource> own_share(std::unique_ptr<PointSource> source,
                                       const Communicator& communicator,
                                       std::uint64_t read_before = 0, bool rows_are_points = false);

}  // namespace orbweave
