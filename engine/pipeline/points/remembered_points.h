// The points of the first pass over the input, for the second: where they fit in memory, nothing is
// read, unpacked and parsed twice.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>

#include "io/points/point_source.h"

namespace orbweave {

class RememberedPoints {
 public:
  struct Batch {
    PointCloud points;
    ScanNumber scan;
  };

  /// No more than `most_bytes` are held; 0: none.
  explicit RememberedPoints(std::size_t most_bytes = 0) : most_bytes_(most_bytes) {}

  /// Takes the points of the next batch, which are of `scan`; empties it where it does. One batch
  /// that does not fit, and all are forgotten.
  void take(PointCloud& batch, ScanNumber scan = {});
  /// Whether every batch was taken.
  bool are_all() const { return most_bytes_ > 0; }
  /// Gives batch after batch out, of which the memory goes with the source. `schema`: theirs.
  std::unique_ptr<PointSource> source(const PointSchema& schema);

 private:
  std::size_t most_bytes_;
  std::size_t bytes_ = 0;
  std::deque<Batch> batches_;
};

}  // namespace orbweave
