// The second streaming pass: every point goes to the bin of its chunk, through bounded buffers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "io/point_cloud.h"
#include "io/system/disk_space.h"
#include "partition/bin_extent.h"
#include "partition/octree.h"

namespace orbweave {

/// Where the points of bins are taken from. May be called from several threads for different
/// chunks.
class BinSource {
 public:
  virtual ~BinSource() = default;
  /// All points of a bin in pieces of about `piece_points` points, at least one piece. Throws
  /// Error (resource) on a failing disk, CorruptResult where the bytes that come back are not those
  /// that were written.
  virtual void take(ChunkId chunk, std::size_t piece_points,
                    const std::function<void(PointCloud&&)>& use) = 0;
  /// What became of the bin's points is durable: its room on the disk is given back, where the file
  /// system can do that.
  virtual void give_back(ChunkId /*chunk*/) {}
  /// Read from files so far.
  virtual std::uint64_t bytes_read() const { return 0; }
};

/// Bins that live in memory as long as they fit and spill to one append-only file beyond that:
/// writes are large and sequential. What has spilled is read by PublishedBins, once all is
/// published. The file outlives the object: a process that knows where everything lies in it can go
/// on from there.
class Binner final : public BinSource {
 public:
  struct Options {
    std::size_t buffer_bytes = std::size_t{256} << 20;  ///< memory for all bins together
    std::filesystem::path spill_file;                   ///< made when it is needed
    DiskUsage* disk = nullptr;                          ///< is told what the spill file holds
    /// Called once, before the spill file is made or opened.
    std::function<void()> before_spilling = {};
    /// What an earlier object has written to the file, which stays; what lies behind it goes.
    std::uint64_t kept_bytes = 0;
  };
  /// `octree` must outlive the object.
  Binner(const Octree& octree, PointSchema schema, Options options);
  ~Binner() override;

  /// Sorts a batch into the bins. Positions must be finite. Not thread-safe. Throws Error: bad
  /// input when a point lies in no chunk, resource when the spill file cannot take more.
  void add(const PointCloud& batch);
  /// Adds points whose chunks were computed elsewhere, in parallel: chunks[i] is the chunk of point
  /// i.
  void add(const PointCloud& batch, std::span<const ChunkId> chunks);
  /// Points of a bin that were added to this object, spilled or not.
  std::uint64_t points(ChunkId chunk) const;
  /// All points of a bin, in arrival order; the bin is emptied. Nothing must have spilled.
  PointCloud take(ChunkId chunk);
  void take(ChunkId chunk, std::size_t piece_points,
            const std::function<void(PointCloud&&)>& use) override;
  /// Written to the spill file by this object so far.
  std::uint64_t spilled_bytes() const;
  /// Writes what is still in memory to the spill file as well and says where everything lies that
  /// was written since the last call. Throws Error (resource) when the file cannot take more.
  std::vector<BinExtent> write_out();
  /// The same, for the last time: the bins are empty then, and their memory and the file are free.
  std::vector<BinExtent> publish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
