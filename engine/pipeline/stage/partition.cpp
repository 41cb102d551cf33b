#include "engine/pipeline/stage/partition.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/error.h"
#include "io/report/reasons.h"
#include "io/text/json_dump.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;

constexpr const char* kDocument = "partition";
/// Documents of earlier versions have the cleaning under this name.
constexpr const char* kCleaning = "prepare";

// nlohmann prints doubles so that they read back exactly; the boxes here are never empty.
Json to_json(Vec3 v) { return Json::array({v.x, v.y, v.z}); }
Vec3 vec3_from(const Json& j) { return {j.at(0), j.at(1), j.at(2)}; }
Json to_json(const Box& box) { return Json::array({to_json(box.min), to_json(box.max)}); }
Box box_from(const Json& j) { return {vec3_from(j.at(0)), vec3_from(j.at(1))}; }

Json to_json(const PointSchema& schema) {
  Json attributes = Json::array();
  for (const AttributeField& field : schema.attributes) {
    attributes.push_back({{"name", field.name}, {"type", static_cast<int>(field.type)}});
  }
  return {{"has_normals", schema.has_normals},
          {"position_type", static_cast<int>(schema.position_type)},
          {"normal_type", static_cast<int>(schema.normal_type)},
          {"attributes", attributes}};
}

PointSchema schema_from(const Json& j) {
  PointSchema schema;
  schema.has_normals = j.at("has_normals");
  schema.position_type = static_cast<ScalarType>(j.at("position_type").get<int>());
  schema.normal_type = static_cast<ScalarType>(j.at("normal_type").get<int>());
  for (const Json& field : j.at("attributes")) {
    schema.attributes.push_back(
        {field.at("name"), static_cast<ScalarType>(field.at("type").get<int>())});
  }
  return schema;
}

Json to_json(const CleaningFacts& facts) {
  const CleaningOptions& o = facts.options;
  return {
      {"thickness", facts.thickness},
      {"spacing", facts.spacing},
      {"options",
       {o.automatic, o.outlier_sigma, o.merge_tolerance, o.smooth_radius, o.smooth_passes,
        o.thin_to_spacing, o.cluster_points.value_or(0), o.min_surfaceness}},
      {"reason", facts.reason},
      {"points_moved", facts.points_moved},
      {"mean_move", facts.mean_move},
      {"places", {facts.is_local, facts.least_radius, facts.most_radius, facts.untouched_share}}};
}

CleaningFacts cleaning_from(const Json& j) {
  const Json& o = j.at("options");
  return {
      j.at("thickness"),
      j.at("spacing"),
      {o.at(0), o.at(1), o.at(2), o.at(3), o.at(4), o.at(5), o.at(6).get<std::uint64_t>(), o.at(7)},
      j.at("reason"),
      j.at("points_moved"),
      j.at("mean_move"),
      j.at("places").at(0),
      j.at("places").at(1),
      j.at("places").at(2),
      j.at("places").at(3)};
}

Json to_json(const NormalFacts& facts) {
  Json places = Json::array();
  for (const ContestedFacts& place : facts.contested_places)
    places.push_back({to_json(place.center), place.patches});
  Json doubtful = Json::array();
  for (const DoubtfulFacts& part : facts.doubtful)
    doubtful.push_back({to_json(part.center), part.area, part.reason});
  return Json::array({text_of(facts.source), text_of(facts.orientation), facts.neighbors,
                      facts.max_radius, facts.patches, facts.components, facts.contested,
                      facts.satisfied, places, facts.ground_patches, facts.ground_patches_down,
                      facts.interiors, facts.contested_area, facts.doubtful_area, doubtful});
}

NormalFacts normals_from(const Json& j) {
  NormalFacts facts;
  facts.source = normal_source_from(j.at(0).get<std::string>());
  facts.orientation = orientation_from(j.at(1).get<std::string>());
  facts.neighbors = j.at(2);
  facts.max_radius = j.at(3);
  facts.patches = j.at(4);
  facts.components = j.at(5);
  facts.contested = j.at(6);
  facts.satisfied = j.at(7);
  // Documents of earlier versions end before.
  if (j.size() > 8) {
    for (const Json& place : j.at(8))
      facts.contested_places.push_back({vec3_from(place.at(0)), place.at(1)});
    facts.ground_patches = j.at(9);
    facts.ground_patches_down = j.at(10);
  }
  if (j.size() > 11) {
    facts.interiors = j.at(11);
    facts.contested_area = j.at(12);
    facts.doubtful_area = j.at(13);
    for (const Json& part : j.at(14))
      facts.doubtful.push_back({vec3_from(part.at(0)), part.at(1), part.at(2)});
  }
  return facts;
}

Json to_json(const LayerThickness& layers) {
  return Json::array({layers.thickness, layers.spacing, layers.radius, layers.measured,
                      layers.thick_share, layers.largest_radius, layers.double_share, layers.gap,
                      layers.twin_share});
}

LayerThickness layers_from(const Json& j) {
  LayerThickness layers{j.at(0), j.at(1), j.at(2), j.at(3), j.at(4), j.at(5)};
  // Documents of earlier versions end before.
  if (j.size() > 6) {
    layers.double_share = j.at(6);
    layers.gap = j.at(7);
    layers.twin_share = j.at(8);
  }
  return layers;
}

Json to_json(const std::vector<SaidLine>& lines) {
  Json said = Json::array();
  for (const SaidLine& line : lines) said.push_back({line.shown, line.full, line.is_warning});
  return said;
}

std::vector<SaidLine> said_from(const Json& j) {
  std::vector<SaidLine> lines;
  for (const Json& line : j) lines.push_back({line.at(0), line.at(1), line.at(2)});
  return lines;
}

Json to_json(const Chunk& chunk) {
  return Json::array(
      {chunk.code_begin, chunk.code_end, chunk.depth, to_json(chunk.box), chunk.points});
}

Chunk chunk_from(const Json& j) { return {j.at(0), j.at(1), j.at(2), box_from(j.at(3)), j.at(4)}; }

}  // namespace

ChunkId Partition::chunk_of(std::uint64_t vertex) const {
  const auto after = std::upper_bound(first_vertex.begin(), first_vertex.end(), vertex);
  return static_cast<ChunkId>(after - first_vertex.begin() - 1);
}

std::string partition_to_json(const Partition& partition) {
  Json chunks = Json::array();
  for (const Chunk& chunk : partition.octree.chunks()) chunks.push_back(to_json(chunk));
  const RootCube& root = partition.octree.root();
  Json document = {
      {"schema", to_json(partition.schema)},
      {"bounds", to_json(partition.bounds)},
      {"root", {{"origin", to_json(root.origin)}, {"side", root.side}}},
      {"chunks", chunks},
      {"first_vertex", partition.first_vertex},
      {"memory_bytes", partition.memory_bytes},
      {"points_read", partition.points_read},
      {"dropped", partition.dropped},
      {"spacing", partition.spacing},
      {"automatic_radii", partition.automatic_radii},
      {"radii_reason", partition.radii_reason},
      {"layers", to_json(partition.layers)},
      {"normal_radius", partition.normal_radius},
      {"points_without_view", partition.points_without_view},
      {kCleaning, to_json(partition.cleaning)},
      {"normals", to_json(partition.normals)},
      {"coordinate_system", partition.coordinate_system},
      {"has_wide_colors", partition.has_wide_colors},
  };
  if (partition.spacing_by_area > 0.0) document["spacing_by_area"] = partition.spacing_by_area;
  if (partition.sparse_offset > 0.0) document["sparse_offset"] = partition.sparse_offset;
  if (partition.line_neighbors > 0) document["line_neighbors"] = partition.line_neighbors;
  if (partition.coordinate_step > 0.0) document["coordinate_step"] = partition.coordinate_step;
  if (partition.common_step > 0.0) document["common_step"] = partition.common_step;
  if (!partition.said.empty()) document["said"] = to_json(partition.said);
  if (partition.meters_per_unit) document["meters_per_unit"] = to_json(*partition.meters_per_unit);
  return document_text(document);
}

Partition partition_from_json(const std::string& text) {
  const Json document = document_from(text);
  Partition partition;
  partition.schema = schema_from(document.at("schema"));
  partition.bounds = box_from(document.at("bounds"));
  RootCube root;
  root.origin = vec3_from(document.at("root").at("origin"));
  root.side = document.at("root").at("side");
  std::vector<Chunk> chunks;
  for (const Json& chunk : document.at("chunks")) chunks.push_back(chunk_from(chunk));
  partition.octree = Octree(root, std::move(chunks));
  partition.first_vertex = document.at("first_vertex").get<std::vector<std::uint64_t>>();
  partition.memory_bytes = document.at("memory_bytes");
  partition.points_read = document.at("points_read");
  partition.dropped = document.at("dropped").get<DroppedPoints>();
  partition.spacing = document.at("spacing");
  partition.automatic_radii = document.at("automatic_radii").get<std::vector<double>>();
  partition.radii_reason = document.at("radii_reason");
  partition.layers = layers_from(document.at("layers"));
  partition.normal_radius = document.at("normal_radius");
  partition.points_without_view = document.at("points_without_view");
  partition.cleaning = cleaning_from(document.at(kCleaning));
  partition.normals = normals_from(document.at("normals"));
  partition.coordinate_system = document.at("coordinate_system");
  partition.has_wide_colors = document.at("has_wide_colors");
  partition.spacing_by_area = document.value("spacing_by_area", 0.0);
  partition.sparse_offset = document.value("sparse_offset", 0.0);
  partition.line_neighbors = document.value("line_neighbors", std::size_t{0});
  partition.coordinate_step = document.value("coordinate_step", 0.0);
  partition.common_step = document.value("common_step", 0.0);
  // Documents of earlier versions have nothing said.
  if (document.contains("said")) partition.said = said_from(document.at("said"));
  if (document.contains("meters_per_unit"))
    partition.meters_per_unit = vec3_from(document.at("meters_per_unit"));
  return partition;
}

std::optional<Partition> stored_partition(const ChunkStore& store, const std::string& stage) {
  const auto document = store.document(stage, kDocument);
  if (!document) return std::nullopt;
  return partition_from_json(*document);
}

Partition expected_partition(const ChunkStore& store, const std::string& stage) {
  return partition_from_json(store.expected_document(stage, kDocument));
}

void commit_partition(ChunkStore& store, const std::string& stage, const Partition& partition) {
  store.finish_commits();
  store.commit_document(stage, kDocument, partition_to_json(partition));
}

std::string describe_dropped(std::uint64_t read, const DroppedPoints& dropped) {
  std::string text = std::to_string(read) + (read == 1 ? " point read" : " points read");
  const char* separator = "; ";
  for (const auto& [reason, count] : dropped) {
    text += separator + std::to_string(count) + " dropped: " + reason;
    separator = ", ";
  }
  return text;
}

void require_a_triangle(const std::string& file, std::uint64_t points, std::uint64_t read,
                        const DroppedPoints& dropped) {
  if (points >= 3) return;
  throw_bad_input("no triangle can be formed",
                  {.file = file,
                   .place = {},
                   .found = std::to_string(points) +
                            (points == 1 ? " distinct point, of " : " distinct points, of ") +
                            describe_dropped(read, dropped),
                   .expected = "at least three",
                   .advice = {}});
}

}  // namespace orbweave
