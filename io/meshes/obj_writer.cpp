#include <span>
#include <string_view>
#include <utility>

#include "io/meshes/mesh_formats.h"
#include "io/meshes/obj_colors.h"

namespace orbweave {
namespace {

/// Wavefront OBJ: positions, colours and normals where there are any, faces. Other attributes have
/// no place.
class ObjWriter final : public IndependentWriter {
 public:
  ObjWriter(std::unique_ptr<ByteSink> sink, const MeshHeader& header,
            const MeshWriterOptions& options)
      : IndependentWriter(std::move(sink), header),
        has_normals_(header.schema.has_normals),
        colors_(header.schema),
        origin_(options.origin) {
    // A file of no bytes is none to a reader.
    constexpr std::string_view kOfNothing = "# no vertices\n";
    if (header.vertices == 0) this->sink().write(std::as_bytes(std::span(kOfNothing)));
  }

  std::vector<std::byte> encode_vertices(const PointCloud& batch) const override {
    constexpr std::size_t kTypicalLine = 64;
    TextBuilder text;
    text.reserve(batch.size() * kTypicalLine);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      add_vector(text, "v", batch.positions[i] - origin_);
      if (colors_.all_are_there()) add_numbers(text, colors_.of(batch, i));
      text.add('\n');
      if (!has_normals_) continue;
      add_vector(text, "vn", batch.normals[i]);
      text.add('\n');
    }
    return text.take();
  }
  std::vector<std::byte> encode_triangles(std::span<const Triangle64> batch,
                                          std::span<const std::int32_t>) const override {
    TextBuilder text;
    for (const Triangle64& triangle : batch) add_face(text, triangle);
    return text.take();
  }

 protected:
  std::vector<std::byte> encode_polygons(const PolygonFaces& faces, std::size_t first,
                                         std::size_t end) const override {
    TextBuilder text;
    for (std::size_t face = first; face < end; ++face) add_face(text, faces.of(face));
    return text.take();
  }

 private:
  template <class Corners>
  void add_face(TextBuilder& text, const Corners& corners) const {
    text.add('f');
    for (const std::uint64_t corner : corners) {
      text.add(' ');
      text.add_number(corner + 1);  // OBJ counts from one
      if (has_normals_) {
        text.add("//");
        text.add_number(corner + 1);
      }
    }
    text.add('\n');
  }
  static void add_vector(TextBuilder& text, std::string_view keyword, Vec3 v) {
    text.add(keyword);
    add_numbers(text, {v.x, v.y, v.z});
  }
  static void add_numbers(TextBuilder& text, std::array<double, 3> numbers) {
    for (const double number : numbers) {
      text.add(' ');
      text.add_number(number);
    }
  }

  bool has_normals_;
  ObjColors colors_;
  Vec3 origin_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_obj_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options) {
  return std::make_unique<ObjWriter>(std::move(sink), header, options);
}

}  // namespace orbweave
