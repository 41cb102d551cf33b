#include "partition/binning.h"

#include <fcntl.h>
#include <limits.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "io/error.h"
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

/// The append-only file; made when first needed, gone with the object or the process.
class SpillFile {
 public:
  SpillFile(std::filesystem::path directory, std::string name, DiskUsage* disk)
      : directory_(std::move(directory)), name_(std::move(name)), disk_(disk) {}
  ~SpillFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (disk_ != nullptr) disk_->remove(held_);
  }
  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;

  std::uint64_t size() const { return size_; }
  bool is_named() const { return !name_.empty(); }

  /// Appends all pieces, in order.
  void append(std::vector<iovec>& pieces) {
    open();
    for (std::size_t first = 0; first < pieces.size();) {
      const auto count = static_cast<int>(std::min<std::size_t>(pieces.size() - first, IOV_MAX));
      const ssize_t written =
          pwritev(descriptor_, &pieces[first], count, static_cast<off_t>(size_));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) fail(written < 0 ? errno : ENOSPC);
      size_ += static_cast<std::uint64_t>(written);
      held_ += static_cast<std::uint64_t>(written);
      if (disk_ != nullptr) disk_->add(static_cast<std::uint64_t>(written));
      first += consume(std::span(pieces).subspan(first), static_cast<std::size_t>(written));
    }
  }

  void read(std::uint64_t offset, std::span<std::byte> out) const {
    if (const int error = read_whole(descriptor_, offset, out)) fail(error);
  }

  /// Leaves the file, if anything was written, to others and to whoever removes its directory. File
  /// systems over a network show others what was written before a file was closed, not more.
  void hand_over() {
    if (descriptor_ >= 0 && ::close(std::exchange(descriptor_, -1)) != 0) fail(errno);
    held_ = 0;
  }

  /// Gives back the room of what nobody reads again; where the file system cannot, it stays taken.
  void free([[maybe_unused]] const BinExtent& extent) {
#ifdef __linux__
    constexpr std::uint64_t kFileBlock = 4096;
    const std::uint64_t begin = (extent.offset + kFileBlock - 1) / kFileBlock * kFileBlock;
    const std::uint64_t end = (extent.offset + extent.bytes) / kFileBlock * kFileBlock;
    if (begin >= end) return;
    if (fallocate(descriptor_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE,
                  static_cast<off_t>(begin), static_cast<off_t>(end - begin)) != 0)
      return;
    held_ -= end - begin;
    if (disk_ != nullptr) disk_->remove(end - begin);
#endif
  }

  [[noreturn]] void fail_checksum() const {
    throw_resource("points that were spilled to disk came back changed",
                   {.file = directory_.string(),
                    .found = "a wrong checksum",
                    .advice = "The disk or the memory is at fault; the same command starts over "
                              "from what is done"});
  }

 private:
  void open() {
    if (descriptor_ >= 0) return;
    if (!name_.empty()) {
      descriptor_ =
          ::open((directory_ / name_).c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
      if (descriptor_ < 0) fail(errno);
      return;
    }
    std::string name = (directory_ / "orbweave-spill-XXXXXX").string();
    descriptor_ = mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ < 0) fail(errno);
    ::unlink(name.c_str());
  }

  [[noreturn]] void fail(int reason) const {
    throw_resource("cannot spill points to disk",
                   {.file = directory_.string(),
                    .found = std::strerror(reason),
                    .advice = "Free some space or name another work directory; the same command "
                              "resumes what is done"});
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

  std::filesystem::path directory_;
  std::string name_;
  DiskUsage* disk_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::atomic<std::uint64_t> held_{0};  ///< bytes that have not been given back
};

/// One chunk's points: first what was spilled, then full blocks, then the one being filled.
struct Bin {
  std::byte* fill = nullptr;  ///< where the next record goes
  std::byte* fill_end = nullptr;
  std::uint64_t points = 0;
  std::vector<std::byte*> blocks;  ///< all but the last are full
  std::vector<BinExtent> extents;
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
  using RecordVisitor = std::function<void(std::span<const std::byte>)>;
  const Octree& octree;
  PointSchema schema;
  RecordLayout layout;
  std::vector<Bin> bins;
  BlockPool pool;
  SpillFile spill;
  std::mutex mutex;  ///< guards the pool in take()

  State(const Octree& tree, PointSchema point_schema, Options options)
      : octree(tree),
        schema(std::move(point_schema)),
        layout(schema),
        bins(tree.chunks().size()),
        pool(options.buffer_bytes,
             block_bytes(options.buffer_bytes, tree.chunks().size(), layout.bytes)),
        spill(std::move(options.spill_directory), std::move(options.spill_name), options.disk) {}

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
  /// The records of a piece of the spill file, some at a time.
  void read_extent(const BinExtent& extent, const RecordVisitor& visit) const;
  void visit_records(const Bin& bin, const RecordVisitor& visit);
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

/// Spills the fullest bins, as a whole, until so many blocks are written or none is left.
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
  std::size_t spilled_bins = 0;
  std::uint64_t offset = spill.size();
  for (const ChunkId chunk : fullest) {
    if (pieces.size() >= blocks) break;
    Bin& bin = bins[chunk];
    RunningChecksum checksum;
    for (std::size_t block = 0; block < bin.blocks.size(); ++block) {
      pieces.push_back({bin.blocks[block], used_bytes(bin, block)});
      checksum.add(pieces.back().iov_base, pieces.back().iov_len);
    }
    bin.extents.push_back({chunk, offset, bytes_in_memory(bin), checksum.value()});
    offset += bytes_in_memory(bin);
    ++spilled_bins;
  }
  spill.append(pieces);
  for (std::size_t i = 0; i < spilled_bins; ++i) release_blocks(bins[fullest[i]]);
}

void Binner::State::release_blocks(Bin& bin) {
  for (std::byte* block : bin.blocks) pool.release(block);
  bin.blocks.clear();
  bin.fill = bin.fill_end = nullptr;
}

void Binner::State::read_extent(const BinExtent& extent, const RecordVisitor& visit) const {
  const auto read = [&](std::uint64_t offset, std::span<std::byte> out) {
    spill.read(offset, out);
  };
  if (!visit_extent(extent, layout.bytes, read, visit)) spill.fail_checksum();
}

/// All records of a bin, in arrival order; what is read from the disk is given back.
void Binner::State::visit_records(const Bin& bin, const RecordVisitor& visit) {
  for (const BinExtent& extent : bin.extents) {
    read_extent(extent, visit);
    spill.free(extent);
  }
  for (std::size_t block = 0; block < bin.blocks.size(); ++block)
    visit({bin.blocks[block], used_bytes(bin, block)});
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
  Bin& bin = state.bins.at(chunk);
  std::uint64_t left = bin.points;
  PointCloud cloud;
  const auto begin_piece = [&] {
    cloud = PointCloud();
    cloud.schema = state.schema;
    cloud.reserve(std::min<std::uint64_t>(left, piece_points));
  };
  begin_piece();
  state.visit_records(bin, [&](std::span<const std::byte> records) {
    state.layout.unpack(records, cloud);
    if (cloud.size() < piece_points) return;
    left -= cloud.size();
    use(std::move(cloud));
    begin_piece();
  });
  use(std::move(cloud));
  const std::scoped_lock lock(state.mutex);
  state.release_blocks(bin);
  bin = Bin();
}

std::uint64_t Binner::spilled_bytes() const { return state_->spill.size(); }

std::vector<BinExtent> Binner::publish() {
  State& state = *state_;
  if (!state.spill.is_named()) throw std::logic_error("Binner::publish: the file has no name");
  state.spill_bins(std::numeric_limits<std::size_t>::max());
  state.spill.hand_over();
  std::vector<BinExtent> extents;
  for (Bin& bin : state.bins) {
    extents.insert(extents.end(), bin.extents.begin(), bin.extents.end());
    bin = Bin();
  }
  return extents;
}

}  // namespace orbweave
