#include "engine/pipeline/points/raw_passes.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "io/error.h"
#include "io/first_touch.h"
#include "io/job/setting.h"
#include "io/store/chunk_points.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

constexpr const char* kEnded = "ended";

void append(PassPoints& to, const PointCloud& points) {
  to.positions.insert(to.positions.end(), points.positions.begin(), points.positions.end());
  to.normals.insert(to.normals.end(), points.normals.begin(), points.normals.end());
}

/// Numbers that rise with the raw order; no more is asked of them.
std::uint64_t first_number(const RawCloud& cloud, ChunkId chunk) {
  return cloud.partition.first_vertex[chunk];
}

PassPoints load_pass_points(const StageRunner& runner, const RawCloud& cloud, ChunkId chunk,
                            double halo) {
  PassPoints points;
  points.own = load_points(runner.store, chunk, cloud.schema, cloud.stage);
  if (points.own.empty()) return points;
  const Box reach = points.own.bounds().grown(halo);
  // The cubes say where points were before they were moved: by up to `drift`, both here and there.
  std::vector<ChunkId> sources = cloud.partition.octree.neighbors(chunk, halo + 2.0 * cloud.drift);
  sources.insert(std::upper_bound(sources.begin(), sources.end(), chunk), chunk);
  std::vector<PointsInBox> found(sources.size());
  std::size_t count = points.own.size();
  for (std::size_t i = 0; i < sources.size(); ++i) {
    runner.stop.check();
    if (sources[i] != chunk)
      found[i] = load_points_in_box(runner.store, sources[i], cloud.schema, reach, {}, cloud.stage);
    count += found[i].rows.size();
  }
  reserve_touched(points.positions, count);
  if (cloud.schema.has_normals) reserve_touched(points.normals, count);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const PointsInBox others = std::move(found[i]);
    const std::uint64_t first = first_number(cloud, sources[i]);
    if (sources[i] == chunk) {
      points.first_number = first;
      points.begin = static_cast<std::uint32_t>(points.positions.size());
      append(points, points.own);
      points.end = static_cast<std::uint32_t>(points.positions.size());
      continue;
    }
    append(points, others.points);
    (sources[i] < chunk ? points.before : points.after).push_back({first, others.rows});
  }
  return points;
}

/// Points of a chunk and its halo, about: those of a surface grow with the square of its side.
std::uint64_t points_with_halo(const RawCloud& cloud, ChunkId chunk, double halo) {
  const double side = cloud.partition.octree.chunks()[chunk].box.largest_extent();
  const double grown = (side + 2.0 * halo) / side;
  const double points = static_cast<double>(cloud.partition.points_in(chunk)) * grown * grown;
  return std::min(cloud.partition.points(), static_cast<std::uint64_t>(points));
}

std::uint64_t points_of_stage(const StageRunner& runner, const RawCloud& cloud) {
  std::uint64_t points = 0;
  for (ChunkId chunk = 0; chunk < cloud.partition.octree.chunks().size(); ++chunk)
    points += stored_points(runner.store, chunk, cloud.stage);
  return points;
}

/// A pass that is complete says how many points it left; they may have gone since.
std::optional<std::uint64_t> points_of_ended_pass(const StageRunner& runner,
                                                  const std::string& stage) {
  const std::optional<std::string> document = runner.store.document(stage, kEnded);
  if (!document) return std::nullopt;
  return std::stoull(*document);
}

/// How many points a chunk lost for the other reason of a pass.
std::string also_document(ChunkId chunk) { return "also_" + std::to_string(chunk); }

std::uint64_t also_dropped(const StageRunner& runner, const RawCloud& cloud, const RawPass& pass) {
  std::uint64_t sum = 0;
  if (pass.also_reason == DropReason::kNone) return sum;
  for (ChunkId chunk = 0; chunk < cloud.partition.octree.chunks().size(); ++chunk)
    if (const auto count = runner.store.document(pass.stage, also_document(chunk)))
      sum += std::stoull(*count);
  return sum;
}

[[noreturn]] void throw_no_points(const StageRunner& runner, const RawCloud& cloud) {
  DroppedPoints dropped = cloud.partition.dropped;
  for (const auto& [reason, count] : cloud.dropped) dropped[reason] += count;
  throw_bad_input("no point is left to make a mesh of",
                  {.file = runner.job.files.front(),
                   .found = describe_dropped(cloud.partition.points_read, dropped),
                   .expected = "points that lie close to each other on a surface, and not all on "
                               "a line or at one place",
                   .advice = cloud.dropped.contains(text_of(DropReason::kTooFewNeighbors))
                                 ? "Points that bring their normals (" +
                                       setting(runner.job, "normals.source", "file") +
                                       ") need no neighbours for one"
                                 : std::string("Reduce the cleaning")});
}

bool has_all_chunks(const StageRunner& runner, const RawCloud& cloud, const std::string& stage) {
  for (ChunkId chunk = 0; chunk < cloud.partition.octree.chunks().size(); ++chunk)
    if (!runner.store.has(stage, chunk)) return false;
  return true;
}

}  // namespace

std::vector<std::uint64_t> PassPoints::numbers() const {
  std::vector<std::uint64_t> numbers;
  numbers.reserve(positions.size());
  const auto add = [&](const std::vector<Source>& sources) {
    for (const Source& source : sources)
      for (const std::uint32_t row : source.rows) numbers.push_back(source.first_number + row);
  };
  add(before);
  for (std::uint32_t i = 0; i < end - begin; ++i) numbers.push_back(first_number + i);
  add(after);
  return numbers;
}

void require_points(StageRunner& runner, const RawCloud& cloud) {
  runner.communicator.barrier(runner.stop);  // what is there changes only when all have seen it
  if (!has_all_chunks(runner, cloud, cloud.stage)) throw RawPointsGone();
  runner.communicator.barrier(runner.stop);
}

void require_points_for(StageRunner& runner, const RawCloud& cloud, const std::string& stage) {
  runner.communicator.barrier(runner.stop);  // what is there changes only when all have seen it
  const bool is_complete = has_all_chunks(runner, cloud, stage);
  if (!is_complete && !has_all_chunks(runner, cloud, cloud.stage)) throw RawPointsGone();
  runner.communicator.barrier(runner.stop);
}

void visit_chunks(StageRunner& runner, const RawCloud& cloud, const std::string& stage, double halo,
                  const std::function<void(ChunkId, PassPoints&&)>& visit) {
  const auto chunks = static_cast<ChunkId>(cloud.partition.octree.chunks().size());
  StageClock clock(runner, stage, chunks, "chunks");
  std::vector<ChunkWork> tasks;
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    const std::uint64_t points = points_with_halo(cloud, chunk, halo);
    tasks.push_back(
        {chunk, points * MemoryCosts::kReconstructBytes, points, cloud.partition.points_in(chunk)});
  }
  const MemoryPlan plan = runner.job.memory_plan(cloud.partition.points(), cloud.schema);
  share_chunks(runner, clock, stage, std::move(tasks), plan.chunks_in_flight_bytes,
               [&](ChunkId chunk) { visit(chunk, load_pass_points(runner, cloud, chunk, halo)); });
  clock.facts().points = cloud.partition.points();
}

void run_pass(StageRunner& runner, const RawPass& pass, RawCloud& cloud) {
  cloud.key += key_line("pass", pass.stage) + pass.options;
  by_root(runner, [&] { begin_stage(runner, pass.stage, cloud.key); });
  PointSchema schema = pass.schema.value_or(cloud.schema);
  if (pass.adds_normals) {
    schema.has_normals = true;
    schema.normal_type = ScalarType::kFloat32;
  }
  const std::optional<std::uint64_t> ended = points_of_ended_pass(runner, pass.stage);
  runner.communicator.barrier(runner.stop);  // what is there changes only when all have seen it
  if (!ended) {
    require_points(runner, cloud);
    visit_chunks(runner, cloud, pass.stage, pass.halo, [&](ChunkId chunk, PassPoints&& points) {
      PassResult result =
          points.own.empty() ? PassResult{std::move(points.own)} : pass.work(std::move(points));
      result.points.schema = schema;
      if (pass.look && !result.points.empty()) pass.look(chunk, result);
      if (result.also_dropped > 0)
        runner.store.commit_document(pass.stage, also_document(chunk),
                                     std::to_string(result.also_dropped));
      commit_points(runner.store, chunk, result.points, pass.stage, result.rows);
    });
  }
  const std::string before = std::exchange(cloud.stage, pass.stage);
  cloud.schema = schema;
  cloud.drift += pass.drift;
  const std::uint64_t points = ended ? *ended : points_of_stage(runner, cloud);
  const std::uint64_t also = also_dropped(runner, cloud, pass);
  if (also > 0) cloud.dropped[text_of(pass.also_reason)] += also;
  if (cloud.points - points > also)
    cloud.dropped[text_of(pass.dropped_reason)] += cloud.points - points - also;
  cloud.points = points;
  if (points == 0) throw_no_points(runner, cloud);
  if (runner.communicator.is_root()) {
    if (!ended) runner.store.commit_document(pass.stage, kEnded, std::to_string(points));
    if (before != cloud.kept_stage) runner.store.discard_results(before);
  }
}

}  // namespace orbweave
