#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/meshes/mesh_formats.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/nameless_file.h"
#include "io/system/system_advice.h"
#include "io/system/temporary_name.h"

namespace orbweave {
namespace {

/// Positions on disk, appended and then read at random; the file has no name and goes with the
/// object, however the process ends.
class PositionFile {
 public:
  /// `mesh`: the file that the positions are for; they lie in its directory.
  explicit PositionFile(const std::filesystem::path& mesh)
      : mesh_(mesh), file_(nameless_file(directory_of(mesh))) {
    if (!file_.valid()) fail();
  }
  ~PositionFile() {
    if (mapped_ != nullptr) ::munmap(mapped_, count_ * sizeof(Vec3));
  }
  PositionFile(const PositionFile&) = delete;
  PositionFile& operator=(const PositionFile&) = delete;

  void append(std::span<const Vec3> positions) {
    auto bytes = std::as_bytes(positions);
    while (!bytes.empty()) {
      const ssize_t wrote = file_calls.write(file_.get(), bytes.data(), bytes.size());
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote < 0) fail();
      bytes = bytes.subspan(static_cast<std::size_t>(wrote));
    }
    count_ += positions.size();
  }
  const Vec3& at(std::uint64_t i) {
    if (i >= count_) throw std::logic_error("a triangle names a vertex that is not there");
    if (mapped_ == nullptr) map();
    return static_cast<const Vec3*>(mapped_)[i];
  }
  /// Pages that were looked at count as the process's memory until they are let go; they stay in
  /// the page cache.
  void let_go() {
    if (mapped_ != nullptr) ::madvise(mapped_, count_ * sizeof(Vec3), MADV_DONTNEED);
  }

 private:
  void map() {
    void* const mapped =
        ::mmap(nullptr, count_ * sizeof(Vec3), PROT_READ, MAP_SHARED, file_.get(), 0);
    if (mapped == MAP_FAILED) fail();
    mapped_ = mapped;
  }
  [[noreturn]] void fail() const {
    const int error = errno;
    throw_resource(
        "cannot keep the vertices on disk while the file is written: " + system_reason(error),
        {.file = mesh_.string(), .advice = advice_on(error)});
  }

  std::filesystem::path mesh_;
  FileDescriptor file_;
  std::size_t count_ = 0;
  void* mapped_ = nullptr;
};

/// STL knows no vertices, only triangles with their coordinates (as floats when binary).
class StlWriter final : public MeshWriter {
 public:
  StlWriter(std::unique_ptr<ByteSink> sink, const MeshHeader& header,
            const MeshWriterOptions& options, const std::filesystem::path& path)
      : sink_(std::move(sink)),
        binary_(options.binary),
        origin_(options.origin),
        counter_(header),
        positions_(path) {
    if (binary_)
      write_binary_header(static_cast<std::uint32_t>(header.triangles));
    else
      sink_->write(std::string_view("solid orbweave\n"));
  }

  void write_vertices(const PointCloud& batch) override {
    counter_.vertices(batch.size());
    positions_.append(batch.positions);
  }
  void write_triangles(std::span<const Triangle64> batch, std::span<const std::int32_t>) override {
    counter_.triangles(batch.size());
    if (binary_)
      write_binary(batch);
    else
      write_text(batch);
    positions_.let_go();
  }
  void finish() override {
    counter_.finish();
    if (!binary_) sink_->write(std::string_view("endsolid orbweave\n"));
    sink_->finish();
  }
  std::uint64_t bytes_written() const override { return sink_->bytes_written(); }

 private:
  void write_binary_header(std::uint32_t triangles) {
    constexpr std::size_t kTitleBytes = 80;
    std::vector<std::byte> bytes(kTitleBytes + sizeof triangles);
    // Must not begin with "solid": that would announce text.
    constexpr std::string_view kTitle = "binary STL by orbweave";
    std::memcpy(bytes.data(), kTitle.data(), kTitle.size());
    std::memcpy(bytes.data() + kTitleBytes, &triangles, sizeof triangles);
    sink_->write(bytes);
  }

  /// Unit normal and corners.
  std::array<Vec3, 4> facet(const Triangle64& t) {
    const Vec3 a = positions_.at(t[0]);
    const Vec3 b = positions_.at(t[1]);
    const Vec3 c = positions_.at(t[2]);
    return {normalized(cross(b - a, c - a)), a - origin_, b - origin_, c - origin_};
  }

  void write_binary(std::span<const Triangle64> batch) {
    constexpr std::size_t kFacetBytes = 12 * sizeof(float) + 2;  // and an empty attribute count
    std::vector<std::byte> bytes(batch.size() * kFacetBytes);
    std::byte* row = bytes.data();
    for (const Triangle64& triangle : batch) {
      std::byte* at = row;
      for (const Vec3& v : facet(triangle)) {
        const std::array<float, 3> narrow = {static_cast<float>(v.x), static_cast<float>(v.y),
                                             static_cast<float>(v.z)};
        std::memcpy(at, narrow.data(), sizeof narrow);
        at += sizeof narrow;
      }
      row += kFacetBytes;
    }
    sink_->write(bytes);
  }

  void write_text(std::span<const Triangle64> batch) {
    TextBuilder text;
    const auto add_line = [&](std::string_view keyword, Vec3 v) {
      text.add(keyword);
      for (int axis = 0; axis < 3; ++axis) {
        text.add(' ');
        text.add_number(v[axis]);
      }
      text.add('\n');
    };
    for (const Triangle64& triangle : batch) {
      const std::array<Vec3, 4> f = facet(triangle);
      add_line("facet normal", f[0]);
      text.add("outer loop\n");
      for (std::size_t corner = 1; corner < 4; ++corner) add_line("vertex", f[corner]);
      text.add("endloop\nendfacet\n");
    }
    sink_->write(text.take());
  }

  std::unique_ptr<ByteSink> sink_;
  bool binary_;
  Vec3 origin_;
  RowCounter counter_;
  PositionFile positions_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_stl_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options,
                                            const std::filesystem::path& path) {
  return std::make_unique<StlWriter>(std::move(sink), header, options, path);
}

}  // namespace orbweave
