#include "engine/pipeline/output/mesh_pieces.h"

#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "engine/holes/patch/patch_vertices.h"
#include "engine/pipeline/surface/patch_batch.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "io/store/chunk_points.h"
#include "io/vertex_quality.h"
#include "partition/allowed_threads.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kPieceRows = std::uint64_t{1} << 16;

}  // namespace

void keep_used(PointCloud& points, const RankedPoints& used, std::uint64_t first) {
  std::size_t kept = 0;
  const std::size_t bytes = points.schema.attribute_bytes();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!used.used(first + i)) continue;
    if (kept != i) {
      points.positions[kept] = points.positions[i];
      if (!points.normals.empty()) points.normals[kept] = points.normals[i];
      std::copy_n(points.attributes.begin() + static_cast<std::ptrdiff_t>(i * bytes), bytes,
                  points.attributes.begin() + static_cast<std::ptrdiff_t>(kept * bytes));
    }
    ++kept;
  }
  points.positions.resize(kept);
  if (!points.normals.empty()) points.normals.resize(kept);
  points.attributes.resize(kept * bytes);
}

MeshPieces::MeshPieces(const ChunkStore& store, const Partition& partition,
                       const UsedVertices& used, const FilledHoles& holes,
                       const std::vector<std::uint64_t>& triangles)
    : store_(store),
      partition_(partition),
      used_(used),
      holes_(holes),
      numbers_(used, holes),
      of_chunks_(store, partition, numbers_) {
  list_vertices();
  list_triangles(triangles);
}

void MeshPieces::add(MeshPiece piece) {
  std::uint64_t& rows = piece.has_vertices() ? vertices_ : triangles_;
  piece.row = rows;
  rows += piece.rows;
  pieces_.push_back(piece);
}

void MeshPieces::list_vertices() {
  using Kind = MeshPiece::Kind;
  for (ChunkId chunk = 0; chunk + 1 < partition_.first_vertex.size(); ++chunk) {
    const std::uint64_t points = partition_.points_in(chunk);
    for (std::uint64_t first = 0; first < points; first += kUsedBlockPoints) {
      const std::uint64_t stored = std::min(kUsedBlockPoints, points - first);
      add({Kind::kPoints, chunk, first, stored, 0, used_.used_in_block(chunk, first)});
    }
  }
  for (ChunkId batch = 0; batch < holes_.new_vertices.size(); ++batch) {
    const std::uint64_t rows = holes_.new_vertices[batch];
    if (rows > 0) add({Kind::kNewVertices, batch, 0, rows, 0, rows});
  }
  for (std::uint64_t first = 0; first < holes_.copies.size(); first += kPieceRows) {
    const std::uint64_t rows = std::min(kPieceRows, holes_.copies.size() - first);
    add({Kind::kCopies, 0, first, rows, 0, rows});
  }
}

void MeshPieces::list_triangles(const std::vector<std::uint64_t>& stored) {
  using Kind = MeshPiece::Kind;
  for (ChunkId chunk = 0; chunk < stored.size(); ++chunk) {
    for (std::uint64_t first = 0; first < stored[chunk]; first += kPieceRows) {
      const std::uint64_t rows = std::min(kPieceRows, stored[chunk] - first);
      const std::uint64_t removed = removed_before(chunk, first + rows, stored[chunk]) -
                                    removed_before(chunk, first, stored[chunk]);
      add({Kind::kTriangles, chunk, first, rows, 0, rows - removed});
    }
  }
  for (ChunkId batch = 0; batch < holes_.new_triangles.size(); ++batch) {
    const std::uint64_t rows = holes_.new_triangles[batch];
    if (rows > 0) add({Kind::kPatches, batch, 0, rows, 0, rows});
  }
}

/// Removed triangles before a row of a chunk. All triangles of the mesh are in order, chunk by
/// chunk, each with the chunk that owns its first vertex; so are the removed ones.
std::uint64_t MeshPieces::removed_before(ChunkId chunk, std::uint64_t row,
                                         std::uint64_t stored) const {
  const auto before = [&](const Triangle64& t) {
    const auto at = std::lower_bound(holes_.removed.begin(), holes_.removed.end(), t);
    return static_cast<std::uint64_t>(at - holes_.removed.begin());
  };
  const std::uint64_t begin = before({partition_.first_vertex[chunk], 0, 0});
  const std::uint64_t end = before({partition_.first_vertex[chunk + 1], 0, 0});
  if (row == 0 || begin == end) return begin;
  if (row == stored) return end;
  Triangle t{};
  store_.open(kMeshStage, chunk)->read(kStoredTriangles, row, 1, &t);
  return before(of_chunks_.of(chunk)->local().global(t));
}

void MeshPieces::load(const MeshPiece& piece, const VertexColumns& columns, PieceRows& rows) const {
  switch (piece.kind) {
    case MeshPiece::Kind::kPoints:
      load_points(piece, columns, rows);
      break;
    case MeshPiece::Kind::kNewVertices:
      load_new_vertices(piece, columns, rows);
      break;
    case MeshPiece::Kind::kCopies:
      load_copies(piece, columns, rows);
      break;
    case MeshPiece::Kind::kTriangles:
      load_triangles(piece, rows);
      break;
    case MeshPiece::Kind::kPatches:
      load_patches(piece, rows);
      break;
  }
  if (piece.has_vertices()) columns.colors.apply(rows.vertices);
  rows.digest = {};
  rows.digest.add(piece, rows);
  const std::size_t loaded = piece.has_vertices() ? rows.vertices.size() : rows.triangles.size();
  if (loaded != piece.rows) throw std::logic_error("a piece of the mesh has another size");
}

void MeshPieces::load_points(const MeshPiece& piece, const VertexColumns& columns,
                             PieceRows& rows) const {
  load_vertex_rows(store_, partition_.stage, piece.part, columns, piece.first, piece.stored,
                   rows.vertices);
  if (piece.rows == piece.stored) return;
  keep_used(rows.vertices, *used_.block(piece.part, piece.first).ranks, 0);
}

void MeshPieces::load_new_vertices(const MeshPiece& piece, const VertexColumns& columns,
                                   PieceRows& rows) const {
  const PointSchema& schema = columns.stored;
  PatchBatch patches = load_patch_batch(store_, piece.part);
  mark_invented(schema, patches.values);
  rows.vertices = patch_vertices(schema, patches.positions, patches.normals, patches.values);
  if (!schema.has_normals) rows.vertices.normals.clear();
  mark_unsampled(columns, rows.vertices);
}

void MeshPieces::load_copies(const MeshPiece& piece, const VertexColumns& columns,
                             PieceRows& rows) const {
  rows.vertices.clear();
  auto copies = std::span(holes_.copies).subspan(piece.first, piece.rows);
  PointCloud read;
  while (!copies.empty()) {
    const ChunkId chunk = partition_.chunk_of(copies.front());
    const std::uint64_t begin = partition_.first_vertex[chunk], first = copies.front();
    const std::size_t count = read_at_once(
        copies.size(), [&](std::size_t i) { return copies[i]; }, partition_.first_vertex[chunk + 1],
        kPieceRows);
    load_vertex_rows(store_, partition_.stage, chunk, columns, first - begin,
                     copies[count - 1] - first + 1, read);
    rows.vertices.schema = read.schema;
    for (const std::uint64_t vertex : copies.first(count))
      rows.vertices.append(read, vertex - first);
    copies = copies.subspan(count);
  }
}

void MeshPieces::load_triangles(const MeshPiece& piece, PieceRows& rows) const {
  rows.stored.resize(piece.stored);
  store_.open(kMeshStage, piece.part)
      ->read(kStoredTriangles, piece.first, piece.stored, rows.stored.data());
  const std::shared_ptr<const ChunkNumbers> numbers = of_chunks_.of(piece.part);
  if (piece.rows != piece.stored) {
    std::erase_if(rows.stored, [&](const Triangle& t) {
      return numbers_.is_removed(numbers->local().global(t));
    });
  }
  VertexRanks ranks(used_);
  rows.triangles.resize(rows.stored.size());
  std::transform(rows.stored.begin(), rows.stored.end(), rows.triangles.begin(),
                 [&](const Triangle& t) { return numbers->of(t, ranks); });
  rows.hole.assign(rows.triangles.size(), 0);  // the scanned surface
}

void MeshPieces::load_patches(const MeshPiece& piece, PieceRows& rows) const {
  PatchBatch patches = load_patch_batch(store_, piece.part);
  rows.triangles = std::move(patches.triangles);
  VertexRanks ranks(used_);
  for (Triangle64& t : rows.triangles) {
    t = numbers_.of(numbers_.over_all_batches(t, piece.part), ranks);
  }
  rows.hole = std::move(patches.hole);
}

void SurfaceDigest::add(const MeshPiece& piece, const PieceRows& rows) {
  if (piece.has_vertices()) {
    checksum_.add_vertices(rows.vertices.positions, piece.row);
    bounds_.extend(rows.vertices.bounds());
  } else {
    checksum_.add_triangles(rows.triangles, piece.row);
  }
}

void SurfaceDigest::add(const SurfaceDigest& other) {
  checksum_.add(other.checksum_);
  bounds_.extend(other.bounds_);
}

std::string SurfaceDigest::text() const {
  nlohmann::json text = {{"checksum", checksum_.state()}};
  if (!bounds_.empty()) {
    const Vec3 low = bounds_.min, high = bounds_.max;
    text["bounds"] = {low.x, low.y, low.z, high.x, high.y, high.z};
  }
  return text.dump();
}

SurfaceDigest SurfaceDigest::from_text(const std::string& text) {
  const nlohmann::json parsed = nlohmann::json::parse(text, nullptr, false);
  const auto checksum = parsed.is_object()
                            ? MeshChecksum::from_state(parsed.value("checksum", std::string()))
                            : std::nullopt;
  if (!checksum) throw std::logic_error("no digest of a surface: " + text);
  SurfaceDigest digest;
  digest.checksum_ = *checksum;
  if (parsed.contains("bounds")) {
    const auto bounds = parsed.at("bounds").get<std::array<double, 6>>();
    digest.bounds_ = {{bounds[0], bounds[1], bounds[2]}, {bounds[3], bounds[4], bounds[5]}};
  }
  return digest;
}

std::size_t pieces_in_flight(const ResolvedJob& job, const PointSchema& schema) {
  const std::size_t row = 2 * (2 * sizeof(Vec3) + schema.attribute_bytes()) + sizeof(Vec3);
  const MemoryPlan plan = job.memory_plan(0, schema);
  const std::size_t affordable = plan.chunks_in_flight_bytes / (row * kPieceRows);
  return std::clamp<std::size_t>(affordable, 2, static_cast<std::size_t>(job.threads()) + 2);
}

void run_in_order(StageRunner& runner, const std::vector<MeshPiece>& pieces, std::size_t in_flight,
                  const std::function<void(const MeshPiece&, PieceRows&)>& prepare,
                  const std::function<void(const MeshPiece&, PieceRows&)>& put) {
  // Pieces end in order, so a piece's slot is free when the piece `in_flight` later begins.
  std::vector<PieceRows> slots(in_flight);
  std::size_t next = 0;
  const auto take = [&](tbb::flow_control& flow) -> std::size_t {
    runner.stop.check();
    if (next == pieces.size()) {
      flow.stop();
      return 0;
    }
    return next++;
  };
  const auto prepare_one = [&](std::size_t i) {
    prepare(pieces[i], slots[i % in_flight]);
    return i;
  };
  const auto put_one = [&](std::size_t i) { put(pieces[i], slots[i % in_flight]); };
  tbb::task_arena arena(allowed_threads(runner.threads()));
  arena.execute([&] {
    tbb::parallel_pipeline(
        in_flight,
        tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, take) &
            tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, prepare_one) &
            tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, put_one));
  });
}

SurfaceDigest digest_pieces(StageRunner& runner, const MeshPieces& pieces) {
  SurfaceDigest digest;
  run_in_order(
      runner, pieces.all(), pieces_in_flight(runner.job, {}),
      [&](const MeshPiece& piece, PieceRows& rows) { pieces.load(piece, {}, rows); },
      [&](const MeshPiece&, PieceRows& rows) { digest.add(rows.digest); });
  return digest;
}

}  // namespace orbweave
