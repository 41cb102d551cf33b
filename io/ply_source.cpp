#include "io/ply_source.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "io/error.h"

namespace orbweave {
namespace {

const PlyElement& vertices_of(const PlyHeader& header, const ByteReader& reader) {
  const PlyElement* vertices = header.find("vertex");
  if (vertices == nullptr)
    throw_bad_input("the PLY header has no vertices",
                    {.file = reader.name(), .expected = "an element \"vertex\""});
  return *vertices;
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

PlyVertexReader::PlyVertexReader(ByteReader& reader, const PlyHeader& header,
                                 const PlyElement& vertices)
    : rows_(reader, header, vertices),
      layout_(rows_.columns(), rows_.row_bytes(), rows_.swapped()) {
  if (!layout_.missing().empty())
    throw_bad_input(
        "the vertices have no property " + layout_.missing(),
        {.file = reader.name(), .place = "element vertex", .expected = "properties x, y and z"});
}

bool PlyVertexReader::read(PointCloud& batch, std::size_t capacity) {
  batch.clear();
  batch.schema = layout_.schema();
  while (batch.size() < capacity) {
    const std::size_t count = rows_.next(capacity - batch.size());
    if (count == 0) break;
    layout_.append(rows_.rows(), count, batch);
  }
  return !batch.empty();
}

bool looks_like_ply(ByteReader& reader) {
  constexpr std::string_view kMagic = "ply";
  if (!reader.ensure(kMagic.size() + 1)) return false;
  const std::string_view front(reinterpret_cast<const char*>(reader.data()), kMagic.size() + 1);
  return front.substr(0, kMagic.size()) == kMagic && front.back() <= ' ';
}

std::unique_ptr<PointSource> open_ply_source(ByteReader reader) {
  return std::make_unique<PlySource>(std::move(reader));
}

}  // namespace orbweave
