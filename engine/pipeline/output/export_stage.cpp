#include "engine/pipeline/output/export_stage.h"

#include <stdexcept>

#include "engine/pipeline/output/map_tiles.h"
#include "engine/pipeline/output/mesh_pieces.h"
#include "engine/pipeline/output/placed_export.h"
#include "engine/pipeline/output/power_crust_files.h"
#include "engine/pipeline/output/tile_export.h"
#include "engine/pipeline/stage/writer_options.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"

namespace orbweave {
namespace {

/// Through one writer, front to back.
std::uint64_t export_in_order(StageRunner& runner, const MeshPieces& pieces,
                              const VertexColumns& columns, const MeshHeader& header,
                              const MeshWriterOptions& options, SurfaceDigest& digest) {
  const auto writer = open_mesh_writer(runner.job.output.mesh, header, options);
  const auto hole = [&](const PieceRows& rows) {
    return header.has_hole ? std::span<const std::int32_t>(rows.hole)
                           : std::span<const std::int32_t>();
  };
  const bool independently = writer->encodes_independently();
  const auto encode = [&](const MeshPiece& piece, PieceRows& rows) {
    pieces.load(piece, columns, rows);
    if (!independently) return;
    rows.encoded = piece.has_vertices() ? writer->encode_vertices(rows.vertices)
                                        : writer->encode_triangles(rows.triangles, hole(rows));
  };
  const auto write = [&](const MeshPiece& piece, PieceRows& rows) {
    digest.add(rows.digest);
    if (independently && piece.has_vertices()) {
      writer->write_encoded_vertices(rows.encoded, piece.rows);
    } else if (independently) {
      writer->write_encoded_triangles(rows.encoded, piece.rows);
    } else if (piece.has_vertices()) {
      writer->write_vertices(rows.vertices);
    } else {
      writer->write_triangles(rows.triangles, hole(rows));
    }
    runner.progress.advance(piece.stored);
  };
  run_in_order(runner, pieces.all(), pieces_in_flight(runner.job, columns.stored), encode, write);
  writer->finish();
  return writer->bytes_written();
}

/// Returns the bytes of the file.
std::uint64_t export_one_file(StageRunner& runner, const MeshPieces& pieces,
                              const VertexColumns& columns, const MeshHeader& header,
                              const MeshWriterOptions& options, SurfaceDigest& digest) {
  std::uint64_t bytes = 0;
  const std::string& mesh = runner.job.output.mesh;
  const auto rows = mesh_rows(mesh, header, options);  // the same for every member of a team
  if (rows && export_placed(runner, pieces, columns, header, *rows, digest, bytes)) return bytes;
  if (!runner.communicator.is_root()) return 0;
  return export_in_order(runner, pieces, columns, header, options, digest);
}

}  // namespace

void check_format_holds(const OutputOptions& output, std::uint64_t points,
                        const PointSchema& vertices) {
  const MeshHeader header{.vertices = points, .triangles = 2 * points, .schema = vertices};
  check_mesh_size(output.mesh, header, writer_options(output, {}));
}

PointSchema vertex_schema(const OutputOptions& output, const Partition& partition) {
  return vertex_columns(partition, output).written();
}

OutputOrigin mesh_origin(const OutputOptions& output, const Partition& partition) {
  const bool floats = has_float_coordinates(output.mesh, writer_options(output, {}));
  return output_origin(output, floats, partition.bounds, partition.spacing);
}

ExportResult export_mesh(const ExportInputs& inputs, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  const MeshFacts& facts = inputs.facts;
  const MeshPieces pieces(runner.store, partition, inputs.used, inputs.holes, inputs.triangles);
  if (pieces.vertices() != facts.vertices || pieces.triangles() != facts.triangles)
    throw std::logic_error("the mesh has other counts than its summary says");

  const OutputOptions& output = runner.job.output;
  const bool by_map = output.tiles && output.tile_size > 0.0;
  const bool by_chunk = output.tiles && !by_map;
  // Triangles of a map's tiles are sorted first, and written afterwards.
  const std::uint64_t rows = partition.points() + (by_map ? 2 : 1) * facts.triangles;
  StageClock clock(runner, output.tiles ? Stage::kTiles : Stage::kExport,
                   by_chunk ? partition.octree.chunks().size() : rows,
                   by_chunk ? "chunks" : "rows");
  const VertexColumns columns = vertex_columns(partition, output);
  const MeshHeader header{facts.vertices, facts.triangles, false, runner.job.fill.enabled,
                          columns.written()};
  const Vec3 origin = mesh_origin(output, partition).origin;
  MeshWriterOptions options = writer_options(output, inputs.holes.holes, origin);
  options.up_axis = upright_axis(
      picture_up(runner.job, runner.job.files, partition.coordinate_system), partition.bounds);
  // Files beside the mesh come first: a job that is interrupted meanwhile leaves no mesh.
  const std::uint64_t beside = runner.communicator.is_root()
                                   ? write_power_crust_files(partition, columns, options, runner)
                                   : 0;
  SurfaceDigest digest;
  const TileInput tiles{partition, inputs.used, inputs.holes, pieces,
                        columns,   header,      options,      runner.stop};
  const std::uint64_t bytes =
      by_map     ? export_map_tiles(runner, tiles, digest)
      : by_chunk ? export_tiles(runner, clock, tiles, digest)
                 : export_one_file(runner, pieces, columns, header, options, digest);
  clock.facts().points = partition.points();
  if (!runner.communicator.is_root()) return {};
  clock.facts().bytes_written = bytes + beside;
  write_coordinate_system(output.mesh, partition.coordinate_system);
  write_shift(output.mesh, origin);
  return {digest.checksum(), digest.bounds(), bytes};
}

}  // namespace orbweave
