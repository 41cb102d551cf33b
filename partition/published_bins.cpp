#include "partition/published_bins.h"

#include <fcntl.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/store/chunk_store_file.h"
#include "io/system/file_descriptor.h"
#include "partition/bin_records.h"

namespace orbweave {
namespace {

/// Files that stay open. A team may have more members than a process may have files.
constexpr std::size_t kMostOpen = 128;

[[noreturn]] void fail(const std::filesystem::path& path, int reason) {
  std::error_code ignored;
  const bool gone = reason == ENOENT && std::filesystem::exists(path.parent_path(), ignored);
  if (gone || reason == ENODATA) throw CorruptResult(path, std::strerror(reason));
  throw_resource("cannot read the points that were binned",
                 {.file = path.string(),
                  .found = std::strerror(reason),
                  .advice = "The work directory has to be on a file system that all processes "
                            "share; the same command starts over from what is done"});
}

/// To be read, and where that is allowed, to have room given back.
FileDescriptor open_bins(const std::filesystem::path& path) {
  FileDescriptor descriptor(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (!descriptor.valid()) descriptor = FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!descriptor.valid()) fail(path, errno);
  return descriptor;
}

/// Gives back the room of bins that were read for the last time, where the file system can.
/// Returns how much that was.
std::uint64_t punch([[maybe_unused]] int descriptor, [[maybe_unused]] const BinExtent& extent) {
#ifdef __linux__
  constexpr std::uint64_t kFileBlock = 4096;
  const std::uint64_t begin = (extent.offset + kFileBlock - 1) / kFileBlock * kFileBlock;
  const std::uint64_t end = (extent.offset + extent.bytes) / kFileBlock * kFileBlock;
  if (begin < end && fallocate(descriptor, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE,
                               static_cast<off_t>(begin), static_cast<off_t>(end - begin)) == 0)
    return end - begin;
#endif
  return 0;
}

}  // namespace

struct PublishedBins::State {
  struct BinFile {
    std::filesystem::path path;
    std::vector<BinExtent> extents;  // by chunk
    FileDescriptor descriptor;       // invalid: opened whenever it is read
  };
  PointSchema schema;
  RecordLayout layout;
  std::vector<BinFile> files;
  DiskUsage* disk;
  std::atomic<std::uint64_t> bytes_read{0};

  State(PointSchema point_schema, DiskUsage* usage)
      : schema(std::move(point_schema)), layout(schema), disk(usage) {}

  void add(File&& file);
  /// Calls visit(file, open file, extent) for what lies of a chunk anywhere.
  template <class Visit>
  void for_extents(ChunkId chunk, const Visit& visit) const;
};

void PublishedBins::State::add(File&& file) {
  std::stable_sort(file.extents.begin(), file.extents.end(),
                   [](const BinExtent& a, const BinExtent& b) { return a.chunk < b.chunk; });
  // A member without points has no file.
  if (file.extents.empty()) return;
  FileDescriptor descriptor;
  if (files.size() < kMostOpen) descriptor = open_bins(file.path);
  files.push_back({std::move(file.path), std::move(file.extents), std::move(descriptor)});
}

template <class Visit>
void PublishedBins::State::for_extents(ChunkId chunk, const Visit& visit) const {
  for (const BinFile& file : files) {
    auto extent =
        std::lower_bound(file.extents.begin(), file.extents.end(), chunk,
                         [](const BinExtent& a, ChunkId wanted) { return a.chunk < wanted; });
    if (extent == file.extents.end() || extent->chunk != chunk) continue;
    FileDescriptor opened;
    if (!file.descriptor.valid()) opened = open_bins(file.path);
    const int descriptor = opened.valid() ? opened.get() : file.descriptor.get();
    for (; extent != file.extents.end() && extent->chunk == chunk; ++extent)
      visit(file, descriptor, *extent);
  }
}

PublishedBins::PublishedBins(PointSchema schema, std::vector<File> files, DiskUsage* disk)
    : state_(std::make_unique<State>(std::move(schema), disk)) {
  for (File& file : files) state_->add(std::move(file));
}
PublishedBins::~PublishedBins() = default;

void PublishedBins::take(ChunkId chunk, std::size_t piece_points,
                         const std::function<void(PointCloud&&)>& use) {
  const State& state = *state_;
  PointCloud cloud;
  cloud.schema = state.schema;
  const auto add = [&](std::span<const std::byte> records) {
    state.layout.unpack(records, cloud);
    if (cloud.size() < piece_points) return;
    use(std::move(cloud));
    cloud = PointCloud();
    cloud.schema = state.schema;
  };
  state.for_extents(chunk,
                    [&](const State::BinFile& file, int descriptor, const BinExtent& extent) {
                      const auto read = [&](std::uint64_t offset, std::span<std::byte> out) {
                        const auto got = read_at(descriptor, offset, out);
                        if (got != out.size()) fail(file.path, got ? ENODATA : errno);
                        state_->bytes_read += out.size();
                      };
                      if (!visit_extent(extent, state.layout.bytes, read, add))
                        throw CorruptResult(file.path, "a wrong checksum");
                    });
  use(std::move(cloud));
}

std::uint64_t PublishedBins::bytes_read() const { return state_->bytes_read; }

void PublishedBins::give_back(ChunkId chunk) {
  std::uint64_t freed = 0;
  state_->for_extents(chunk, [&](const State::BinFile&, int descriptor, const BinExtent& extent) {
    freed += punch(descriptor, extent);
  });
  if (state_->disk != nullptr) state_->disk->remove(freed);
}

}  // namespace orbweave
