// A mesh as XDMF: an XML document, and an HDF5 file beside it with the numbers.
// XDMF Model and Format, version 3 (www.xdmf.org).
#include <string>
#include <utility>
#include <vector>

#include "io/meshes/file_with_places.h"
#include "io/meshes/heavy_data.h"
#include "io/meshes/mesh_columns.h"
#include "io/meshes/mesh_formats.h"
#include "io/meshes/placed_columns.h"
#include "io/system/atomic_file.h"
#include "io/system/hdf5_calls.h"

namespace orbweave {
namespace {

using Of = MeshColumn::Of;

/// Readers of XDMF know no unsigned integers of 8 bytes and take them for those of 4. The signed
/// ones hold all values below 2^63.
std::string number_type(ScalarType type) {
  constexpr const char* kNames[] = {"Char", "UChar", "Short", "UShort", "Int",
                                    "UInt", "Int",   "Int",   "Float",  "Float"};
  const auto at = static_cast<std::size_t>(type);
  return std::string("NumberType=\"") + kNames[at] + "\" Precision=\"" +
         std::to_string(size_of(type)) + "\"";
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text)
    safe += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return safe;
}

std::string item_text(const MeshColumn& column, const std::string& file) {
  return "<DataItem Dimensions=\"" + std::to_string(column.rows) +
         (column.components > 1 ? " " + std::to_string(column.components) : std::string()) + "\" " +
         number_type(column.type) + " Format=\"HDF\">" + escaped(file) + ":/" + column.name +
         "</DataItem>\n";
}

std::string column_text(const MeshColumn& column, const std::string& file) {
  const std::string item = item_text(column, file);
  switch (column.of) {
    case Of::kPoint:
      return "<Geometry GeometryType=\"XYZ\">\n" + item + "</Geometry>\n";
    case Of::kCorners:
      return "<Topology TopologyType=\"Triangle\" NumberOfElements=\"" +
             std::to_string(column.rows) + "\">\n" + item + "</Topology>\n";
    default:
      return "<Attribute Name=\"" + column.name + "\" AttributeType=\"" +
             (column.components == 3 ? "Vector" : "Scalar") + "\" Center=\"" +
             (column.of == Of::kHole ? "Cell" : "Node") + "\">\n" + item + "</Attribute>\n";
  }
}

std::string document(const MeshColumns& columns, const std::string& file) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"mesh\" "
      "GridType=\"Uniform\">\n";
  for (const auto* list : {&columns.of_triangles(), &columns.of_vertices()})
    for (const MeshColumn& column : *list) text += column_text(column, file);
  return text + "</Grid>\n</Domain>\n</Xdmf>\n";
}

std::vector<std::uint64_t> make_arrays(const AtomicFile& file, const std::filesystem::path& name,
                                       const MeshColumns& columns) {
  std::vector<Hdf5Array> arrays;
  for (const auto* list : {&columns.of_vertices(), &columns.of_triangles()})
    for (const MeshColumn& column : *list) {
      std::vector<std::uint64_t> shape = {column.rows};
      if (column.components > 1) shape.push_back(column.components);
      arrays.push_back({column.name, column.type, std::move(shape)});
    }
  return make_hdf5_file(file.temporary(), name, arrays);
}

class XdmfWriter final : public MeshWriter {
 public:
  XdmfWriter(const std::filesystem::path& path, const MeshHeader& header,
             const MeshWriterOptions& options)
      : XdmfWriter(path, header, MeshColumns(header, options, false)) {}

  void write_vertices(const PointCloud& batch) override { columns_.write_vertices(batch); }
  void write_triangles(std::span<const Triangle64> batch,
                       std::span<const std::int32_t> hole) override {
    columns_.write_triangles(batch, hole);
  }
  /// The numbers first: a document never names what is not there.
  void finish() override {
    columns_.finish();
    numbers_.commit();
    document_.write(text_);
    document_.commit();
  }
  std::uint64_t bytes_written() const override { return bytes_ + text_.size(); }

 private:
  XdmfWriter(const std::filesystem::path& path, const MeshHeader& header,
             const MeshColumns& columns)
      : text_(document(columns, heavy_data_file(path).filename().string())),
        bytes_(bytes_of(columns)),
        document_(file_with_places(path, "XDMF")),
        numbers_(file_with_places(heavy_data_file(path), "HDF5")),
        columns_(numbers_.temporary(), heavy_data_file(path), header, columns,
                 make_arrays(numbers_, heavy_data_file(path), columns)) {}

  static std::uint64_t bytes_of(const MeshColumns& columns) {
    std::uint64_t bytes = 0;
    for (const auto* list : {&columns.of_vertices(), &columns.of_triangles()})
      for (const MeshColumn& column : *list) bytes += column.bytes();
    return bytes;
  }

  std::string text_;
  std::uint64_t bytes_;  ///< of the columns; HDF5's own structures are small
  AtomicFile document_;
  AtomicFile numbers_;
  PlacedColumns columns_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_xdmf_writer(const std::filesystem::path& path,
                                             const MeshHeader& header,
                                             const MeshWriterOptions& options) {
  return std::make_unique<XdmfWriter>(path, header, options);
}

}  // namespace orbweave
