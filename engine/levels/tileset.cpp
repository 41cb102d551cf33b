#include "engine/levels/tileset.h"

#include <string>
#include <vector>

#include "engine/levels/level_distances.h"
#include "engine/levels/level_maker.h"
#include "engine/levels/packed_tile.h"
#include "engine/levels/tile_mesh.h"
#include "engine/levels/tileset_index.h"
#include "engine/levels/tileset_json.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/tile_directory.h"
#include "io/points/coordinate_system.h"
#include "io/system/path_roles.h"
#include "io/vertex_values.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// Tiles lie where viewers turn y to z, about the tileset's origin.
void write_tile(const fs::path& file, const PointCloud& points, const NodeMesh& node,
                const TileColumns& columns, Vec3 tileset_origin, TileCompression compression) {
  const TriangleMesh mesh = tile_mesh(points, node, columns);
  MeshWriterOptions options;
  options.origin = points.bounds().center();
  options.glb_attributes = tile_attributes(node, columns);
  for (const VertexValue& value : vertex_values(points.schema))
    options.glb_attributes.push_back(value.name);
  options.node_offset = -tileset_origin;
  options.up_axis = 2;
  if (compression == TileCompression::kMeshopt)
    write_packed_tile(file, mesh, options);
  else
    write_mesh(file, mesh, options);
}

std::vector<TilesetLevel> levels_of(const Levels& levels) {
  std::vector<TilesetLevel> all(static_cast<std::size_t>(levels.nodes[0].height) + 1);
  for (std::size_t i = 0; i < levels.nodes.size(); ++i) {
    TilesetLevel& level = all[static_cast<std::size_t>(levels.nodes[i].height)];
    level.tiles += 1;
    level.triangles += levels.facts[i].triangles;
    level.border_triangles += levels.facts[i].border_triangles;
    level.error = std::max(level.error, levels.facts[i].error);
  }
  return all;
}

std::vector<std::string> names_of(const Levels& levels, const std::vector<NamedText>& beside) {
  std::vector<std::string> names = {kTilesetName};
  for (std::uint32_t node = 0; node < levels.nodes.size(); ++node) names.push_back(tile_file(node));
  for (const NamedText& file : beside) names.push_back(file.name);
  return names;
}

}  // namespace

TilesetFacts write_tileset(MeshStream& mesh, const fs::path& directory,
                           const TilesetOptions& options, const TilesetEvents& events,
                           const StopToken& stop) {
  check_tile_directory(directory);
  TileDirectory target(final_target(directory));
  Vec3 origin;
  LevelEvents of_levels;
  of_levels.read = events.read;
  of_levels.planned = [&](std::uint32_t tiles, const Box& bounds) {
    origin = bounds.center();
    if (events.planned) events.planned(tiles);
  };
  TileColumns columns;
  of_levels.done = [&](std::uint32_t node, const PointCloud& points, const NodeMesh& made) {
    write_tile(target.temporary() / tile_file(node), points, made, columns, origin,
               options.compression);
    if (events.written) events.written();
  };
  LevelOptions with_tags = options.levels;
  with_tags.keeps_tags = true;
  LevelMaker maker(mesh, mesh.schema(), with_tags, of_levels, stop);
  columns = {!maker.holes().empty(), mesh.has_confidence(), maker.components().size() > 1};
  maker.make();
  const Levels& levels = maker.levels();
  const auto earth = earth_from_local(options.coordinate_system, origin);
  const Transform to_world = earth ? *earth : upright_transform(options.up_axis, origin);
  write_text_file(
      target.temporary() / kTilesetName,
      tileset_text(levels,
                   {maker.holes(), maker.hole_count(), columns.has_confidence, maker.components()},
                   maker.value_ranges(), origin, to_world));
  for (const NamedText& file : options.beside)
    write_text_file(target.temporary() / file.name, file.text);
  TilesetFacts facts;
  facts.vertices = levels.vertices;
  facts.triangles = levels.triangles;
  facts.work_bytes = maker.disk_bytes();
  facts.is_on_earth = earth.has_value();
  facts.levels = levels_of(levels);
  facts.tiles = levels.nodes.size();
  facts.reused = levels.reused;
  facts.bytes = write_tileset_index(target.temporary(), levels.vertices, levels.triangles,
                                    names_of(levels, options.beside));
  if (options.measures) {
    if (events.measuring) events.measuring();
    const std::vector<LevelDistance> measured = measure_levels(maker, stop);
    for (std::size_t i = 0; i < measured.size(); ++i) facts.levels[i].measured = measured[i];
  }
  target.commit();
  return facts;
}

}  // namespace orbweave
