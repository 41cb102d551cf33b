// The vertices of a PLY file.
#pragma once

#include "io/ply/ply_rows.h"

namespace orbweave {

/// True when the stream begins as PLY does.
bool looks_like_ply(ByteReader& reader);

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
