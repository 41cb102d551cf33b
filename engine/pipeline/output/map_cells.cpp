#include "engine/pipeline/output/map_cells.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "engine/pipeline/output/number_set.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// Rows of vertices that are read at once.
constexpr std::uint64_t kMostRows = 4096;
constexpr std::uint64_t kWidestGap = 64;
constexpr std::size_t kLeastRun = std::size_t{1} << 14;

using FloatVector = std::array<float, 3>;

std::byte* put_normal(ScalarType type, Vec3 normal, std::byte* out) {
  if (type != ScalarType::kFloat32) {
    std::memcpy(out, &normal, sizeof normal);
    return out + sizeof normal;
  }
  const FloatVector floats = {static_cast<float>(normal.x), static_cast<float>(normal.y),
                              static_cast<float>(normal.z)};
  std::memcpy(out, floats.data(), sizeof floats);
  return out + sizeof floats;
}

Vec3 normal_at(ScalarType type, const std::byte* in) {
  Vec3 normal;
  if (type != ScalarType::kFloat32) {
    std::memcpy(&normal, in, sizeof normal);
    return normal;
  }
  FloatVector floats;
  std::memcpy(floats.data(), in, sizeof floats);
  return {floats[0], floats[1], floats[2]};
}

[[noreturn]] void refuse_size(const Job& job, const std::string& problem, const std::string& found,
                              const std::string& expected) {
  throw_usage(problem, {.file = job.output.mesh,
                        .place = setting_name(job, "output.tile_size"),
                        .found = format_exact(job.output.tile_size) + ", " + found,
                        .expected = expected,
                        .advice = "Choose larger tiles; the work that is done is kept"});
}

void check_count(const Job& job, const TrianglesByCell& triangles) {
  if (triangles.cells().size() <= kMostTiles) return;
  refuse_size(job, "the mesh falls into too many tiles",
              "which makes more than " + format_count(kMostTiles) + " tiles",
              "at most " + format_count(kMostTiles));
}

/// The cells of a piece's triangles.
void find_cells(const Job& job, const SpooledVertices& vertices, const MapGrid& grid,
                PieceRows& rows) {
  NumberSet numbers;
  for (const Triangle64& t : rows.triangles)
    for (const std::uint64_t corner : t) numbers.add(corner);
  numbers.count_up();
  std::vector<Vec3> positions;
  positions.reserve(numbers.count());
  numbers.for_blocks(
      [&](std::span<const std::uint64_t> block) { vertices.add_positions(block, positions); });
  const auto position = [&](std::uint64_t number) { return positions[numbers.rank(number)]; };
  rows.cells.clear();
  for (const Triangle64& t : rows.triangles) {
    const Vec3 centroid = (position(t[0]) + position(t[1]) + position(t[2])) / 3.0;
    const std::optional<MapCell> cell = grid.cell_of(centroid);
    if (!cell)
      refuse_size(
          job, "the tiles are too small for the coordinates",
          "and a triangle at x = " + format_exact(centroid.x) + ", y = " + format_exact(centroid.y),
          "a cell's column and row within 32 bit");
    rows.cells.push_back(*cell);
  }
}

std::vector<MeshPiece> pieces_with(const MeshPieces& pieces, bool vertices) {
  std::vector<MeshPiece> chosen;
  for (const MeshPiece& piece : pieces.all())
    if (piece.has_vertices() == vertices) chosen.push_back(piece);
  return chosen;
}

}  // namespace

SpooledVertices::SpooledVertices(const std::filesystem::path& directory, PointSchema schema)
    : schema_(std::move(schema)),
      normal_bytes_(schema_.has_normals ? 3 * size_of(schema_.normal_type) : 0),
      row_bytes_(sizeof(Vec3) + normal_bytes_ + schema_.attribute_bytes()),
      file_(directory) {}

void SpooledVertices::append(const PointCloud& vertices) {
  std::vector<std::byte> rows(vertices.size() * row_bytes_);
  const std::size_t width = schema_.attribute_bytes();
  std::byte* at = rows.data();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    std::memcpy(at, &vertices.positions[i], sizeof(Vec3));
    at += sizeof(Vec3);
    if (schema_.has_normals) at = put_normal(schema_.normal_type, vertices.normals[i], at);
    at = std::copy_n(vertices.attributes.data() + i * width, width, at);
  }
  file_.append(rows);
}

template <class Take>
void SpooledVertices::read_rows(std::span<const std::uint64_t> numbers, const Take& take) const {
  std::vector<std::byte> rows;
  for (std::size_t begin = 0; begin < numbers.size();) {
    std::size_t end = begin + 1;
    while (end < numbers.size() && numbers[end] - numbers[end - 1] <= kWidestGap &&
           numbers[end] - numbers[begin] < kMostRows)
      ++end;
    rows.resize((numbers[end - 1] - numbers[begin] + 1) * row_bytes_);
    file_.read(numbers[begin] * row_bytes_, rows);
    for (std::size_t i = begin; i < end; ++i)
      take(rows.data() + (numbers[i] - numbers[begin]) * row_bytes_);
    begin = end;
  }
}

void SpooledVertices::load(std::span<const std::uint64_t> numbers, PointCloud& vertices) const {
  vertices.clear();
  vertices.schema = schema_;
  read_rows(numbers, [&](const std::byte* row) {
    Vec3 position;
    std::memcpy(&position, row, sizeof position);
    vertices.positions.push_back(position);
    row += sizeof position;
    if (schema_.has_normals) vertices.normals.push_back(normal_at(schema_.normal_type, row));
    row += normal_bytes_;
    vertices.attributes.insert(vertices.attributes.end(), row, row + schema_.attribute_bytes());
  });
}

void SpooledVertices::add_positions(std::span<const std::uint64_t> numbers,
                                    std::vector<Vec3>& positions) const {
  read_rows(numbers, [&](const std::byte* row) {
    std::memcpy(&positions.emplace_back(), row, sizeof(Vec3));
  });
}

TrianglesByCell::TrianglesByCell(const std::filesystem::path& directory, std::size_t run_bytes)
    : most_(std::clamp<std::size_t>(run_bytes / sizeof(CellTriangle), kLeastRun,
                                    std::numeric_limits<std::uint32_t>::max())),
      file_(directory) {}

void TrianglesByCell::add(const CellTriangle& triangle) {
  if (run_.size() == most_) flush();
  if (run_.size() == run_.capacity())
    run_.reserve(std::min(most_, std::max(2 * run_.size(), kLeastRun)));
  run_.push_back(triangle);
  run_.back().row = static_cast<std::uint32_t>(run_.size() - 1);
}

void TrianglesByCell::flush() {
  tbb::parallel_sort(run_.begin(), run_.end(), [](const CellTriangle& a, const CellTriangle& b) {
    return std::tie(a.cell, a.row) < std::tie(b.cell, b.row);
  });
  std::uint64_t first =
      file_.append_values(std::span<const CellTriangle>(run_)) / sizeof(CellTriangle);
  for (std::size_t begin = 0; begin < run_.size();) {
    std::size_t end = begin;
    while (end < run_.size() && run_[end].cell == run_[begin].cell) ++end;
    parts_[run_[begin].cell].push_back({first, end - begin});
    first += end - begin;
    begin = end;
  }
  run_.clear();
}

void TrianglesByCell::read(std::uint64_t first, std::span<CellTriangle> triangles) const {
  file_.read_values(first * sizeof(CellTriangle), triangles);
}

std::unique_ptr<CutMesh> cut_by_map(StageRunner& runner, const TileInput& input,
                                    const MapGrid& grid, SurfaceDigest& digest) {
  const ResolvedJob& job = runner.job;
  const MemoryPlan plan = job.memory_plan(input.partition.points(), input.partition.schema);
  auto made = std::make_unique<CutMesh>(runner.store.directory(), input.header.schema,
                                        plan.chunks_in_flight_bytes / 4);
  CutMesh& cut = *made;
  const std::size_t in_flight = pieces_in_flight(job, input.columns.stored);
  const auto done = [&](const MeshPiece& piece, const PieceRows& rows) {
    digest.add(rows.digest);
    runner.progress.advance(piece.stored);
  };
  const auto load = [&](const MeshPiece& piece, PieceRows& rows) {
    input.pieces.load(piece, input.columns, rows);
  };
  run_in_order(runner, pieces_with(input.pieces, true), in_flight, load,
               [&](const MeshPiece& piece, PieceRows& rows) {
                 cut.vertices.append(rows.vertices);
                 done(piece, rows);
               });
  const auto load_and_find = [&](const MeshPiece& piece, PieceRows& rows) {
    load(piece, rows);
    find_cells(job, cut.vertices, grid, rows);
  };
  run_in_order(runner, pieces_with(input.pieces, false), in_flight, load_and_find,
               [&](const MeshPiece& piece, PieceRows& rows) {
                 for (std::size_t i = 0; i < rows.triangles.size(); ++i)
                   cut.triangles.add({rows.cells[i], rows.triangles[i], rows.hole[i], 0});
                 check_count(job, cut.triangles);
                 done(piece, rows);
               });
  cut.triangles.flush();
  check_count(job, cut.triangles);
  return made;
}

}  // namespace orbweave
