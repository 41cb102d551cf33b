#include "io/clouds/ply_source.h"

#include <algorithm>
#include <utility>

#include "io/error.h"
#include "io/ply/ply_left_out.h"
#include "io/ply/ply_vertices.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

const PlyElement& vertices_of(const PlyHeader& header, const ByteReader& reader) {
  const PlyElement* vertices = header.find("vertex");
  if (vertices == nullptr)
    throw_bad_input("the PLY header has no vertices",
                    {.file = reader.name(), .expected = "an element \"vertex\""});
  return *vertices;
}

/// "3 faces", "1 row of triangle strips"; empty for a cloud.
std::string faces_text(const PlyHeader& header) {
  std::uint64_t faces = 0;
  std::uint64_t strips = 0;
  for (const PlyElement& element : header.elements)
    if (find_corner_list(element)) (are_strips(element) ? strips : faces) += element.count;
  if (faces > 0) return format_count(faces) + (faces == 1 ? " face" : " faces");
  if (strips == 0) return {};
  return format_count(strips) + (strips == 1 ? " row" : " rows") + " of triangle strips";
}

class PlySource final : public PointSource {
 public:
  explicit PlySource(ByteReader reader)
      : reader_(std::move(reader)),
        header_(read_ply_header(reader_)),
        element_(vertices_of(header_, reader_)),
        vertices_(reader_, header_, element_) {
    check_ply_length(reader_, header_);
  }
  const PointSchema& schema() const override { return vertices_.schema(); }
  std::optional<std::uint64_t> declared_points() const override { return element_.count; }
  std::uint64_t bytes_read() const override { return reader_.source().bytes_read(); }
  std::uint64_t bytes_total() const override { return reader_.source().bytes_total(); }
  FileFacts facts() const override {
    FileFacts facts;
    facts.format = "PLY";
    facts.version = "1.0";
    facts.encoding = header_.format == PlyFormat::kAscii                ? "ascii"
                     : header_.format == PlyFormat::kBinaryLittleEndian ? "binary_little_endian"
                                                                        : "binary_big_endian";
    facts.faces = faces_text(header_);
    facts.lost_values = lost_values_of_ply(header_);
    facts.left_out = left_out_of_ply(header_, false);
    return facts;
  }

  bool restrict_rows(std::uint64_t first, std::uint64_t count) override {
    if (!reader_.source().length()) return false;  // decompressed on the way
    if (!std::exchange(started_, true)) skip_to_vertices();
    if (!vertices_.restrict(first, count)) return false;
    ended_ = count < element_.count - first;  // what follows is another's to check
    return true;
  }

  bool read(PointCloud& batch, std::size_t capacity) override {
    if (!std::exchange(started_, true)) skip_to_vertices();
    if (vertices_.read(batch, capacity)) return true;
    if (capacity != 0 && !std::exchange(ended_, true)) check_end();
    return false;
  }

 private:
  void skip_to_vertices() {
    for (const PlyElement& element : header_.elements) {
      if (&element == &element_) return;
      PlyRowReader(reader_, header_, element).skip();
    }
  }
  /// What comes after the vertices is not read, so only a file that ends with them is checked.
  void check_end() {
    const bool more_rows = std::any_of(
        header_.elements.begin() + (&element_ - header_.elements.data()) + 1,
        header_.elements.end(), [](const PlyElement& later) { return later.count != 0; });
    if (!more_rows) check_ply_end(reader_, element_);
  }

  ByteReader reader_;
  PlyHeader header_;
  const PlyElement& element_;
  PlyVertexReader vertices_;
  bool started_ = false;
  bool ended_ = false;
};

}  // namespace

std::unique_ptr<PointSource> open_ply_source(ByteReader reader) {
  return std::make_unique<PlySource>(std::move(reader));
}

}  // namespace orbweave
