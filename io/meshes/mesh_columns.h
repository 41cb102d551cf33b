// A mesh as columns: one array per thing that vertices or triangles carry, as VTK and HDF5 have it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/meshes/mesh_writer.h"

namespace orbweave {

/// An array with a row per vertex or per triangle.
struct MeshColumn {
  enum class Of { kPoint, kNormal, kAttribute, kColor, kCorners, kEnds, kHole };
  std::string name;
  Of of = Of::kPoint;
  ScalarType type = ScalarType::kFloat64;
  std::size_t components = 1;
  std::uint64_t rows = 0;
  std::vector<std::size_t> offsets = {};  ///< of kAttribute and kColor: in a row of attributes

  std::size_t row_bytes() const { return components * size_of(type); }
  std::uint64_t bytes() const { return rows * row_bytes(); }
};

/// The columns of a mesh. Red, green and blue of one width are one column "RGB" of three
/// components, which programs show as colours; every other attribute has a column of its own name.
/// Numbers are those of the vertices, at their own widths; points are counted from the origin.
class MeshColumns {
 public:
  /// `has_ends`: a column with the end of each triangle among all corners, 3, 6, 9, ...
  MeshColumns(const MeshHeader& header, const MeshWriterOptions& options, bool has_ends);

  const std::vector<MeshColumn>& of_vertices() const { return vertices_; }
  const std::vector<MeshColumn>& of_triangles() const { return triangles_; }

  /// The rows of a column for a batch of vertices, or of triangles, of which `first` is the number
  /// of the first one.
  std::vector<std::byte> rows(const MeshColumn& column, const PointCloud& batch) const;
  std::vector<std::byte> rows(const MeshColumn& column, std::span<const Triangle64> batch,
                              std::span<const std::int32_t> hole, std::uint64_t first) const;

 private:
  void add_attributes(const MeshHeader& header);

  Vec3 origin_;
  std::size_t attribute_bytes_;
  std::vector<MeshColumn> vertices_;
  std::vector<MeshColumn> triangles_;
};

}  // namespace orbweave
