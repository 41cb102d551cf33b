// What a member of a team has binned so far, as the chunk store keeps it: parts, each of which is
// committed when all that was read up to there lies in the member's spill file. A run that was
// killed goes on behind the last. docs/resume.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/spacing/automatic_radii.h"
#include "io/store/chunk_store.h"
#include "partition/binning.h"

namespace orbweave {

struct BinnedSoFar {
  std::uint64_t points_read = 0;  ///< of the member's share; rows without a point not counted
  std::uint64_t file_bytes = 0;   ///< of the spill file, in which the extents lie
  bool complete = false;          ///< the whole share
  std::vector<BinExtent> extents;
};

class BinLog {
 public:
  /// `stage`: of the store; its results from number `first_result` on are the logs' of all members.
  BinLog(ChunkStore& store, std::string stage, int rank, int members, ChunkId first_result);

  std::filesystem::path spill_file() const;
  /// All parts up to the first that is damaged or missing, or whose bins are. What they have
  /// sampled is added to `sampler`, with the sites that they were sampled at. The log goes on
  /// there.
  BinnedSoFar load(SpacingSampler& sampler);
  /// The extents alone.
  BinnedSoFar load_extents() const;
  /// Adds what was read, binned and sampled since the last part; `points_read` in all.
  void append(std::uint64_t points_read, const std::vector<BinExtent>& extents,
              const SpacingSampler& sampler, bool complete);

 private:
  ChunkId number_of(std::uint32_t part) const;
  template <class Visit>
  BinnedSoFar visit_parts(const Visit& visit) const;

  ChunkStore& store_;
  std::string stage_;
  int rank_;
  int members_;
  ChunkId first_result_;
  std::uint32_t parts_ = 0;
  std::uint64_t points_read_ = 0;
  std::uint64_t file_bytes_ = 0;
  std::vector<std::uint64_t> sampled_;  ///< points per site that the parts hold
};

}  // namespace orbweave
