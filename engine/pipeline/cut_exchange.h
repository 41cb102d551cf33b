// A cloud that a team counts and bins together: every member streams its own share of the rows,
// and what the members have to know of each other passes through the chunk store.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "engine/ball_pivoting/automatic_radii.h"
#include "engine/pipeline/partition_stage.h"
#include "partition/published_bins.h"

namespace orbweave {

/// The member's share of a source's rows. Where the input has no rows to be shared (text,
/// compressed files alone), the leader gets all of it and the others nothing.
std::unique_ptr<PointSource> own_share(std::unique_ptr<PointSource> source, const Team& team);

/// What members tell each other while they cut one cloud. All methods are called by every member,
/// in this order; each includes a meeting. A team of one tells nobody anything.
class CutExchange {
 public:
  /// `stage`: of the points; what is told lies in a stage of its own beside it. Removes what a
  /// team that was killed left there.
  CutExchange(JobContext& context, const std::string& stage);

  /// Shares as counted, in; the whole cloud, out.
  CountedCloud whole_cloud(CountedCloud share);
  /// How the leader has cut it.
  Octree agreed_octree(const Octree& octree);
  /// The leader's sampler gets the points of all others'.
  void gather_samples(SpacingSampler& sampler);
  /// What the leader knows of the points before they are sorted.
  Partition agreed_partition(const Partition& partition);
  /// Where everybody's bins lie; null for a team of one.
  std::unique_ptr<PublishedBins> all_bins(Binner& own, const PointSchema& schema);
  /// Where this member's bins spill to, and under which name.
  std::filesystem::path spill_directory() const;
  std::string spill_name() const;
  /// Removes all of it, when nobody has any of it open.
  void end();

 private:
  bool alone() const { return context_.team.size() == 1; }
  /// Puts the cells of all shares together, some at a time.
  CountedCloud gather_counts();
  /// The leader's, through the store.
  Partition agreed(const char* name, const Partition& partition);

  JobContext& context_;
  std::string stage_;
};

}  // namespace orbweave
