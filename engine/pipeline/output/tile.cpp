#include "engine/pipeline/output/tile.h"

#include <algorithm>
#include <utility>

#include "engine/holes/patch/patch_vertices.h"
#include "engine/pipeline/output/tile_columns.h"
#include "engine/pipeline/surface/patch_batch.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/stitching/local_numbers.h"
#include "io/store/chunk_points.h"
#include "io/vertex_quality.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kBatchRows = std::uint64_t{1} << 16;

}  // namespace

std::vector<PatchRun> patch_runs(const ChunkStore& store, const TileInput& input) {
  std::vector<PatchRun> runs;
  for (ChunkId batch = 0; batch < input.holes.new_triangles.size(); ++batch) {
    if (input.holes.new_triangles[batch] == 0) continue;
    const std::vector<std::int32_t> hole = load_patch_batch(store, batch).hole;
    for (std::uint64_t row = 0; row < hole.size(); ++row) {
      const HoleFacts& facts = input.holes.holes.at(static_cast<std::size_t>(hole[row] - 1));
      const ChunkId chunk = input.partition.chunk_of(facts.first_vertex);
      if (row == 0 || runs.back().chunk != chunk) runs.push_back({chunk, batch, row, 0});
      ++runs.back().rows;
    }
  }
  std::stable_sort(runs.begin(), runs.end(),
                   [](const PatchRun& a, const PatchRun& b) { return a.chunk < b.chunk; });
  return runs;
}

FirstRows first_rows(const TileInput& input) {
  FirstRows rows;
  rows.of_chunk.assign(input.partition.octree.chunks().size(), 0);
  rows.of_batch.assign(input.holes.new_triangles.size(), 0);
  for (const MeshPiece& piece : input.pieces.all()) {
    if (piece.kind == MeshPiece::Kind::kTriangles && piece.first == 0) {
      rows.of_chunk[piece.part] = piece.row;
    }
    if (piece.kind == MeshPiece::Kind::kPatches) rows.of_batch[piece.part] = piece.row;
  }
  return rows;
}

Tile::Tile(const ChunkStore& store, const TileInput& input, ChunkId chunk,
           std::span<const PatchRun> patches, const FirstRows& first_rows)
    : store_(store),
      input_(input),
      chunk_(chunk),
      first_(input.partition.first_vertex[chunk]),
      points_(input.partition.points_in(chunk)),
      ranks_(input.used),
      own_(points_) {
  load_scanned();
  add_run(first_rows.of_chunk[chunk], triangles_.size());
  hole_.assign(triangles_.size(), 0);
  load_patches(patches, first_rows);
  find_vertices();
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (t % kStopBlock == 0) input_.stop.check();
    triangles_[t] = in_tile_numbers(triangles_[t]);
  }
}

void Tile::load_scanned() {
  const auto stored = store_.open(kMeshStage, chunk_);
  const auto outer = stored->read_all<std::uint64_t>(kStoredOuter);
  const LocalNumbers local(first_, points_, outer);
  const std::uint64_t count = stored->rows(kStoredTriangles);
  triangles_.reserve(count);
  std::vector<Triangle> rows;
  for (std::uint64_t first = 0; first < count; first += rows.size()) {
    input_.stop.check();
    rows.resize(std::min(kBatchRows, count - first));
    stored->read(kStoredTriangles, first, rows.size(), rows.data());
    for (const Triangle& t : rows) triangles_.push_back(local.global(t));
  }
  const OutputNumbers& numbers = input_.pieces.numbers();
  if (!numbers.any_removed()) return;
  std::erase_if(triangles_, [&](const Triangle64& t) { return numbers.is_removed(t); });
}

void Tile::load_patches(std::span<const PatchRun> patches, const FirstRows& first_rows) {
  const OutputNumbers& numbers = input_.pieces.numbers();
  PatchBatch batch;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const PatchRun& run = patches[i];
    if (i == 0 || patches[i - 1].batch != run.batch) batch = load_patch_batch(store_, run.batch);
    add_run(first_rows.of_batch[run.batch] + run.first, run.rows);
    for (std::uint64_t row = run.first; row < run.first + run.rows; ++row) {
      triangles_.push_back(numbers.over_all_batches(batch.triangles[row], run.batch));
      hole_.push_back(batch.hole[row]);
    }
  }
}

void Tile::add_run(std::uint64_t first, std::uint64_t rows) {
  if (rows == 0) return;
  const std::uint64_t row = runs_.empty() ? 0 : runs_.back().row + runs_.back().rows;
  if (!runs_.empty() && runs_.back().first + runs_.back().rows == first) {
    runs_.back().rows += rows;
  } else {
    runs_.push_back({row, first, rows});
  }
}

bool Tile::is_own(std::uint64_t source, std::uint64_t id) const {
  return source >= first_ && source - first_ < points_ && id < input_.used.count();
}

void Tile::find_vertices() {
  const OutputNumbers& numbers = input_.pieces.numbers();
  std::vector<std::uint8_t> used(points_, 0);
  for (const Triangle64& t : triangles_) {
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t id = value_of(numbers.of_corner(t, k, ranks_));
      if (is_own(t[k], id)) {
        used[t[k] - first_] = 1;
      } else {
        outer_.push_back({id, t[k]});
      }
    }
  }
  own_.mark(used);
  own_.number();
  std::sort(outer_.begin(), outer_.end());
  outer_.erase(std::unique(outer_.begin(), outer_.end()), outer_.end());
  const Outer own_begin = {input_.used.before_chunk(chunk_), 0};
  outer_below_ = static_cast<std::size_t>(
      std::lower_bound(outer_.begin(), outer_.end(), own_begin) - outer_.begin());
}

Triangle64 Tile::in_tile_numbers(const Triangle64& t) {
  Triangle64 result;
  for (int k = 0; k < 3; ++k) {
    const std::uint64_t id = value_of(input_.pieces.numbers().of_corner(t, k, ranks_));
    if (is_own(t[k], id)) {
      result[k] = outer_below_ + own_.rank(t[k] - first_);
      continue;
    }
    const auto at = std::lower_bound(outer_.begin(), outer_.end(), Outer{id, 0});
    const auto rank = static_cast<std::size_t>(at - outer_.begin());
    result[k] = rank < outer_below_ ? rank : rank + own_.count();
  }
  return result;
}

MeshHeader Tile::header() const {
  return {vertices(), triangles(), false, input_.header.has_hole, tile_schema(input_.header)};
}

void Tile::write(MeshWriter& writer, Box& bounds) {
  const std::span<const Outer> outer(outer_);
  write_outer(writer, outer.first(outer_below_), bounds);
  write_own(writer, bounds);
  write_outer(writer, outer.subspan(outer_below_), bounds);
  const std::span<const Triangle64> triangles(triangles_);
  const std::span<const std::int32_t> hole(hole_);
  for (std::size_t first = 0; first < triangles.size(); first += kBatchRows) {
    input_.stop.check();
    const std::size_t rows = std::min<std::size_t>(kBatchRows, triangles.size() - first);
    writer.write_triangles(triangles.subspan(first, rows),
                           input_.header.has_hole ? hole.subspan(first, rows) : hole.first(0));
  }
}

void Tile::write_own(MeshWriter& writer, Box& bounds) {
  PointCloud cloud;
  std::vector<std::uint64_t> ids;
  for (std::uint64_t first = 0; first < points_; first += kBatchRows) {
    input_.stop.check();
    const std::uint64_t rows = std::min(kBatchRows, points_ - first);
    load_vertex_rows(store_, input_.partition.stage, chunk_, input_.columns, first, rows, cloud);
    keep_used(cloud, own_, first);
    ids.clear();
    for (std::uint64_t row = first; row < first + rows; ++row) {
      if (own_.used(row)) ids.push_back(value_of(ranks_.of(first_ + row)));
    }
    write_batch(writer, cloud, ids, bounds);
  }
}

void Tile::write_outer(MeshWriter& writer, std::span<const Outer> vertices, Box& bounds) const {
  std::vector<std::uint64_t> ids;
  while (!vertices.empty()) {
    input_.stop.check();
    PointCloud cloud;
    const std::uint64_t id = vertices.front().id;
    const bool is_new = id >= input_.used.count() && id < input_.pieces.numbers().first_copy();
    const std::size_t count = is_new ? append_new(vertices, cloud) : append_points(vertices, cloud);
    ids.clear();
    for (const Outer& vertex : vertices.first(count)) ids.push_back(vertex.id);
    write_batch(writer, cloud, ids, bounds);
    vertices = vertices.subspan(count);
  }
}

/// Points of one chunk that lie close together in its file; copies of points as well. Returns how
/// many.
std::size_t Tile::append_points(std::span<const Outer> vertices, PointCloud& cloud) const {
  const auto& starts = input_.partition.first_vertex;
  const std::uint64_t first = vertices.front().source;
  const ChunkId chunk = input_.partition.chunk_of(first);
  const std::size_t count = read_at_once(
      vertices.size(), [&](std::size_t i) { return vertices[i].source; }, starts[chunk + 1],
      kBatchRows);
  PointCloud read;
  load_vertex_rows(store_, input_.partition.stage, chunk, input_.columns, first - starts[chunk],
                   vertices[count - 1].source - first + 1, read);
  cloud.schema = read.schema;
  for (const Outer& vertex : vertices.first(count)) cloud.append(read, vertex.source - first);
  return count;
}

/// New vertices of one batch of patches. Returns how many.
std::size_t Tile::append_new(std::span<const Outer> vertices, PointCloud& cloud) const {
  const OutputNumbers& numbers = input_.pieces.numbers();
  ChunkId batch = 0;
  while (batch + 1 < input_.holes.new_vertices.size() &&
         numbers.first_of_batch(batch + 1) <= vertices.front().id) {
    ++batch;
  }
  const std::uint64_t begin = numbers.first_of_batch(batch);
  const std::uint64_t end = begin + input_.holes.new_vertices[batch];
  PatchBatch patches = load_patch_batch(store_, batch);
  mark_invented(input_.columns.stored, patches.values);
  PointCloud read =
      patch_vertices(input_.columns.stored, patches.positions, patches.normals, patches.values);
  mark_unsampled(input_.columns, read);
  cloud.schema = read.schema;
  std::size_t count = 0;
  while (count < vertices.size() && vertices[count].id < end && count < kBatchRows) {
    cloud.append(read, vertices[count++].id - begin);
  }
  return count;
}

void Tile::write_batch(MeshWriter& writer, PointCloud& cloud, std::span<const std::uint64_t> ids,
                       Box& bounds) const {
  bounds.extend(cloud.bounds());
  input_.columns.colors.apply(cloud);
  add_vertex_ids(input_.header, ids, cloud);
  writer.write_vertices(cloud);
}

}  // namespace orbweave
