// A cloud that a team counts and bins together: every member streams its own share of the rows,
// and what the members have to know of each other passes through the chunk store. What lies there
// also lets the next run go on, should this one be killed: how the points are cut once they are
// counted, what is binned part by part, what was measured once all of it is. docs/resume.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "engine/ball_pivoting/automatic_radii.h"
#include "engine/pipeline/bin_log.h"
#include "engine/pipeline/partition_stage.h"
#include "partition/published_bins.h"

namespace orbweave {

/// The stage of the store that holds counts and bins of the points that `stage` is to hold.
std::string cut_stage_of(const std::string& stage);

/// The member's share of a source's rows but the first `read_before` points of it. Where the input
/// has no rows to be shared (text, compressed files alone), the leader gets all of it and the
/// others nothing. `rows_are_points`: every row declared holds a point.
std::unique_ptr<PointSource> own_share(std::unique_ptr<PointSource> source, const Team& team,
                                       std::uint64_t read_before = 0, bool rows_are_points = false);

/// What members tell each other, and the next run, while they cut one cloud. Every member calls the
/// same methods in the same order; those that a team needs include a meeting. A team of one leaves
/// nothing in the store unless its bins spill.
class CutExchange {
 public:
  /// How far an earlier run came.
  enum class Found { kNothing, kCounted, kBinned };

  /// Finds what an earlier run left, and removes it where it is of no use.
  CutExchange(JobContext& context, const CloudInput& input);

  Found found() const { return found_; }
  /// What was kept of the count, whoever made it.
  CountedCloud counted() const;
  /// Collects at the places that were chosen then.
  SpacingSampler sampler() const;

  /// Shares as counted, in; the whole cloud, out.
  CountedCloud whole_cloud(CountedCloud share);
  /// Keeps the count for the next run, and the leader's octree for everybody.
  void keep_count(CountedCloud& cloud, const SpacingSampler& sampler);
  /// Whether bins go to the store: those of a team do, others where they spill.
  bool keeps() const { return kept_; }

  /// Of this member.
  BinLog own_log() const { return log_of(context_.team.rank()); }
  /// Returns when everybody's log is complete; `points_read` by this member where nothing is kept.
  /// Throws Error (bad input) where not all of the cloud was read.
  void await_bins(const CountedCloud& cloud, std::uint64_t points_read);
  /// The leader's sampler gets the points of all others'.
  void gather_samples(SpacingSampler& sampler) const;
  /// What the leader knows of the points before they are sorted.
  Partition agreed_partition(const Partition& partition);
  /// The same as an earlier run left it.
  Partition measured() const;
  /// Where everybody's bins lie.
  std::unique_ptr<PublishedBins> all_bins(const PointSchema& schema) const;

 private:
  bool alone() const { return context_.team.size() == 1; }
  Found examine(const std::string& key);
  bool bins_are_whole() const;
  BinLog log_of(int rank) const;
  ChunkId sites_number() const { return static_cast<ChunkId>(members_ + 1); }
  /// Puts the cells of all shares together, some at a time.
  CountedCloud gather_counts();
  void commit_count(const CountedCloud& cloud, const SpacingSampler& sampler);

  JobContext& context_;
  std::string stage_;
  std::string key_;
  int members_;  ///< whose logs are there
  Found found_ = Found::kNothing;
  bool kept_ = false;
};

}  // namespace orbweave
