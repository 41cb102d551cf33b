#include "partition/published_bins.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "io/chunk_store_file.h"
#include "io/error.h"
#include "partition/bin_records.h"

namespace orbweave {
namespace {

/// Files that stay open. A team may have more members than a process may have files.
constexpr std::size_t kMostOpen = 128;

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
  throw_resource("cannot read the points that another process has binned",
                 {.file = path.string(),
                  .found = reason,
                  .advice = "The work directory has to be on a file system that all processes "
                            "share; the same command starts over from what is done"});
}

FileDescriptor open_bins(const std::filesystem::path& path) {
  FileDescriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!descriptor.valid()) fail(path, std::strerror(errno));
  return descriptor;
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

  explicit State(PointSchema point_schema) : schema(std::move(point_schema)), layout(schema) {}

  void add(File&& file);
  /// Visits the records of a chunk that lie in the file.
  template <class Visit>
  void visit_file(const BinFile& file, ChunkId chunk, const Visit& visit) const;
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
void PublishedBins::State::visit_file(const BinFile& file, ChunkId chunk,
                                      const Visit& visit) const {
  auto extent =
      std::lower_bound(file.extents.begin(), file.extents.end(), chunk,
                       [](const BinExtent& a, ChunkId wanted) { return a.chunk < wanted; });
  if (extent == file.extents.end() || extent->chunk != chunk) return;
  FileDescriptor opened;
  if (!file.descriptor.valid()) opened = open_bins(file.path);
  const int descriptor = opened.valid() ? opened.get() : file.descriptor.get();
  const auto read = [&](std::uint64_t offset, std::span<std::byte> out) {
    if (const int error = read_whole(descriptor, offset, out))
      fail(file.path, std::strerror(error));
  };
  for (; extent != file.extents.end() && extent->chunk == chunk; ++extent) {
    if (!visit_extent(*extent, layout.bytes, read, visit)) fail(file.path, "a wrong checksum");
  }
}

PublishedBins::PublishedBins(PointSchema schema, std::vector<File> files)
    : state_(std::make_unique<State>(std::move(schema))) {
  for (File& file : files) state_->add(std::move(file));
}
PublishedBins::~PublishedBins() = default;

void PublishedBins::take(ChunkId chunk, std::size_t piece_points,
                         const std::function<void(PointCloud&&)>& use) {
  const State& state = *state_;
  PointCloud cloud;
  cloud.schema = state.schema;
  for (const State::BinFile& file : state.files) {
    state.visit_file(file, chunk, [&](std::span<const std::byte> records) {
      state.layout.unpack(records, cloud);
      if (cloud.size() < piece_points) return;
      use(std::move(cloud));
      cloud = PointCloud();
      cloud.schema = state.schema;
    });
  }
  use(std::move(cloud));
}

}  // namespace orbweave
