// A mesh as VTK XML PolyData: columns behind an XML document, as raw bytes.
// Kitware, VTK File Formats, "XML File Formats"; version 1.0 of the format, with counts of 64 bits.
#include <string>
#include <utility>
#include <vector>

#include "io/meshes/file_with_places.h"
#include "io/meshes/mesh_columns.h"
#include "io/meshes/mesh_formats.h"
#include "io/meshes/placed_columns.h"
#include "io/system/atomic_file.h"

namespace orbweave {
namespace {

/// VTK's name of a type.
const char* vtk_type(ScalarType type) {
  constexpr const char* kNames[] = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                    "UInt32", "Int64", "UInt64", "Float32", "Float64"};
  return kNames[static_cast<std::size_t>(type)];
}

/// Where everything lies in the file.
struct VtpLayout {
  VtpLayout(const MeshHeader& header, const MeshColumns& columns) {
    std::uint64_t offset = 0;
    std::vector<std::string> arrays;
    for (const auto* list : {&columns.of_vertices(), &columns.of_triangles()})
      for (const MeshColumn& column : *list) {
        arrays.push_back(array_text(column, offset));
        counts.push_back(column.bytes());
        places.push_back(offset + sizeof(std::uint64_t));
        offset += sizeof(std::uint64_t) + column.bytes();
      }
    front = document(header, columns, arrays);
    for (std::uint64_t& place : places) place += front.size();
    bytes = front.size() + offset + kEnd.size();
  }

  static constexpr std::string_view kEnd = "\n</AppendedData>\n</VTKFile>\n";
  std::string front;                  ///< up to the first count
  std::vector<std::uint64_t> counts;  ///< bytes of each column, written before the column
  std::vector<std::uint64_t> places;  ///< of each column
  std::uint64_t bytes = 0;            ///< of the whole file

 private:
  /// VTK takes the corners of all triangles as one list: it refuses rows of three.
  static std::string array_text(const MeshColumn& column, std::uint64_t offset) {
    const std::size_t components = column.of == MeshColumn::Of::kCorners ? 1 : column.components;
    return std::string("<DataArray type=\"") + vtk_type(column.type) + "\" Name=\"" + column.name +
           "\" NumberOfComponents=\"" + std::to_string(components) +
           "\" format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n";
  }

  static std::string document(const MeshHeader& header, const MeshColumns& columns,
                              const std::vector<std::string>& arrays) {
    std::string points, point_data, point_names, lines, cell_data;
    std::size_t array = 0;
    for (const MeshColumn& column : columns.of_vertices()) {
      (column.of == MeshColumn::Of::kPoint ? points : point_data) += arrays[array++];
      if (column.of == MeshColumn::Of::kNormal) point_names += " Normals=\"Normals\"";
      if (column.of == MeshColumn::Of::kColor) point_names += " Scalars=\"" + column.name + "\"";
    }
    for (const MeshColumn& column : columns.of_triangles())
      (column.of == MeshColumn::Of::kHole ? cell_data : lines) += arrays[array++];
    return "<?xml version=\"1.0\"?>\n"
           "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
           std::to_string(header.vertices) +
           "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
           std::to_string(header.triangles) + "\">\n<PointData" + point_names + ">\n" + point_data +
           "</PointData>\n<CellData>\n" + cell_data + "</CellData>\n<Points>\n" + points +
           "</Points>\n<Polys>\n" + lines +
           "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  }
};

class VtpWriter final : public MeshWriter {
 public:
  VtpWriter(const std::filesystem::path& path, const MeshHeader& header,
            const MeshWriterOptions& options)
      : VtpWriter(path, header, MeshColumns(header, options, true)) {}

  void write_vertices(const PointCloud& batch) override { columns_.write_vertices(batch); }
  void write_triangles(std::span<const Triangle64> batch,
                       std::span<const std::int32_t> hole) override {
    columns_.write_triangles(batch, hole);
  }
  void finish() override {
    columns_.write(0, std::as_bytes(std::span(layout_.front)));
    for (std::size_t i = 0; i < layout_.counts.size(); ++i)
      columns_.write(layout_.places[i] - sizeof(std::uint64_t),
                     std::as_bytes(std::span(&layout_.counts[i], 1)));
    columns_.write(layout_.bytes - VtpLayout::kEnd.size(),
                   std::as_bytes(std::span(VtpLayout::kEnd)));
    columns_.finish();
    target_.commit();
  }
  std::uint64_t bytes_written() const override { return layout_.bytes; }

 private:
  VtpWriter(const std::filesystem::path& path, const MeshHeader& header, MeshColumns columns)
      : layout_(header, columns),
        target_(file_with_places(path, "VTP")),
        columns_(target_.temporary(), path, header, std::move(columns), layout_.places) {}

  VtpLayout layout_;
  AtomicFile target_;
  PlacedColumns columns_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_vtp_writer(const std::filesystem::path& path,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options) {
  return std::make_unique<VtpWriter>(path, header, options);
}

}  // namespace orbweave
