#include <utility>

#include "io/meshes/mesh_formats.h"

namespace orbweave {
namespace {

/// Wavefront OBJ: positions, normals where there are any, triangles. Attributes have no place.
class ObjWriter final : public IndependentWriter {
 public:
  ObjWriter(std::unique_ptr<ByteSink> sink, const MeshHeader& header)
      : IndependentWriter(std::move(sink), header), has_normals_(header.schema.has_normals) {}

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

 private:
  static void add_vector(TextBuilder& text, std::string_view keyword, Vec3 v) {
    text.add(keyword);
    for (int axis = 0; axis < 3; ++axis) {
      text.add(' ');
      text.add_number(v[axis]);
    }
    text.add('\n');
  }

  bool has_normals_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_obj_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header) {
  return std::make_unique<ObjWriter>(std::move(sink), header);
}

}  // namespace orbweave
