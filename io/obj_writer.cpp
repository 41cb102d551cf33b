#include <utility>

#include "io/mesh_formats.h"

namespace orbweave {
namespace {

/// Wavefront OBJ: positions, normals where there are any, triangles. Attributes have no place.
class ObjWriter final : public MeshWriter {
 public:
  ObjWriter(std::unique_ptr<ByteSink> sink, const MeshHeader& header)
      : sink_(std::move(sink)), has_normals_(header.schema.has_normals), counter_(header) {}

  bool encodes_independently() const override { return true; }
  std::vector<std::byte> encode_vertices(const PointCloud& batch) const override {
    constexpr std::size_t kTypicalLine = 64;
    TextBuilder text;
    text.reserve(batch.size() * kTypicalLine);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      add_vector(text, "v", batch.positions[i]);
      if (has_normals_) add_vector(text, "vn", batch.normals[i]);
    }
    return text.take();
  }
  std::vector<std::byte> encode_triangles(std::span<const Triangle64> batch,
                                          std::span<const std::int32_t>) const override {
    TextBuilder text;
    for (const Triangle64& triangle : batch) {
      text.add('f');
      for (const std::uint64_t corner : triangle) {
        text.add(' ');
        text.add_number(corner + 1);  // OBJ counts from one
        if (has_normals_) {
          text.add("//");
          text.add_number(corner + 1);
        }
      }
      text.add('\n');
    }
    return text.take();
  }
  void write_vertices(const PointCloud& batch) override {
    write_encoded_vertices(encode_vertices(batch), batch.size());
  }
  void write_triangles(std::span<const Triangle64> batch,
                       std::span<const std::int32_t> hole) override {
    write_encoded_triangles(encode_triangles(batch, hole), batch.size());
  }
  void write_encoded_vertices(std::span<const std::byte> bytes, std::uint64_t vertices) override {
    counter_.vertices(vertices);
    sink_->write(bytes);
  }
  void write_encoded_triangles(std::span<const std::byte> bytes, std::uint64_t triangles) override {
    counter_.triangles(triangles);
    sink_->write(bytes);
  }
  void finish() override {
    counter_.finish();
    sink_->finish();
  }
  std::uint64_t bytes_written() const override { return sink_->bytes_written(); }

 private:
  static void add_vector(TextBuilder& text, std::string_view keyword, Vec3 v) {
    text.add(keyword);
    for (int axis = 0; axis < 3; ++axis) {
      text.add(' ');
      text.add_number(v[axis]);
    }
    text.add('\n');
  }

  std::unique_ptr<ByteSink> sink_;
  bool has_normals_;
  RowCounter counter_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_obj_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header) {
  return std::make_unique<ObjWriter>(std::move(sink), header);
}

}  // namespace orbweave
