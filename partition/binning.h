// The second streaming pass: every point goes to the bin of its chunk, through bounded buffers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/disk_space.h"
#include "io/point_cloud.h"
#include "partition/octree.h"

namespace orbweave {

/// A piece of a bin in a spill file.
struct BinExtent {
  std::uint64_t chunk = 0;
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;  ///< XXH3-64
};

/// Where the points of bins are taken from.
class BinSource {
 public:
  virtual ~BinSource() = default;
  /// All points of a bin in pieces of about `piece_points` points, at least one piece. Throws
  /// Error (resource) on a failing disk, also where the bytes that come back are not those that
  /// were spilled. May be called from several threads for different chunks.
  virtual void take(ChunkId chunk, std::size_t piece_points,
                    const std::function<void(PointCloud&&)>& use) = 0;
};

/// Bins that live in memory as long as they fit and spill to one append-only file beyond that:
/// writes are large and sequential. A spill that is interrupted leaves nothing behind (the file
/// is unlinked while open). Not resumable by design: binning starts over. What is taken gives its
/// room on the disk back, where the file system can do that.
class Binner final : public BinSource {
 public:
  struct Options {
    std::size_t buffer_bytes = std::size_t{256} << 20;  ///< memory for all bins together
    std::filesystem::path spill_directory;              ///< where the spill file goes
    DiskUsage* disk = nullptr;                          ///< is told what the spill file holds
    /// Of a spill file that others are to read; empty: it is gone with the process.
    std::string spill_name = {};
  };
  /// `octree` must outlive the object.
  Binner(const Octree& octree, PointSchema schema, Options options);
  ~Binner() override;

  /// Sorts a batch into the bins. Positions must be finite. Not thread-safe. Throws Error: bad
  /// input when a point lies in no chunk, resource when the spill directory cannot take more.
  void add(const PointCloud& batch);
  /// The same with chunk ids computed elsewhere (in parallel): chunks[i] is the chunk of point i.
  void add(const PointCloud& batch, std::span<const ChunkId> chunks);
  std::uint64_t points(ChunkId chunk) const;
  /// All points of a bin, in arrival order; the bin is emptied.
  PointCloud take(ChunkId chunk);
  void take(ChunkId chunk, std::size_t piece_points,
            const std::function<void(PointCloud&&)>& use) override;
  /// Written to the spill file so far.
  std::uint64_t spilled_bytes() const;
  /// Writes what is still in memory to the spill file as well, which needs a name, and says where
  /// everything lies. The bins are empty then, and the file is no longer this object's: it stays
  /// when the object goes. Throws Error (resource) when the spill directory cannot take more.
  std::vector<BinExtent> publish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
