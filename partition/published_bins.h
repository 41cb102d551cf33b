// Bins that one or several processes filled, each with its share of the points, in the files that
// they published (Binner::publish).
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "partition/binning.h"

namespace orbweave {

class PublishedBins final : public BinSource {
 public:
  struct File {
    std::filesystem::path path;
    std::vector<BinExtent> extents;
  };
  /// `disk` is told what is given back. Throws CorruptResult where a file is not there, Error
  /// (resource) where it cannot be opened.
  PublishedBins(PointSchema schema, std::vector<File> files, DiskUsage* disk = nullptr);
  ~PublishedBins() override;

  /// File by file, in the order given. A bin can be taken more than once, until it is given back.
  void take(ChunkId chunk, std::size_t piece_points,
            const std::function<void(PointCloud&&)>& use) override;
  void give_back(ChunkId chunk) override;
  std::uint64_t bytes_read() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
