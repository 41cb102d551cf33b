#include <filesystem>
#include <utility>

#include "io/bounds.h"
#include "io/meshes/file_with_places.h"
#include "io/meshes/glb_layout.h"
#include "io/meshes/mesh_formats.h"
#include "io/system/atomic_file.h"
#include "io/system/placed_file.h"

namespace orbweave {
namespace {

/// The document at the file's front needs the bounds of all vertices, so it is written last.
class GlbWriter final : public MeshWriter {
 public:
  GlbWriter(const std::filesystem::path& path, const MeshHeader& header,
            const MeshWriterOptions& options)
      : layout_(header, options),
        target_(file_with_places(path, "GLB")),
        file_(target_.temporary(), path),
        counter_(header),
        at_(layout_.front({}).size()) {
    file_.reserve(layout_.file_bytes());
  }

  void write_vertices(const PointCloud& batch) override {
    counter_.vertices(batch.size());
    bounds_.extend(bounds_of(batch.positions));
    std::vector<std::byte> bytes(batch.size() * layout_.vertex_bytes());
    layout_.put_vertices(batch, bytes.data());
    append(bytes);
  }
  void write_triangles(std::span<const Triangle64> batch,
                       std::span<const std::int32_t> hole) override {
    counter_.triangles(batch.size());
    std::vector<std::byte> bytes(batch.size() * layout_.triangle_bytes());
    layout_.put_triangles(batch, hole, bytes.data());
    append(bytes);
  }
  void finish() override {
    counter_.finish();
    const std::string front = layout_.front(bounds_);
    file_.write(0, std::as_bytes(std::span(front)));
    file_.flush();
    target_.commit();
  }
  std::uint64_t bytes_written() const override { return layout_.file_bytes(); }

 private:
  void append(std::span<const std::byte> bytes) {
    file_.write(at_, bytes);
    at_ += bytes.size();
  }

  GlbLayout layout_;
  AtomicFile target_;
  PlacedFile file_;
  RowCounter counter_;
  Box bounds_;
  std::uint64_t at_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_glb_writer(const std::filesystem::path& path,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options) {
  return std::make_unique<GlbWriter>(path, header, options);
}

}  // namespace orbweave
