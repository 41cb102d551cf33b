#include "partition/binning.h"

#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <limits>
#include <mutex>
#include <new>
#include <stdexcept>
#include <utility>

#include "io/error.h"
#include "io/first_touch.h"
#include "io/system/file_calls.h"
#include "io/system/work_directory_errors.h"
#include "partition/bin_records.h"

namespace orbweave {
namespace {

constexpr std::size_t kLargestBlock = std::size_t{64} << 10;
constexpr std::size_t kSmallestBlock = std::size_t{1} << 10;
constexpr std::size_t kFewestBlocks = 64;
constexpr std::size_t kSlabBytes = std::size_t{1} << 20;

/// Memory cut into blocks of one size; grows up to its limit, block by block.
class BlockPool {
 public:
  BlockPool(std::size_t limit_bytes, std::size_t block_bytes)
      : block_bytes_(block_bytes), limit_(std::max(limit_bytes / block_bytes, kFewestBlocks)) {}

  std::size_t block_bytes() const { return block_bytes_; }
  std::size_t limit() const { return limit_; }
  /// Null when all blocks are in use.
  std::byte* acquire() {
    if (free_.empty()) grow();
    if (free_.empty()) return nullptr;
    std::byte* const block = free_.back();
    free_.pop_back();
    return block;
  }
  void release(std::byte* block) { free_.push_back(block); }

 private:
  void grow() {
    const std::size_t blocks =
        std::min(std::max<std::size_t>(kSlabBytes / block_bytes_, 1), limit_ - made_);
    if (blocks == 0) return;
    slabs_.push_back(std::make_unique_for_overwrite<std::byte[]>(blocks * block_bytes_));
    for (std::size_t i = blocks; i-- > 0;) free_.push_back(slabs_.back().get() + i * block_bytes_);
    made_ += blocks;
  }

  std::size_t block_bytes_;
  std::size_t limit_;
  std::size_t made_ = 0;
  std::vector<std::unique_ptr<std::byte[]>> slabs_;
  std::vector<std::byte*> free_;
};

/// The append-only file; opened when first needed.
class SpillFile {
 public:
  explicit SpillFile(Binner::Options options)
      : path_(std::move(options.spill_file)),
        disk_(options.disk),
        before_(std::move(options.before_spilling)),
        kept_(options.kept_bytes),
        size_(kept_) {}
  ~SpillFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;

  std::uint64_t size() const { return size_; }
  std::uint64_t written() const { return size_ - kept_; }

  /// Appends all pieces, in order.
  void append(std::vector<iovec>& pieces) {
    open();
    for (std::size_t first = 0; first < pieces.size();) {
      const auto count = static_cast<int>(std::min<std::size_t>(pieces.size() - first, IOV_MAX));
      const ssize_t done =
          file_calls.pwritev(descriptor_, &pieces[first], count, static_cast<off_t>(size_));
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) fail(done < 0 ? errno : ENOSPC);
      size_ += static_cast<std::uint64_t>(done);
      if (disk_ != nullptr) disk_->add(static_cast<std::uint64_t>(done));
      first += consume(std::span(pieces).subspan(first), static_cast<std::size_t>(done));
    }
  }

  /// File systems over a network show others what was written before a file was closed, not more.
  void close() {
    if (descriptor_ >= 0 && ::close(std::exchange(descriptor_, -1)) != 0) fail(errno);
  }

 private:
  void open() {
    if (descriptor_ >= 0) return;
    if (before_) before_();
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    struct stat facts {};
    if (descriptor_ < 0 || fstat(descriptor_, &facts) != 0) fail(errno);
    const auto found = static_cast<std::uint64_t>(facts.st_size);
    if (file_calls.ftruncate(descriptor_, static_cast<off_t>(kept_)) != 0) fail(errno);
    if (disk_ != nullptr) disk_->remove(found - std::min(found, kept_));
  }

  [[noreturn]] void fail(int reason) const {
    throw_refusal("cannot spill points to disk", path_, reason);
  }

  /// Takes `bytes` off the front; returns how many pieces are gone.
  static std::size_t consume(std::span<iovec> pieces, std::size_t bytes) {
    std::size_t gone = 0;
    while (gone < pieces.size() && bytes >= pieces[gone].iov_len) bytes -= pieces[gone++].iov_len;
    if (bytes > 0) {
      pieces[gone].iov_base = static_cast<char*>(pieces[gone].iov_base) + bytes;
      pieces[gone].iov_len -= bytes;
    }
    return gone;
  }

  std::filesystem::path path_;
  DiskUsage* disk_;
  std::function<void()> before_;
  std::uint64_t kept_;
  int descriptor_ = -1;
  std::uint64_t size_;
};

/// What a chunk's bin has in memory: full blocks, then the one being filled.
struct Bin {
  std::byte* fill = nullptr;  ///< where the next record goes
  std::byte* fill_end = nullptr;
  std::uint64_t points = 0;
  std::vector<std::byte*> blocks;  ///< all but the last are full
};

/// So small that every bin can have a block and half of the memory is left for full ones, and
/// that there are some blocks even for one bin.
std::size_t block_bytes(std::size_t buffer_bytes, std::size_t bins, std::size_t record_bytes) {
  const std::size_t share = buffer_bytes / std::max(2 * bins, kFewestBlocks);
  const std::size_t block = std::clamp(std::bit_floor(share), kSmallestBlock, kLargestBlock);
  const std::size_t records = std::max<std::size_t>(block / record_bytes, 1);
  return records * record_bytes;
}

}  // namespace

struct Binner::State {
  const Octree& octree;
  PointSchema schema;
  RecordLayout layout;
  std::vector<Bin> bins;
  BlockPool pool;
  SpillFile spill;
  std::vector<BinExtent> extents;  ///< written, and not told yet
  std::mutex mutex;                ///< guards the pool in take()

  State(const Octree& tree, PointSchema point_schema, Options options)
      : octree(tree),
        schema(std::move(point_schema)),
        layout(schema),
        bins(tree.chunks().size()),
        pool(options.buffer_bytes,
             block_bytes(options.buffer_bytes, tree.chunks().size(), layout.bytes)),
        spill(std::move(options)) {}

  std::size_t bytes_in_memory(const Bin& bin) const {
    if (bin.blocks.empty()) return 0;
    return bin.blocks.size() * pool.block_bytes() -
           static_cast<std::size_t>(bin.fill_end - bin.fill);
  }
  std::size_t used_bytes(const Bin& bin, std::size_t block) const {
    const bool last = block + 1 == bin.blocks.size();
    return last ? static_cast<std::size_t>(bin.fill - bin.blocks[block]) : pool.block_bytes();
  }

  void start_block(Bin& bin);
  void make_room();
  void spill_bins(std::size_t blocks);
  void release_blocks(Bin& bin);
  std::size_t unpack_blocks(const Bin& bin, std::size_t first, std::size_t points,
                            PointCloud& cloud) const;
};

void Binner::State::start_block(Bin& bin) {
  std::byte* block = pool.acquire();
  if (block == nullptr) {
    make_room();
    block = pool.acquire();
  }
  bin.blocks.push_back(block);
  bin.fill = block;
  bin.fill_end = block + pool.block_bytes();
}

/// Spills the fullest bins, as a whole, until half of the memory is free.
void Binner::State::make_room() { spill_bins(pool.limit() / 2); }

/// Spills the fullest bins, each as a whole, until this number of blocks is written or no bin is
/// left.
void Binner::State::spill_bins(std::size_t blocks) {
  std::vector<ChunkId> fullest;
  for (ChunkId chunk = 0; chunk < bins.size(); ++chunk)
    if (!bins[chunk].blocks.empty()) fullest.push_back(chunk);
  std::sort(fullest.begin(), fullest.end(), [&](ChunkId a, ChunkId b) {
    const std::size_t bytes_a = bytes_in_memory(bins[a]);
    const std::size_t bytes_b = bytes_in_memory(bins[b]);
    return bytes_a != bytes_b ? bytes_a > bytes_b : a < b;
  });
  std::vector<iovec> pieces;
  std::vector<BinExtent> written;
  std::uint64_t offset = spill.size();
  for (const ChunkId chunk : fullest) {
    if (pieces.size() >= blocks) break;
    Bin& bin = bins[chunk];
    RunningChecksum checksum;
    for (std::size_t block = 0; block < bin.blocks.size(); ++block) {
      pieces.push_back({bin.blocks[block], used_bytes(bin, block)});
      checksum.add(pieces.back().iov_base, pieces.back().iov_len);
    }
    written.push_back({chunk, offset, bytes_in_memory(bin), checksum.value()});
    offset += bytes_in_memory(bin);
  }
  if (written.empty()) return;
  spill.append(pieces);
  for (const BinExtent& extent : written) release_blocks(bins[extent.chunk]);
  extents.insert(extents.end(), written.begin(), written.end());
}

void Binner::State::release_blocks(Bin& bin) {
  for (std::byte* block : bin.blocks) pool.release(block);
  bin.blocks.clear();
  bin.fill = bin.fill_end = nullptr;
}

/// Unpacks blocks from the first one on until the cloud has this number of points or none is left;
/// returns where the next blocks begin. Parallel.
std::size_t Binner::State::unpack_blocks(const Bin& bin, std::size_t first, std::size_t points,
                                         PointCloud& cloud) const {
  const std::size_t records = pool.block_bytes() / layout.bytes;
  const std::size_t left = bin.blocks.size() - first;
  const std::size_t blocks = std::min(left, std::max<std::size_t>((points - 1) / records + 1, 1));
  if (blocks == 0) return first;
  const std::size_t size =
      (blocks - 1) * records + used_bytes(bin, first + blocks - 1) / layout.bytes;
  reserve_touched(cloud.positions, size);
  if (layout.has_normals) reserve_touched(cloud.normals, size);
  reserve_touched(cloud.attributes, size * layout.attribute_bytes);
  layout.resize(cloud, size);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t i) {
    const std::size_t block = first + i;
    layout.unpack_at({bin.blocks[block], used_bytes(bin, block)}, cloud, i * records);
  });
  return first + blocks;
}

Binner::Binner(const Octree& octree, PointSchema schema, Options options)
    : state_(std::make_unique<State>(octree, std::move(schema), std::move(options))) {}
Binner::~Binner() = default;

void Binner::add(const PointCloud& batch) {
  std::vector<ChunkId> chunks;
  chunks.reserve(batch.size());
  for (const Vec3& p : batch.positions) chunks.push_back(state_->octree.chunk_of(p));
  add(batch, chunks);
}

void Binner::add(const PointCloud& batch, std::span<const ChunkId> chunks) {
  State& state = *state_;
  if (chunks.size() != batch.size() || batch.schema.has_normals != state.schema.has_normals ||
      batch.schema.attribute_bytes() != state.layout.attribute_bytes)
    throw std::logic_error("Binner::add: a batch of another schema");
  const RecordLayout layout = state.layout;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    Bin& bin = state.bins[chunks[i]];
    if (bin.fill == bin.fill_end) state.start_block(bin);
    layout.pack(batch, i, bin.fill);
    bin.fill += layout.bytes;
    ++bin.points;
  }
}

std::uint64_t Binner::points(ChunkId chunk) const { return state_->bins.at(chunk).points; }

PointCloud Binner::take(ChunkId chunk) {
  PointCloud cloud;
  take(chunk, std::numeric_limits<std::size_t>::max(),
       [&](PointCloud&& points) { cloud = std::move(points); });
  return cloud;
}

void Binner::take(ChunkId chunk, std::size_t piece_points,
                  const std::function<void(PointCloud&&)>& use) {
  State& state = *state_;
  if (state.spill.written() > 0) throw std::logic_error("Binner::take: bins have spilled");
  Bin& bin = state.bins.at(chunk);
  std::size_t block = 0;
  do {
    PointCloud cloud;
    cloud.schema = state.schema;
    block = state.unpack_blocks(bin, block, piece_points, cloud);
    use(std::move(cloud));
  } while (block < bin.blocks.size());
  const std::scoped_lock lock(state.mutex);
  state.release_blocks(bin);
  bin = Bin();
}

std::uint64_t Binner::spilled_bytes() const { return state_->spill.written(); }

std::vector<BinExtent> Binner::write_out() {
  state_->spill_bins(std::numeric_limits<std::size_t>::max());
  return std::exchange(state_->extents, {});
}

std::vector<BinExtent> Binner::publish() {
  State& state = *state_;
  std::vector<BinExtent> extents = write_out();
  state.spill.close();
  state.bins = {};
  state.pool = BlockPool(0, state.pool.block_bytes());
  return extents;
}

}  // namespace orbweave
