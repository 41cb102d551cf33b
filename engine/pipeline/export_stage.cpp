#include "engine/pipeline/export_stage.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "engine/holes/patch_vertices.h"
#include "engine/pipeline/reconstruct_stage.h"
#include "engine/pipeline/stored_surface.h"
#include "io/atomic_file.h"
#include "io/chunk_points.h"
#include "io/mesh_checksum.h"
#include "io/mesh_writer.h"
#include "io/picture.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kPieceRows = std::uint64_t{1} << 16;

/// A run of rows of one chunk, on its way to the file.
struct Piece {
  ChunkId chunk = 0;
  std::uint64_t first = 0;
  std::uint64_t rows = 0;
  PointCloud vertices;
  std::vector<Triangle64> triangles;
  std::vector<std::int32_t> hole;
  std::vector<std::byte> encoded;
};

std::vector<Piece> cut_into_pieces(std::span<const std::uint64_t> rows_of_chunks) {
  std::vector<Piece> pieces;
  for (ChunkId chunk = 0; chunk < rows_of_chunks.size(); ++chunk) {
    for (std::uint64_t first = 0; first < rows_of_chunks[chunk]; first += kPieceRows) {
      Piece piece;
      piece.chunk = chunk;
      piece.first = first;
      piece.rows = std::min(kPieceRows, rows_of_chunks[chunk] - first);
      pieces.push_back(std::move(piece));
    }
  }
  return pieces;
}

/// load(piece) in parallel, write(piece) in order.
void run_pieces(JobContext& context, std::span<const std::uint64_t> rows_of_chunks,
                const std::function<void(Piece&)>& load,
                const std::function<void(const Piece&)>& write) {
  std::vector<Piece> pieces = cut_into_pieces(rows_of_chunks);
  std::size_t next = 0;
  const auto take = [&](tbb::flow_control& flow) -> Piece* {
    context.stop.check();
    if (next == pieces.size()) {
      flow.stop();
      return nullptr;
    }
    return &pieces[next++];
  };
  const auto prepare = [&](Piece* piece) {
    load(*piece);
    return piece;
  };
  const auto put = [&](Piece* piece) {
    write(*piece);
    context.progress.advance(piece->rows);
    *piece = Piece();
  };
  tbb::task_arena arena(context.threads());
  arena.execute([&] {
    tbb::parallel_pipeline(
        static_cast<std::size_t>(context.threads()) + 2,
        tbb::make_filter<void, Piece*>(tbb::filter_mode::serial_in_order, take) &
            tbb::make_filter<Piece*, Piece*>(tbb::filter_mode::parallel, prepare) &
            tbb::make_filter<Piece*, void>(tbb::filter_mode::serial_in_order, put));
  });
}

/// Keeps the points that the mesh uses.
void keep_used(PointCloud& points, const UsedVertices& used, std::uint64_t first_vertex) {
  std::size_t kept = 0;
  const std::size_t bytes = points.schema.attribute_bytes();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!used.used(first_vertex + i)) continue;
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

[[noreturn]] void throw_empty(const JobContext& context) {
  throw_bad_input(
      "no triangle can be formed: no ball touches three points without holding a "
      "fourth, on the side their normals point to",
      {.file = context.files.front(),
       .place = {},
       .found = context.report.radii_reason,
       .expected = "points on a surface, normals that agree with it, and ball radii of "
                   "about the point spacing",
       .advice = "Points on one line carry no surface; try radii = \"auto\""});
}

void warn_of_moved_vertices(JobContext& context, const Partition& partition) {
  if (!context.job.output.float_positions || !(partition.spacing > 0.0)) return;
  double largest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max(
        {largest, std::abs(partition.bounds.min[axis]), std::abs(partition.bounds.max[axis])});
  }
  const double step = std::ldexp(largest, -24);
  if (step > partition.spacing * 1e-3) {
    context.warn("float coordinates move vertices by up to " +
                 std::to_string(step / partition.spacing) +
                 " of the point spacing; output.precision = \"double\" keeps them");
  }
}

class VertexWriter {
 public:
  VertexWriter(MeshWriter& writer, MeshChecksum& checksum, Box& bounds)
      : writer_(writer), checksum_(checksum), bounds_(bounds) {}
  void encode(Piece& piece) const {
    if (writer_.encodes_independently()) piece.encoded = writer_.encode_vertices(piece.vertices);
  }
  void write(const Piece& piece) {
    checksum_.add_vertices(piece.vertices.positions);
    bounds_.extend(piece.vertices.bounds());
    if (writer_.encodes_independently()) {
      writer_.write_encoded_vertices(piece.encoded, piece.vertices.size());
    } else {
      writer_.write_vertices(piece.vertices);
    }
  }

 private:
  MeshWriter& writer_;
  MeshChecksum& checksum_;
  Box& bounds_;
};

PointSchema output_schema(const Partition& partition, const OutputOptions& output) {
  PointSchema schema = partition.schema;
  schema.has_normals = schema.has_normals && output.attributes;
  return schema;
}

void write_all_vertices(JobContext& context, const Partition& partition, const UsedVertices& used,
                        VertexWriter writer) {
  std::vector<std::uint64_t> rows;
  for (ChunkId c = 0; c + 1 < partition.first_vertex.size(); ++c)
    rows.push_back(partition.points_in(c));
  const bool with_normals = context.job.output.attributes;
  run_pieces(
      context, rows,
      [&](Piece& piece) {
        piece.vertices =
            load_point_rows(context.store, piece.chunk, partition.schema, piece.first, piece.rows);
        if (!with_normals) {
          piece.vertices.normals.clear();
          piece.vertices.schema.has_normals = false;
        }
        keep_used(piece.vertices, used, partition.first_vertex[piece.chunk] + piece.first);
        writer.encode(piece);
      },
      [&](const Piece& piece) { writer.write(piece); });
}

/// The numbers of vertices in the file: used points, then the patches' vertices, then copies.
class OutputNumbers {
 public:
  OutputNumbers(const UsedVertices& used, const FilledHoles& holes, std::uint64_t points)
      : used_(used), holes_(holes), first_new_(used.count()), first_copy_(first_new_) {
    for (const std::uint64_t vertices : holes.new_vertices) first_copy_ += vertices;
    if (holes.splits.empty()) return;
    split_.assign((points + 63) / 64, 0);
    for (const std::uint64_t point : holes.copies) {
      split_[point / 64] |= std::uint64_t{1} << (point % 64);
    }
  }

  /// Of a triangle as it is stored; new vertices are counted over all batches.
  Triangle64 of(const Triangle64& t) const {
    Triangle64 result;
    for (int k = 0; k < 3; ++k) result[k] = of_corner(t, t[k]);
    return result;
  }
  bool is_removed(const Triangle64& t) const {
    return std::binary_search(holes_.removed.begin(), holes_.removed.end(), t);
  }
  bool any_removed() const { return !holes_.removed.empty(); }

 private:
  bool is_split(std::uint64_t point) const {
    return !split_.empty() && (split_[point / 64] >> (point % 64) & 1) != 0;
  }
  std::uint64_t of_corner(const Triangle64& t, std::uint64_t vertex) const {
    if (vertex >= kNewVertex) return first_new_ + (vertex - kNewVertex);
    if (is_split(vertex)) {
      const SplitCorner* split = find_split(holes_, t, vertex);
      if (split != nullptr) return first_copy_ + split->copy;
    }
    return used_.rank(vertex);
  }

  const UsedVertices& used_;
  const FilledHoles& holes_;
  std::uint64_t first_new_;
  std::uint64_t first_copy_;
  std::vector<std::uint64_t> split_;
};

/// Vertices of the patches, then copies of vertices where fans were taken apart.
void write_new_vertices(JobContext& context, const Partition& partition, const FilledHoles& holes,
                        VertexWriter writer) {
  const auto write = [&](PointCloud&& vertices) {
    Piece piece;
    piece.vertices = std::move(vertices);
    if (!context.job.output.attributes) {
      piece.vertices.normals.clear();
      piece.vertices.schema.has_normals = false;
    }
    writer.encode(piece);
    writer.write(piece);
  };
  for (ChunkId batch = 0; batch < holes.new_vertices.size(); ++batch) {
    context.stop.check();
    const PatchBatch patches = load_patch_batch(context.store, batch);
    write(patch_vertices(partition.schema, patches.positions, patches.normals, patches.values));
  }
  for (const std::uint64_t vertex : holes.copies) {
    const ChunkId chunk = partition.chunk_of(vertex);
    write(load_point_rows(context.store, chunk, partition.schema,
                          vertex - partition.first_vertex[chunk], 1));
  }
}

class TriangleWriter {
 public:
  TriangleWriter(MeshWriter& writer, MeshChecksum& checksum, bool with_holes)
      : writer_(writer), checksum_(checksum), with_holes_(with_holes) {}
  void encode(Piece& piece) const {
    // The scanned surface has hole 0.
    if (with_holes_) piece.hole.resize(piece.triangles.size(), 0);
    if (writer_.encodes_independently()) {
      piece.encoded = writer_.encode_triangles(piece.triangles, piece.hole);
    }
  }
  void write(const Piece& piece) {
    checksum_.add_triangles(piece.triangles);
    if (writer_.encodes_independently()) {
      writer_.write_encoded_triangles(piece.encoded, piece.triangles.size());
    } else {
      writer_.write_triangles(piece.triangles, piece.hole);
    }
  }

 private:
  MeshWriter& writer_;
  MeshChecksum& checksum_;
  bool with_holes_;
};

void write_patch_triangles(JobContext& context, const FilledHoles& holes,
                           const OutputNumbers& numbers, TriangleWriter writer) {
  std::uint64_t base = 0;
  for (ChunkId batch = 0; batch < holes.new_triangles.size(); ++batch) {
    context.stop.check();
    PatchBatch patches = load_patch_batch(context.store, batch);
    Piece piece;
    for (Triangle64 t : patches.triangles) {
      for (std::uint64_t& vertex : t) vertex += vertex >= kNewVertex ? base : 0;
      piece.triangles.push_back(numbers.of(t));
    }
    piece.hole = std::move(patches.hole);
    writer.encode(piece);
    writer.write(piece);
    base += holes.new_vertices[batch];
  }
}

void write_all_triangles(JobContext& context, const Stitched& stitched,
                         const OutputNumbers& numbers, TriangleWriter writer) {
  run_pieces(
      context, stitched.triangles,
      [&](Piece& piece) {
        piece.triangles.resize(piece.rows);
        context.store.open(kMeshStage, piece.chunk)
            ->read("triangles", piece.first, piece.rows, piece.triangles.data());
        if (numbers.any_removed()) {
          std::erase_if(piece.triangles,
                        [&](const Triangle64& t) { return numbers.is_removed(t); });
        }
        for (Triangle64& t : piece.triangles) t = numbers.of(t);
        writer.encode(piece);
      },
      [&](const Piece& piece) { writer.write(piece); });
}

void draw_patches(JobContext& context, const Partition& partition, const FilledHoles& holes,
                  MeshPicture& picture) {
  constexpr std::size_t kCacheBytes = std::size_t{32} << 20;
  const StoredSurface surface(context.store, partition, 0.0, kCacheBytes, false);
  for (ChunkId batch = 0; batch < holes.new_triangles.size(); ++batch) {
    const PatchBatch patches = load_patch_batch(context.store, batch);
    const auto position = [&](std::uint64_t vertex) {
      return vertex < kNewVertex ? surface.position(vertex)
                                 : patches.positions[vertex - kNewVertex];
    };
    std::vector<std::array<Vec3, 3>> corners;
    for (const Triangle64& t : patches.triangles) {
      corners.push_back({position(t[0]), position(t[1]), position(t[2])});
    }
    picture.draw(corners, patches.hole);
  }
}

/// The coordinate reference system lies beside the mesh, where other programs look for it.
void write_coordinate_system(const std::string& mesh, const std::string& coordinate_system) {
  if (coordinate_system.empty() || mesh == "-") return;
  AtomicFile file(std::filesystem::path(mesh).replace_extension(".prj"));
  file.write(coordinate_system + "\n");
  file.commit();
}

}  // namespace

Stitched stitch(JobContext& context, const Partition& partition) {
  const std::size_t chunks = partition.octree.chunks().size();
  StageClock clock(context, "stitch", chunks, "chunks");
  Stitched stitched{{}, UsedVertices(partition.points()), {}};
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    context.stop.check();
    const ChunkMesh mesh = load_chunk_mesh(context.store, chunk, true);
    stitched.triangles.push_back(stored_triangles(context.store, chunk));
    stitched.summary.add(mesh, partition.first_vertex[chunk], stitched.triangles.back());
    stitched.used.mark(partition.first_vertex[chunk], mesh.fans);
    context.progress.advance(1);
  }
  stitched.summary.finish();
  context.report.conflicts_lost = stitched.summary.conflicts_lost();
  context.report.points_unused = stitched.summary.unused_points();
  clock.facts().chunks = chunks;
  if (stitched.summary.facts().triangles == 0) throw_empty(context);
  return stitched;
}

void export_mesh(JobContext& context, const Partition& partition, Stitched& stitched,
                 const FilledHoles& holes, MeshFacts& facts) {
  warn_of_moved_vertices(context, partition);
  for (const std::uint64_t point : holes.freed) stitched.used.unmark(point);
  stitched.used.number();
  const OutputNumbers numbers(stitched.used, holes, partition.points());

  StageClock clock(context, "export", partition.points() + facts.triangles, "rows");
  const OutputOptions& output = context.job.output;
  const bool with_holes = context.job.fill.enabled;
  const MeshHeader header{facts.vertices, facts.triangles, false, with_holes,
                          output_schema(partition, output)};
  const auto writer =
      open_mesh_writer(output.mesh, header, {output.binary, output.float_positions, {}});
  MeshChecksum checksum;
  const VertexWriter vertices(*writer, checksum, facts.bounds);
  const TriangleWriter triangles(*writer, checksum, with_holes);
  write_all_vertices(context, partition, stitched.used, vertices);
  write_new_vertices(context, partition, holes, vertices);
  write_all_triangles(context, stitched, numbers, triangles);
  write_patch_triangles(context, holes, numbers, triangles);
  writer->finish();
  write_coordinate_system(output.mesh, partition.coordinate_system);
  facts.checksum = checksum.hex();
  clock.facts().points = partition.points();
  clock.facts().bytes_written = writer->bytes_written();
}

void draw_picture(JobContext& context, const Partition& partition, const FilledHoles& holes) {
  const std::size_t chunks = partition.octree.chunks().size();
  StageClock clock(context, "picture", chunks, "chunks");
  MeshPicture picture(partition.bounds, {.patch_color = context.job.output.patch_color});
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    context.stop.check();
    const std::vector<Vec3> own = load_points(context.store, chunk, partition.schema).positions;
    const ChunkMesh mesh = load_chunk_mesh(context.store, chunk, false);
    const std::uint64_t first = partition.first_vertex[chunk];
    const auto position = [&](std::uint64_t vertex) {
      if (vertex >= first && vertex - first < own.size()) return own[vertex - first];
      const auto at =
          std::lower_bound(mesh.outer_vertices.begin(), mesh.outer_vertices.end(), vertex);
      return mesh.outer_positions[static_cast<std::size_t>(at - mesh.outer_vertices.begin())];
    };
    std::vector<std::array<Vec3, 3>> corners;
    corners.reserve(mesh.triangles.size());
    for (const Triangle64& t : mesh.triangles) {
      corners.push_back({position(t[0]), position(t[1]), position(t[2])});
    }
    if (!holes.removed.empty()) {
      std::size_t kept = 0;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const bool removed =
            std::binary_search(holes.removed.begin(), holes.removed.end(), mesh.triangles[i]);
        if (!removed) corners[kept++] = corners[i];
      }
      corners.resize(kept);
    }
    picture.draw(corners);
    context.progress.advance(1);
  }
  draw_patches(context, partition, holes, picture);
  picture.write_png(context.job.output.picture);
}

}  // namespace orbweave
