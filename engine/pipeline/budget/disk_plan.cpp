#include "engine/pipeline/budget/disk_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/normals/normal_side.h"
#include "engine/pipeline/stage/method_costs.h"
#include "io/error.h"
#include "io/job/simplified_file.h"
#include "io/points/point_views.h"
#include "io/system/disk_space.h"
#include "io/text/quantity.h"
#include "io/vertex_values.h"

namespace orbweave {
namespace {

// Bytes per point where nothing else is said; docs/disk.md has how they were measured.
constexpr double kBlockBounds = 48.0 / 1024;
constexpr double kChecksums = 5 * 8.0 / 1024;
constexpr double kTriangles = 2 * 12.0;
/// Of a Power Crust: corners of polygons, three or four at a vertex, and balls of the medial axis.
constexpr double kPolygons = 24.0;
/// Two triangles and a fan.
constexpr double kMesh = kTriangles + 1.0;
/// Its share that is left when it is compressed: numbers that differ by little. What is left of
/// positions and normals depends on the scanner; nothing is taken for granted.
constexpr double kPackedMesh = 0.5;
/// Patch and turn of a point, and its share of sums and votes.
constexpr double kPatches = 9.0 + 3.0;
/// Numbers as text: the shortest that reads back the same.
constexpr double kDoubleText = 20.0;
constexpr double kFloatText = 12.0;
constexpr double kIndexText = 10.0;
/// Rows of a chunk's border, per row along it: seams and the vertices of neighbours.
constexpr double kBorderBytes = 8 * 64.0;
/// What a file takes beyond its rows: HDF5's own structures, the rest of its last block.
constexpr double kFileBytes = 8192.0;
constexpr double kDocuments = 256.0 * 1024;
/// Surfaces that are rougher than those which were measured.
constexpr double kMargin = 1.05;

double normal_bytes(const PointSchema& schema) {
  return schema.has_normals ? 3.0 * static_cast<double>(size_of(schema.normal_type)) : 0.0;
}

double record_bytes(const PointSchema& schema) {
  return static_cast<double>(sizeof(Vec3)) + normal_bytes(schema) +
         static_cast<double>(schema.attribute_bytes());
}

double stored_bytes(const PointSchema& schema) {
  return record_bytes(schema) + kBlockBounds + kChecksums;
}

PointSchema with_normals(PointSchema schema) {
  if (schema.has_normals) return schema;
  schema.has_normals = true;
  schema.normal_type = ScalarType::kFloat32;
  return schema;
}

/// The schema of the points that are reconstructed.
PointSchema final_schema(const CloudSize& cloud, const RawWork& raw) {
  const PointSchema schema = view_offset(cloud.schema) ? without_view(cloud.schema) : cloud.schema;
  return raw.estimates ? with_normals(schema) : schema;
}

/// Most that the passes over raw points hold: each needs what the one before left, and the moves
/// of the smoothing are measured against its beginning.
double passes_bytes(const CloudSize& cloud, const RawWork& raw) {
  const CleaningOptions& cleaning = raw.cleaning;
  const double bare = stored_bytes(cloud.schema);
  std::vector<double> stages = {bare};
  if (cleaning.outlier_sigma > 0.0) stages.push_back(bare);
  if (cleaning.merge_tolerance > 0.0) stages.push_back(bare);
  const double full = raw.estimates ? stored_bytes(with_normals(cloud.schema)) : bare;
  if (raw.estimates) stages.push_back(full);
  double most = 0.0;
  for (std::size_t i = 1; i < stages.size(); ++i) most = std::max(most, stages[i - 1] + stages[i]);
  if (cleaning.smooth_radius > 0.0)
    most = std::max(most, (cleaning.smooth_passes > 1 ? 3.0 : 2.0) * full);
  if (cleaning.thin_to_spacing > 0.0) most = std::max(most, 2.0 * full);
  if (raw.propagates) most = std::max(most, full + kPatches);
  return most;
}

/// What is left of the passes while the points are cut for good.
double cleaned_bytes(const CloudSize& cloud, const RawWork& raw) {
  const PointSchema schema = raw.estimates ? with_normals(cloud.schema) : cloud.schema;
  return stored_bytes(schema) + (raw.propagates ? kPatches : 0.0);
}

/// Bins that are sorted but not durable yet, chunks per thread; no fewer are waited for.
constexpr std::uint64_t kChunksInFlight = 2;

std::uint64_t in_flight_bytes(const ResolvedJob& job, const CloudSize& cloud,
                              const PointSchema& schema) {
  const std::uint64_t points =
      std::min(cloud.points, kChunksInFlight * static_cast<std::uint64_t>(job.threads()) *
                                 cloud.memory.chunk_points);
  return static_cast<std::uint64_t>(static_cast<double>(points) * record_bytes(schema));
}

/// Most that bins and sorted points take together: a bin's room is given back when its points are
/// durable.
double cut_bytes(const ResolvedJob& job, const CloudSize& cloud, const PointSchema& schema) {
  const auto points = static_cast<double>(cloud.points);
  const double sorted = points * stored_bytes(schema);
  const double binned = points * record_bytes(schema);
  if (binned <= static_cast<double>(cloud.memory.bin_buffer_bytes)) return sorted;
  return sorted + static_cast<double>(in_flight_bytes(job, cloud, schema));
}

bool has_raw_passes(const RawWork& raw) { return raw.estimates || cleans(raw.cleaning); }

struct RowBytes {
  double vertex = 0.0;
  double triangle = 0.0;
};

RowBytes text_rows(const PointSchema& schema, double coordinate, double indices) {
  const bool single = schema.normal_type == ScalarType::kFloat32;
  double vertex = 3.0 * coordinate;
  if (schema.has_normals) vertex += 3.0 * (single ? kFloatText : kDoubleText);
  for (const AttributeField& field : schema.attributes)
    vertex += 2.0 + 2.2 * static_cast<double>(size_of(field.type));
  return {vertex, 2.0 + indices * kIndexText};
}

/// Bytes of the mesh file per vertex and triangle, by its format; compressed ones as if they were
/// not.
RowBytes output_rows(const ResolvedJob& job, PointSchema schema) {
  schema.has_normals = schema.has_normals && job.output.attributes;
  std::filesystem::path name(job.output.mesh);
  if (name.extension() == ".gz") name = name.stem();
  const double coordinate = job.output.float_positions ? kFloatText : kDoubleText;
  if (name.extension() == ".stl") {
    constexpr double kFacetText = 90.0;
    return {0.0, job.output.binary ? 50.0 : kFacetText + 12.0 * kFloatText};
  }
  if (name.extension() == ".obj") {
    schema.attributes.clear();
    RowBytes rows = text_rows(schema, coordinate, schema.has_normals ? 6.0 : 3.0);
    rows.vertex += schema.has_normals ? 7.0 : 3.0;
    return rows;
  }
  if (name.extension() == ".glb") {
    // Which colours there are matters little: 8 bytes at most.
    const bool has_colors = schema.attributes.size() >= 3;
    return {12.0 + (schema.has_normals ? 12.0 : 0.0) + (has_colors ? 8.0 : 0.0), 12.0};
  }
  const bool is_vtp = name.extension() == ".vtp";
  if (is_vtp || name.extension() == ".xdmf") {
    const double position = job.output.float_positions ? 12.0 : 24.0;
    return {position + normal_bytes(schema) + static_cast<double>(schema.attribute_bytes()),
            (is_vtp ? 32.0 : 24.0) + (job.fill.enabled ? 4.0 : 0.0)};
  }
  const bool has_confidence = job.output.confidence && job.fill.enabled;
  if (!job.output.binary)
    return text_rows(schema, coordinate,
                     (job.fill.enabled ? 3.2 : 3.0) + (has_confidence ? 0.5 : 0.0));
  const double position = job.output.float_positions ? 12.0 : 24.0;
  return {position + normal_bytes(schema) + static_cast<double>(schema.attribute_bytes()),
          13.0 + (job.fill.enabled ? 4.0 : 0.0) + (has_confidence ? 4.0 : 0.0)};
}

/// Polygons are as long as the triangles that they are cut into; the medial axis has fewer balls
/// than the surface has vertices.
double power_crust_files(const ResolvedJob& job, const RowBytes& rows, double vertices) {
  constexpr double kBall = 32.0;
  double bytes = 0.0;
  if (!job.output.polygons.empty()) bytes += vertices * (rows.vertex + 2.0 * rows.triangle);
  if (!job.output.medial_axis.empty()) bytes += 0.25 * vertices * kBall;
  return kMargin * bytes;
}

std::uint64_t whole(double bytes) { return static_cast<std::uint64_t>(std::ceil(bytes)); }

/// What levels of detail of the mesh file take, per point, of two triangles a point.
struct LevelBytes {
  double work = 0.0;        ///< of nodes and files without a name in the work directory
  double tileset = 0.0;     ///< of the folder
  double simplified = 0.0;  ///< of the simplified mesh
};

constexpr std::uint64_t kMostColorBytes = 6;

/// Positions, and what a tile has a place for, but for what it has of faces.
double level_vertex_bytes(const PointSchema& schema, const OutputOptions& output) {
  const bool has_colors = schema.attributes.size() >= 3;
  return 24.0 + (schema.has_normals ? 12.0 : 0.0) +
         (has_colors ? static_cast<double>(kMostColorBytes) : 0.0) +
         static_cast<double>(sizeof(float)) *
             (static_cast<double>(vertex_values(schema).size()) +
              (output.vertex_quality ? 3.0 : 0.0) + (output.vertex_undersampled ? 1.0 : 0.0));
}

LevelBytes level_bytes(const ResolvedJob& job, const CloudSize& cloud, const PointSchema& schema,
                       double mesh_bytes) {
  constexpr std::uint64_t kOne = 1;
  constexpr double kSorted = 2.0 * 40.0;  // triangles; twice that while runs are merged
  constexpr double kOfFace = 3.0 * 4.0;   // hole, confidence, component
  constexpr double kAllLevels = 1.5;      // triangles of all levels, in those of the mesh
  const bool merges = static_cast<double>(cloud.points) * kSorted >
                      static_cast<double>(job.partition.memory_bytes) / 6.0;
  // Nodes above the leaves: triangles with numbers of vertices, and half as many vertices as the
  // mesh has. A job that resumes has some while it merges.
  const double stored =
      static_cast<double>(cloud.node_bytes) / static_cast<double>(std::max(cloud.points, kOne));
  const auto nodes = [](double vertex, double face) { return 22.0 + 0.5 * vertex + face; };
  const auto work = [&](double vertex, double face) {
    return vertex +
           std::max(kSorted + nodes(vertex, face), merges ? 2.0 * kSorted + stored : kSorted);
  };
  const double tile_vertex = level_vertex_bytes(schema, job.output);
  LevelBytes bytes;
  if (job.output.tile_size > 0.0) bytes.work = stored_bytes(schema) + kSorted;
  if (!job.output.tileset.empty()) {
    bytes.work = work(tile_vertex, kOfFace);
    bytes.tileset = kAllLevels * (2.0 * 12.0 + tile_vertex + kOfFace);
  }
  if (job.output.simplify) {
    constexpr double kPosition = 24.0;
    // Those of the tileset stay until the job ends.
    const double held = job.output.tileset.empty() ? 0.0 : nodes(tile_vertex, kOfFace);
    bytes.work = std::max(bytes.work, work(kPosition, job.fill.enabled ? kOfFace : 0.0) + held);
    bytes.simplified = mesh_bytes;
    if (job.output.simplify->kind == SimplifyTarget::Kind::kRatio)
      bytes.simplified *= job.output.simplify->value;
  }
  return bytes;
}

/// What a file system has to take.
struct Demand {
  std::string what;
  std::filesystem::path place;
  std::uint64_t bytes = 0;
  const char* advice = "";
  FreeSpace free;
};

void require(const Demand& demand) {
  if (demand.bytes <= demand.free.bytes) return;
  throw_resource("there is not enough room on the disk for " + demand.what,
                 {.file = demand.place.string(),
                  .place = {},
                  .found = format_bytes(demand.free.bytes) + " free" +
                           (demand.free.limited_by_quota ? " within the quota" : ""),
                  .expected = "at least " + format_bytes(demand.bytes),
                  .advice = demand.advice});
}

FreeSpace free_space_for(const std::filesystem::path& file) {
  return free_space(file.has_parent_path() ? file.parent_path() : ".");
}

/// Puts a demand to that on the same file system, else behind the others.
void add_demand(const Demand& added, std::vector<Demand>& demands) {
  for (Demand& demand : demands) {
    if (demand.free.device != added.free.device) continue;
    demand.what += " and " + added.what;
    demand.bytes += added.bytes;
    demand.free.bytes = std::min(demand.free.bytes, added.free.bytes);
    demand.free.limited_by_quota |= added.free.limited_by_quota;
    return;
  }
  demands.push_back(added);
}

}  // namespace

RawWork raw_work(const ResolvedJob& job, const CloudSize& scans) {
  RawWork raw;
  raw.cleaning = job.cleaning;
  if (raw.cleaning.automatic) {
    // Sizes do not matter here, only that something is done.
    raw.cleaning.outlier_sigma = raw.cleaning.smooth_radius = raw.cleaning.thin_to_spacing = 1.0;
  }
  raw.estimates = job.estimates_normals;
  raw.propagates = raw.estimates && is_propagated(job.orientation_rule(scans.points_without_view));
  return raw;
}

DiskPlan plan_disk(const ResolvedJob& job, const CloudSize& cloud, const RawWork& raw) {
  const auto points = static_cast<double>(cloud.points);
  const auto chunks = static_cast<double>(cloud.chunks);
  const PointSchema schema = final_schema(cloud, raw);
  const double cut = cut_bytes(job, cloud, schema);
  const double borders = chunks * kBorderBytes * std::sqrt(points / chunks);
  const double files = kDocuments + chunks * kFileBytes;
  DiskPlan plan;
  if (has_raw_passes(raw)) {
    plan.cleaning_bytes = whole(kMargin * std::max(points * passes_bytes(cloud, raw),
                                                   points * cleaned_bytes(cloud, raw) + cut) +
                                3.0 * files);
  }
  const auto held = static_cast<double>(raw.held_bytes);
  const double mesh = job.run.compress ? kPackedMesh * kMesh : kMesh;
  const double vertices = points * costs_of(job.reconstruct.method).vertices_per_point;
  const RowBytes rows = output_rows(job, schema);
  const LevelBytes levels = level_bytes(job, cloud, schema, rows.vertex + 2.0 * rows.triangle);
  double surface = vertices * (mesh + levels.work);
  if (has_own_vertices(job.reconstruct.method))
    surface += vertices * (stored_bytes(schema) + kTriangles + kPolygons);
  const double work = std::max(held + kMargin * cut,
                               kMargin * (points * stored_bytes(schema) + surface + borders)) +
                      2.0 * files;
  const double output = job.output.mesh == "-"
                            ? 0.0
                            : kMargin * vertices * (rows.vertex + 2.0 * rows.triangle) + kFileBytes;
  plan.output_bytes = whole(output + power_crust_files(job, rows, vertices));
  plan.work_bytes = std::max(plan.cleaning_bytes, whole(work));
  plan.most_bytes = std::max(plan.cleaning_bytes, whole(work) + plan.output_bytes);
  plan.tileset_bytes = whole(kMargin * points * levels.tileset);
  plan.simplified_bytes = whole(kMargin * points * levels.simplified);
  return plan;
}

void require_room(const std::filesystem::path& work_dir, const OutputOptions& output,
                  const DiskPlan& plan, std::uint64_t held_bytes) {
  constexpr const char* kOtherWork =
      "Free some, or name another place with run.work_dir or --work-dir";
  constexpr const char* kOther = "Free some, or write it elsewhere";
  constexpr const char* kOtherMesh = "Free some, or write the mesh elsewhere";
  const auto beyond = [&](std::uint64_t bytes) { return bytes - std::min(bytes, held_bytes); };
  std::vector<Demand> demands = {
      {"the work directory", work_dir, beyond(plan.work_bytes), kOtherWork, free_space(work_dir)}};
  if (plan.output_bytes > 0) {
    Demand mesh{"the mesh", output.mesh, plan.output_bytes, kOtherMesh,
                free_space_for(output.mesh)};
    // The work directory may be fullest before there is a mesh.
    if (mesh.free.device == demands.front().free.device)
      mesh.bytes = beyond(plan.most_bytes) - std::min(beyond(plan.most_bytes), demands[0].bytes);
    add_demand(mesh, demands);
  }
  if (plan.tileset_bytes > 0)
    add_demand(
        {"the tileset", output.tileset, plan.tileset_bytes, kOther, free_space_for(output.tileset)},
        demands);
  if (plan.simplified_bytes > 0) {
    const std::filesystem::path file = simplified_file(output);
    add_demand({"the simplified mesh", file, plan.simplified_bytes, kOther, free_space_for(file)},
               demands);
  }
  for (const Demand& demand : demands) require(demand);
}

std::uint64_t predicted_disk_bytes(const ResolvedJob& job, const Partition& partition,
                                   std::uint64_t node_bytes) {
  CloudSize cloud;
  cloud.node_bytes = node_bytes;
  cloud.schema = partition.schema;
  cloud.points = partition.points();
  cloud.chunks = partition.octree.chunks().size();
  cloud.memory.bin_buffer_bytes = std::numeric_limits<std::size_t>::max();  // nothing is spilled
  return plan_disk(job, cloud, {}).all_bytes();
}

bool bins_will_spill(const CloudSize& cloud) {
  return static_cast<double>(cloud.points) * record_bytes(cloud.schema) >
         static_cast<double>(cloud.memory.bin_buffer_bytes);
}

RoomPlan check_room(StageRunner& runner, const CutStages& stages, bool are_scans,
                    const CloudSize& cloud) {
  const std::uint64_t in_flight = in_flight_bytes(runner.job, cloud, cloud.schema);
  if (!runner.communicator.is_root()) return {in_flight, 0};
  RawWork raw;
  if (are_scans) raw = raw_work(runner.job, cloud);
  const bool first_of_two = has_raw_passes(raw);
  const std::uint64_t held = runner.store.disk().now();
  // What an earlier run binned and sorted of these points is part of what they take.
  std::uint64_t of_points = 0;
  for (const char* stage : {stages.points(), stages.cut()})
    of_points += room_of_directory(runner.store.directory() / stage);
  if (!are_scans) raw.held_bytes = held - std::min(held, of_points);
  DiskPlan plan = plan_disk(runner.job, cloud, raw);
  const std::uint64_t predicted = plan.all_bytes();
  if (first_of_two) {
    // The number of points that cleaning leaves shows later; this much is needed in any case.
    plan.work_bytes = plan.most_bytes = plan.cleaning_bytes;
    plan.output_bytes = plan.tileset_bytes = plan.simplified_bytes = 0;
  }
  require_room(runner.store.directory(), runner.job.output, plan, held);
  const double cut = cut_bytes(runner.job, cloud, cloud.schema);
  const std::uint64_t least = held - std::min(held, of_points) + whole(cut);
  return {in_flight + plan.work_bytes - std::min(plan.work_bytes, least), predicted};
}

}  // namespace orbweave
