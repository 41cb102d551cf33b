#include "partition/published_bins.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "io/error.h"
#include "io/file_descriptor.h"
#include "partition/bin_records.h"

namespace orbweave {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
  throw_resource("cannot read the points that another process has binned",
                 {.file = path.string(),
                  .found = reason,
                  .advice = "The work directory has to be on a file system that all processes "
                            "share; the same command starts over from what is done"});
}

}  // namespace

struct PublishedBins::State {
  struct OpenFile {
    std::filesystem::path path;
    std::vector<BinExtent> extents;  // by chunk
    int descriptor = -1;
  };
  PointSchema schema;
  RecordLayout layout;
  std::vector<OpenFile> files;

  explicit State(PointSchema point_schema) : schema(std::move(point_schema)), layout(schema) {}
  ~State() {
    for (const OpenFile& file : files)
      if (file.descriptor >= 0) ::close(file.descriptor);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void open(File&& from);
  void read(const OpenFile& file, std::uint64_t offset, std::span<std::byte> out) const;
  template <class Visit>
  void visit_extent(const OpenFile& file, BinExtent extent, const Visit& visit) const;
};

void PublishedBins::State::open(File&& from) {
  std::stable_sort(from.extents.begin(), from.extents.end(),
                   [](const BinExtent& a, const BinExtent& b) { return a.chunk < b.chunk; });
  // A member without points has no file.
  if (from.extents.empty()) return;
  files.push_back({std::move(from.path), std::move(from.extents), -1});
  OpenFile& file = files.back();
  file.descriptor = ::open(file.path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file.descriptor < 0) fail(file.path, std::strerror(errno));
}

void PublishedBins::State::read(const OpenFile& file, std::uint64_t offset,
                                std::span<std::byte> out) const {
  while (!out.empty()) {
    const ssize_t got = pread(file.descriptor, out.data(), out.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(file.path, got < 0 ? std::strerror(errno) : "the end of the file");
    out = out.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
}

template <class Visit>
void PublishedBins::State::visit_extent(const OpenFile& file, BinExtent extent,
                                        const Visit& visit) const {
  const std::size_t piece_bytes =
      std::max<std::size_t>(kPieceBytes / layout.bytes, 1) * layout.bytes;
  std::vector<std::byte> piece;
  RunningChecksum checksum;
  while (extent.bytes > 0) {
    piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(piece_bytes, extent.bytes)));
    read(file, extent.offset, piece);
    checksum.add(piece.data(), piece.size());
    visit(piece);
    extent.offset += piece.size();
    extent.bytes -= piece.size();
  }
  if (checksum.value() != extent.checksum) fail(file.path, "a wrong checksum");
}

PublishedBins::PublishedBins(PointSchema schema, std::vector<File> files)
    : state_(std::make_unique<State>(std::move(schema))) {
  for (File& file : files) state_->open(std::move(file));
}
PublishedBins::~PublishedBins() = default;

void PublishedBins::take(ChunkId chunk, std::size_t piece_points,
                         const std::function<void(PointCloud&&)>& use) {
  const State& state = *state_;
  PointCloud cloud;
  cloud.schema = state.schema;
  for (const State::OpenFile& file : state.files) {
    auto extent =
        std::lower_bound(file.extents.begin(), file.extents.end(), chunk,
                         [](const BinExtent& a, ChunkId wanted) { return a.chunk < wanted; });
    for (; extent != file.extents.end() && extent->chunk == chunk; ++extent) {
      state.visit_extent(file, *extent, [&](std::span<const std::byte> records) {
        state.layout.unpack(records, cloud);
        if (cloud.size() < piece_points) return;
        use(std::move(cloud));
        cloud = PointCloud();
        cloud.schema = state.schema;
      });
    }
  }
  use(std::move(cloud));
}

}  // namespace orbweave
