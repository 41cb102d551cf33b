// PLY files as point sources and as meshes.
#pragma once

#include <memory>

#include "io/ply_rows.h"
#include "io/point_source.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// True when the stream begins as PLY does.
bool looks_like_ply(ByteReader& reader);

/// The vertices of a PLY file. Throws Error (bad input) when the header is damaged, when it has
/// no vertices with x, y and z, and when the file is too short for it.
std::unique_ptr<PointSource> open_ply_source(ByteReader reader);

/// Vertices and faces of a PLY file; as read_mesh.
TriangleMesh read_ply_mesh(ByteReader reader);

/// True when the header has a face element with rows and corners.
bool ply_holds_faces(ByteReader reader);

/// Reads the vertex element, batch by batch. The reader stands at its first row.
class PlyVertexReader {
 public:
  PlyVertexReader(ByteReader& reader, const PlyHeader& header, const PlyElement& vertices);
  const PointSchema& schema() const { return layout_.schema(); }
  bool read(PointCloud& batch, std::size_t capacity);
  /// See PlyRowReader.
  bool restrict(std::uint64_t first, std::uint64_t count) { return rows_.restrict(first, count); }
  std::uint64_t rows_left() const { return rows_.rows_left(); }
  /// Leaves the reader behind the element.
  void skip() { rows_.skip(); }

 private:
  PlyRowReader rows_;
  PointRowLayout layout_;
};

}  // namespace orbweave
