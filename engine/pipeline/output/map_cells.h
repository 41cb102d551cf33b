// The one mesh cut by the cells of a map grid, on disk: its vertices by number, its triangles by
// cell.
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "engine/pipeline/output/tile_input.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "io/meshes/map_grid.h"
#include "io/system/spool_file.h"

namespace orbweave {

/// Vertices of the one mesh, in its order: position, normal and attributes as they are written.
class SpooledVertices {
 public:
  /// `schema`: of the vertices.
  SpooledVertices(const std::filesystem::path& directory, PointSchema schema);

  void append(const PointCloud& vertices);
  /// The vertices with these numbers, which ascend. Thread-safe.
  void load(std::span<const std::uint64_t> numbers, PointCloud& vertices) const;
  /// Adds where they are. Thread-safe.
  void add_positions(std::span<const std::uint64_t> numbers, std::vector<Vec3>& positions) const;
  std::uint64_t bytes() const { return file_.bytes(); }

 private:
  template <class Take>
  void read_rows(std::span<const std::uint64_t> numbers, const Take& take) const;

  PointSchema schema_;
  std::size_t normal_bytes_;
  std::size_t row_bytes_;
  SpoolFile file_;
};

/// A triangle of the one mesh in a cell. Stored as it is.
struct CellTriangle {
  MapCell cell;
  Triangle64 corners{};
  std::int32_t hole = 0;
  std::uint32_t row = 0;  ///< in its run; settles the order
};

/// The triangles of the one mesh, each cell's in the mesh's order. A run of triangles is sorted in
/// memory and appended to a file; of every cell, the parts of the runs are kept.
class TrianglesByCell {
 public:
  /// Triangles of a cell that lie one after another in the file.
  struct Part {
    std::uint64_t first = 0;
    std::uint64_t count = 0;
  };
  using Parts = std::map<MapCell, std::vector<Part>>;

  /// `run_bytes`: memory of a run.
  TrianglesByCell(const std::filesystem::path& directory, std::size_t run_bytes);

  void add(const CellTriangle& triangle);
  void flush();
  /// The cells that have triangles, by column and row.
  const Parts& cells() const { return parts_; }
  /// Thread-safe.
  void read(std::uint64_t first, std::span<CellTriangle> triangles) const;
  std::uint64_t bytes() const { return file_.bytes(); }

 private:
  std::size_t most_;
  std::vector<CellTriangle> run_;
  Parts parts_;
  SpoolFile file_;
};

struct CutMesh {
  CutMesh(const std::filesystem::path& directory, const PointSchema& schema, std::size_t run_bytes)
      : vertices(directory, schema), triangles(directory, run_bytes) {}

  SpooledVertices vertices;
  TrianglesByCell triangles;
};

/// Cuts the mesh: a triangle belongs to the cell of its centroid, the sum of its corners divided by
/// 3. `digest` gets the mesh's. Throws Error (usage) where coordinates are too large for cells of
/// this size, and where there are more than kMostTiles cells.
std::unique_ptr<CutMesh> cut_by_map(StageRunner& runner, const TileInput& input,
                                    const MapGrid& grid, SurfaceDigest& digest);

/// Most files of a directory: file managers and the index of the tiles have to bear with them.
inline constexpr std::size_t kMostTiles = 100'000;

}  // namespace orbweave
