#include "engine/pipeline/export_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "engine/pipeline/mesh_pieces.h"
#include "engine/pipeline/placed_export.h"
#include "engine/pipeline/reconstruct_stage.h"
#include "engine/pipeline/stored_surface.h"
#include "engine/pipeline/tile_export.h"
#include "engine/stitching/local_numbers.h"
#include "io/atomic_file.h"
#include "io/chunk_points.h"
#include "io/mesh_writer.h"
#include "io/picture.h"

namespace orbweave {
namespace {

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

PointSchema output_schema(const Partition& partition, const OutputOptions& output) {
  PointSchema schema = partition.schema;
  schema.has_normals = schema.has_normals && output.attributes;
  return schema;
}

/// Through one writer, front to back.
std::uint64_t export_in_order(JobContext& context, const MeshPieces& pieces,
                              const MeshHeader& header, SurfaceDigest& digest) {
  const OutputOptions& output = context.job.output;
  const auto writer =
      open_mesh_writer(output.mesh, header, {output.binary, output.float_positions, {}});
  const auto hole = [&](const PieceRows& rows) {
    return header.has_hole ? std::span<const std::int32_t>(rows.hole)
                           : std::span<const std::int32_t>();
  };
  const bool independently = writer->encodes_independently();
  const auto encode = [&](const MeshPiece& piece, PieceRows& rows) {
    pieces.load(piece, header.schema, rows);
    if (!independently) return;
    rows.encoded = piece.has_vertices() ? writer->encode_vertices(rows.vertices)
                                        : writer->encode_triangles(rows.triangles, hole(rows));
  };
  const auto write = [&](const MeshPiece& piece, PieceRows& rows) {
    digest.add(piece, rows);
    if (independently && piece.has_vertices()) {
      writer->write_encoded_vertices(rows.encoded, piece.rows);
    } else if (independently) {
      writer->write_encoded_triangles(rows.encoded, piece.rows);
    } else if (piece.has_vertices()) {
      writer->write_vertices(rows.vertices);
    } else {
      writer->write_triangles(rows.triangles, hole(rows));
    }
    context.progress.advance(piece.stored);
  };
  run_in_order(context, pieces.all(), pieces_in_flight(context, header.schema), encode, write);
  writer->finish();
  return writer->bytes_written();
}

/// Returns the bytes of the file.
std::uint64_t export_one_file(JobContext& context, const MeshPieces& pieces,
                              const MeshHeader& header, SurfaceDigest& digest) {
  std::uint64_t bytes = 0;
  if (is_placed(context, header) && export_placed(context, pieces, header, digest, bytes)) {
    return bytes;
  }
  return context.team.leads() ? export_in_order(context, pieces, header, digest) : 0;
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

void check_format_holds(const OutputOptions& output, std::uint64_t points) {
  check_mesh_size(output.mesh, 2 * points, {output.binary, output.float_positions, {}});
}

void export_mesh(JobContext& context, const Partition& partition,
                 const std::vector<std::uint64_t>& triangles, const UsedVertices& used,
                 const FilledHoles& holes, MeshFacts& facts) {
  if (context.team.leads()) warn_of_moved_vertices(context, partition);
  const MeshPieces pieces(context, partition, used, holes, triangles);
  if (pieces.vertices() != facts.vertices || pieces.triangles() != facts.triangles)
    throw std::logic_error("the mesh has other counts than its summary says");

  const OutputOptions& output = context.job.output;
  const std::uint64_t rows = partition.points() + facts.triangles;
  StageClock clock(context, "export", output.tiles ? partition.octree.chunks().size() : rows,
                   output.tiles ? "chunks" : "rows");
  const MeshHeader header{facts.vertices, facts.triangles, false, context.job.fill.enabled,
                          output_schema(partition, output)};
  SurfaceDigest digest;
  const TileInput tiles{partition, used, holes, pieces, header};
  clock.facts().bytes_written = output.tiles ? export_tiles(context, clock, tiles, digest)
                                             : export_one_file(context, pieces, header, digest);
  clock.facts().points = partition.points();
  if (!context.team.leads()) return;
  write_coordinate_system(output.mesh, partition.coordinate_system);
  facts.checksum = digest.checksum();
  facts.bounds = digest.bounds();
}

void draw_picture(JobContext& context, const Partition& partition, const FilledHoles& holes) {
  const std::size_t chunks = partition.octree.chunks().size();
  StageClock clock(context, "picture", chunks, "chunks");
  MeshPicture picture(partition.bounds, {.patch_color = context.job.output.patch_color});
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    context.stop.check();
    const std::vector<Vec3> own = load_points(context.store, chunk, partition.schema).positions;
    const ChunkMesh mesh = load_chunk_mesh(context.store, chunk, false);
    const LocalNumbers numbers(partition.first_vertex[chunk], own.size(), mesh.outer_vertices);
    const auto position = [&](std::uint32_t vertex) {
      return vertex < own.size() ? own[vertex] : mesh.outer_positions[vertex - own.size()];
    };
    std::vector<std::array<Vec3, 3>> corners;
    corners.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
      corners.push_back({position(t[0]), position(t[1]), position(t[2])});
    }
    if (!holes.removed.empty()) {
      std::size_t kept = 0;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const bool removed = std::binary_search(holes.removed.begin(), holes.removed.end(),
                                                numbers.global(mesh.triangles[i]));
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
