// The holes of a report in few words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/report/report_facts.h"

namespace orbweave {

/// How many, and what.
using Counted = std::vector<std::pair<std::string, std::uint64_t>>;
std::uint64_t sum_of(const Counted& counts);

/// What became of a list of loops.
struct HoleSummary {
  std::uint64_t loops = 0;
  std::uint64_t filled = 0;
  std::uint64_t open = 0;
  std::uint64_t partly = 0;      ///< of the filled ones, those that are open somewhere
  std::uint64_t open_edges = 0;  ///< of these
  std::uint64_t doubtful = 0;    ///< of the filled ones, those of little confidence
  double doubtful_area = 0.0;    ///< of their patches, square world units
  Vec3 most_doubtful;            ///< middle of the doubtful one with the largest patch
  Counted methods;               ///< of the filled ones, most frequent first
  /// Of the open ones, most frequent first. Loops that the same option keeps open count together,
  /// and reasons that differ in their numbers only.
  Counted reasons;
  std::uint64_t points_added = 0;
  std::uint64_t triangles_added = 0;
};
HoleSummary hole_summary(std::span<const HoleFacts> holes);

/// "3 direct, 2 plane": at most `most` of them, the rest as "4 others".
std::string counted_list(const Counted& counts, std::size_t most);

/// The `most` widest loops, the widest first, equally wide ones by id. O(n + most log most).
std::vector<const HoleFacts*> widest_holes(std::span<const HoleFacts> holes, std::size_t most);

}  // namespace orbweave
