// A cloud that a team counts and bins together: every member streams its own share of the rows,
// and what the members have to know of each other passes through the chunk store. What lies there
// also lets the next run go on, should this one be killed: how the points are cut once they are
// counted, what is binned part by part, what was measured once all of it is. docs/resume.md.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/pipeline/points/bin_log.h"
#include "engine/pipeline/points/cloud_input.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/spacing/automatic_radii.h"
#include "partition/published_bins.h"

namespace orbweave {

/// What the store holds of a cloud that is being cut. A team of one stores nothing unless its bins
/// spill.
struct CutExchange {
  /// How far an earlier run came.
  enum class Found : std::uint8_t { kNothing, kCounted, kBinned };

  std::string stage;  ///< of the store, with counts and bins
  std::string key;    ///< of the stage; the leader's alone
  int members = 1;    ///< whose logs are there
  Found found = Found::kNothing;
  bool keeps = false;  ///< bins go to the store: those of a team do, others where they spill
};

// Every member calls the functions that take a StageRunner, in the same order: those that a team
// needs include a meeting.

/// Finds what an earlier run left, and removes it where it is of no use.
CutExchange begin_cut(const CloudInput& input, StageRunner& runner);

/// The count that an earlier run, or the leader, stored.
CountedCloud stored_count(const CutExchange& cut, const StageRunner& runner);
/// A sampler that collects at the places that were chosen then.
SpacingSampler stored_sampler(const CutExchange& cut, const StageRunner& runner);

/// Shares as counted, in; the whole cloud, out.
CountedCloud whole_cloud(CountedCloud share, const CutExchange& cut, StageRunner& runner);
/// Stores the count for the next run, and the leader's octree for everybody: `cloud` gets it.
void keep_count(CutExchange& cut, CountedCloud& cloud, const SpacingSampler& sampler,
                StageRunner& runner);

/// The bins of this member.
BinLog own_log(const CutExchange& cut, const StageRunner& runner);
/// Returns when everybody's log is complete; `points_read` by this member where nothing is kept.
/// Throws Error (bad input) where not all of the cloud was read.
void await_bins(const CutExchange& cut, const CountedCloud& cloud, std::uint64_t points_read,
                StageRunner& runner);
/// The leader's sampler gets the points of all others'.
void gather_samples(const CutExchange& cut, const StageRunner& runner, SpacingSampler& sampler);
/// Returns to everybody what the leader knows of the points before they are sorted.
Partition agreed_partition(const CutExchange& cut, const Partition& partition, StageRunner& runner);
/// The same as an earlier run left it.
Partition measured_partition(const CutExchange& cut, const StageRunner& runner);
/// Where everybody's bins lie.
std::unique_ptr<PublishedBins> all_bins(const CutExchange& cut, const StageRunner& runner,
                                        const PointSchema& schema);

}  // namespace orbweave
