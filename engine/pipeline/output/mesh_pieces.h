// The output mesh as pieces of rows in the file's order: points that are used, vertices of patches,
// copies of vertices, triangles of chunks, triangles of patches. Where each lies in the file is
// known before any of them is read.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/pipeline/output/chunk_numbers.h"
#include "engine/pipeline/output/output_numbers.h"
#include "engine/pipeline/output/vertex_columns.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "io/meshes/map_grid.h"
#include "io/meshes/mesh_checksum.h"
#include "io/system/placed_file.h"

namespace orbweave {

/// A run of rows that is read, encoded and written at once.
struct MeshPiece {
  enum class Kind : std::uint8_t { kPoints, kNewVertices, kCopies, kTriangles, kPatches };
  Kind kind = Kind::kPoints;
  ChunkId part = 0;          ///< chunk, or batch of patches
  std::uint64_t first = 0;   ///< stored row
  std::uint64_t stored = 0;  ///< rows as stored
  std::uint64_t row = 0;     ///< its first row among the file's vertices or triangles
  std::uint64_t rows = 0;    ///< rows in the file

  bool has_vertices() const { return kind < Kind::kTriangles; }
};

struct PieceRows;

/// Checksum and bounds of the pieces that were added, in any order.
class SurfaceDigest {
 public:
  void add(const MeshPiece& piece, const PieceRows& rows);
  void add(const SurfaceDigest& other);
  std::string checksum() const { return checksum_.hex(); }
  const Box& bounds() const { return bounds_; }

  /// For another process of the team, and back; throws std::logic_error where it is no digest.
  std::string text() const;
  static SurfaceDigest from_text(const std::string& text);

 private:
  MeshChecksum checksum_;
  Box bounds_;
};

/// A piece in memory, and what becomes of it. Used again for piece after piece.
struct PieceRows {
  PointCloud vertices;
  std::vector<Triangle> stored;  ///< triangles as they were read
  std::vector<Triangle64> triangles;
  std::vector<std::int32_t> hole;
  std::vector<MapCell> cells;            ///< of the triangles, where a map grid cuts the mesh
  SurfaceDigest digest;                  ///< of the piece alone
  std::vector<std::byte> encoded;        ///< for a writer that writes in order
  std::unique_ptr<PlacedBuffer> placed;  ///< for one that does not
};

/// All pieces of a mesh. Everything handed in must outlive the object.
class MeshPieces {
 public:
  /// `triangles`: stored ones, per chunk.
  MeshPieces(const ChunkStore& store, const Partition& partition, const UsedVertices& used,
             const FilledHoles& holes, const std::vector<std::uint64_t>& triangles);

  const std::vector<MeshPiece>& all() const { return pieces_; }
  const OutputNumbers& numbers() const { return numbers_; }
  std::uint64_t vertices() const { return vertices_; }
  std::uint64_t triangles() const { return triangles_; }
  /// Reads a piece; vertices have the columns that are written. Triangles are numbered as in the
  /// file. Thread-safe. Throws std::logic_error where it has not as many rows as it was said to
  /// have.
  void load(const MeshPiece& piece, const VertexColumns& columns, PieceRows& rows) const;

 private:
  void list_vertices();
  void list_triangles(const std::vector<std::uint64_t>& stored);
  void add(MeshPiece piece);
  void load_points(const MeshPiece& piece, const VertexColumns& columns, PieceRows& rows) const;
  void load_copies(const MeshPiece& piece, const VertexColumns& columns, PieceRows& rows) const;
  void load_new_vertices(const MeshPiece& piece, const VertexColumns& columns,
                         PieceRows& rows) const;
  void load_triangles(const MeshPiece& piece, PieceRows& rows) const;
  void load_patches(const MeshPiece& piece, PieceRows& rows) const;
  std::uint64_t removed_before(ChunkId chunk, std::uint64_t row, std::uint64_t stored) const;

  const ChunkStore& store_;
  const Partition& partition_;
  const UsedVertices& used_;
  const FilledHoles& holes_;
  OutputNumbers numbers_;
  mutable RecentChunkNumbers of_chunks_;
  std::vector<MeshPiece> pieces_;
  std::uint64_t vertices_ = 0;
  std::uint64_t triangles_ = 0;
};

/// Keeps the points that are used; the first of the cloud is number `first` of `used`.
void keep_used(PointCloud& points, const RankedPoints& used, std::uint64_t first);

/// How many pieces may be in memory at a time: two more than there are threads, fewer where the
/// budget is small.
std::size_t pieces_in_flight(const ResolvedJob& job, const PointSchema& schema);

/// prepare(piece, rows) by all threads, then put(piece, rows) in order.
void run_in_order(StageRunner& runner, const std::vector<MeshPiece>& pieces, std::size_t in_flight,
                  const std::function<void(const MeshPiece&, PieceRows&)>& prepare,
                  const std::function<void(const MeshPiece&, PieceRows&)>& put);

/// Checksum and bounds of all pieces.
SurfaceDigest digest_pieces(StageRunner& runner, const MeshPieces& pieces);

}  // namespace orbweave
