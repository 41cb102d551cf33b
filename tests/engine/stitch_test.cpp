// What the chunks' meshes are together, as it lies in the store; and the numbers of used points.
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/surface/stitch_stage.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/pipeline/surface/used_vertices.h"
#include "io/error.h"
#include "io/store/chunk_points.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::job_for;
using test::painted_torus;
using test::Random;
using test::RecordingProgress;
using test::ScratchDirectory;

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

/// Chunks whose meshes say nothing but which of their points are used.
struct FlaggedCloud {
  Partition partition;
  std::vector<std::uint8_t> fans;  // of all points
  std::vector<std::uint32_t> counts;

  void add_chunk(ChunkStore& store, const std::vector<std::uint8_t>& chunk, bool stored = true) {
    if (partition.first_vertex.empty()) partition.first_vertex = {0};
    const ArrayView array{"fans", ScalarType::kUint8, 1, chunk.size(), chunk.data()};
    const auto id = static_cast<ChunkId>(partition.first_vertex.size() - 1);
    if (stored) store.commit(kMeshStage, id, std::span(&array, 1));
    append_used_counts(chunk, counts);
    fans.insert(fans.end(), chunk.begin(), chunk.end());
    partition.first_vertex.push_back(fans.size());
  }
};

std::vector<std::uint8_t> random_fans(std::size_t points, double used, Random& random) {
  std::vector<std::uint8_t> fans(points);
  for (std::uint8_t& f : fans) {
    f = random.uniform() < used ? static_cast<std::uint8_t>(1 + random.below(3)) : 0;
  }
  return fans;
}

/// Every point's rank, counted one by one, against what is looked up in steps.
void check_ranks(const ChunkStore& store, const FlaggedCloud& cloud,
                 const std::set<std::uint64_t>& freed, std::uint64_t step) {
  const std::vector<std::uint64_t> listed(freed.begin(), freed.end());
  const UsedVertices used(store, cloud.partition, cloud.counts, listed);
  VertexRanks ranks(used);
  std::vector<std::uint64_t> expected;
  std::uint64_t before = 0;
  for (std::uint64_t point = 0; point < cloud.fans.size(); ++point) {
    expected.push_back(before);
    before += cloud.fans[point] != 0 && !freed.contains(point) ? 1 : 0;
  }
  CHECK(used.count() == before);
  std::uint64_t wrong = 0;
  // Up and down in turn, so that blocks are left and come back to.
  for (std::uint64_t i = 0; i < cloud.fans.size(); i += step) {
    const std::uint64_t mirrored = cloud.fans.size() - 1 - i;
    wrong += value_of(ranks.of(i)) != expected[i] ? 1 : 0;
    wrong += value_of(ranks.of(mirrored)) != expected[mirrored] ? 1 : 0;
  }
  CHECK(wrong == 0);
}

/// A stored file as this moment has it.
struct FileMark {
  ino_t node = 0;
  timespec changed{};
  friend bool operator==(const FileMark& a, const FileMark& b) {
    return a.node == b.node && a.changed.tv_sec == b.changed.tv_sec &&
           a.changed.tv_nsec == b.changed.tv_nsec;
  }
};
FileMark mark_of(const fs::path& file) {
  struct stat facts {};
  REQUIRE(stat(file.c_str(), &facts) == 0);
  return {facts.st_ino, facts.st_mtim};
}

fs::path stitch_file(const Job& job) {
  return fs::path(job.run.work_dir) / kStitchStage / "000000.h5";
}

/// A surface full of holes; the work directory is kept.
Job holey_job(const ScratchDirectory& scratch) {
  Job job = job_for(scratch, painted_torus(3000, 0.6, 31));
  job.reconstruct.ball_radii.resize(1);
  job.partition.chunk_points = 400;
  job.run.keep_work_dir = true;
  return job;
}

/// One that has run.
Job kept_job(const ScratchDirectory& scratch) {
  const Job job = holey_job(scratch);
  test::run(job);
  return job;
}

using Look = void (*)(const SurfaceInputs&, const ResolvedJob&, const ChunkStore&);

/// Of looking, under a budget, at what a job left.
std::optional<Error> error_of(Job job, std::uint64_t budget, Look look) {
  job.partition.memory_bytes = budget;
  const ChunkStore store(job.run.work_dir);
  const Partition partition = stored_partition(store).value();
  const BallRadii radii{job.reconstruct.ball_radii, ""};
  try {
    look({partition, radii}, resolve(job, job.input.files), store);
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

std::optional<Error> stitch_error(const Job& job, std::uint64_t budget) {
  return error_of(job, budget,
                  [](const SurfaceInputs& inputs, const ResolvedJob& resolved,
                     const ChunkStore& store) { stitch_chunks(inputs, resolved, store, {}); });
}

}  // namespace

TEST_CASE("RanksOfUsedPointsAreThoseOfACountThroughTheWholeCloud") {
  const ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  Random random(1);
  FlaggedCloud cloud;
  // Several blocks to a chunk, one that ends with a chunk, one of a single point; and more blocks
  // than are kept.
  for (const std::size_t points : {std::size_t{150'000}, std::size_t{65'536}, std::size_t{1}}) {
    cloud.add_chunk(store, random_fans(points, 0.9, random));
  }
  for (int i = 0; i < 400; ++i) cloud.add_chunk(store, random_fans(7, 0.5, random));
  cloud.add_chunk(store, random_fans(300, 0.0, random));
  store.finish_commits();
  check_ranks(store, cloud, {}, 1);
  std::set<std::uint64_t> freed;
  for (std::uint64_t point = 3; point < cloud.fans.size(); point += 1 + random.below(900)) {
    if (cloud.fans[point] != 0) freed.insert(point);
  }
  check_ranks(store, cloud, freed, 1);
}

TEST_CASE("PointsThatAreAllUsedAreNumberedWithoutReadingThem") {
  const ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  Random random(2);
  FlaggedCloud cloud;
  cloud.add_chunk(store, std::vector<std::uint8_t>(70'000, 1), false);
  cloud.add_chunk(store, random_fans(500, 0.5, random));
  cloud.add_chunk(store, std::vector<std::uint8_t>(100, 2), false);
  store.finish_commits();
  check_ranks(store, cloud, {}, 7);
  // One of them is freed: now somebody has to look, and there is nothing.
  const std::vector<std::uint64_t> freed = {65'600};
  const UsedVertices used(store, cloud.partition, cloud.counts, freed);
  CHECK(value_of(VertexRanks(used).of(65'535)) == 65'535);
  CHECK_THROWS_AS(VertexRanks(used).of(69'999), CorruptResult);
}

TEST_CASE("AStitchedMeshIsReadBackWhereTheChunksAreTheSame") {
  const ScratchDirectory scratch;
  const Job job = kept_job(scratch);
  const std::string expected = bytes_of(job.output.mesh);
  const FileMark before = mark_of(stitch_file(job));
  const RunReport again = test::run(job);
  CHECK(mark_of(stitch_file(job)) == before);
  CHECK((bytes_of(job.output.mesh) == expected));
  const auto stage = std::find_if(again.stages.begin(), again.stages.end(),
                                  [](const StageFacts& facts) { return facts.name == "stitch"; });
  REQUIRE(stage != again.stages.end());
  CHECK(stage->chunks_reused == stage->chunks);
}

TEST_CASE("FactsOfAMeshThatIsReadBackAreThoseOfTheFirstRun") {
  const ScratchDirectory scratch;
  Job job = holey_job(scratch);
  job.fill.enabled = GENERATE(true, false);
  const RunReport first = test::run(job);
  REQUIRE((job.fill.enabled ? first.holes.size() : first.mesh.boundary_edges) > 0);
  REQUIRE(first.points_unused > 0);
  const RunReport again = test::run(job);
  CHECK(again.mesh.vertices == first.mesh.vertices);
  CHECK(again.mesh.triangles == first.mesh.triangles);
  CHECK(again.mesh.components == first.mesh.components);
  CHECK(again.mesh.boundary_edges == first.mesh.boundary_edges);
  CHECK(again.mesh.boundary_loops == first.mesh.boundary_loops);
  CHECK(again.mesh.nonmanifold_vertices == first.mesh.nonmanifold_vertices);
  CHECK(again.mesh.euler_characteristic == first.mesh.euler_characteristic);
  CHECK(again.mesh.area == first.mesh.area);
  CHECK(again.mesh.checksum == first.mesh.checksum);
  CHECK(again.points_unused == first.points_unused);
  CHECK(again.conflicts_lost == first.conflicts_lost);
}

TEST_CASE("ADamagedStitchIsMadeAgain") {
  const ScratchDirectory scratch;
  const Job job = kept_job(scratch);
  const std::string expected = bytes_of(job.output.mesh);
  test::damage(stitch_file(job));
  test::run(job);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("AChunkMeshThatIsMadeAgainIsStitchedAgain") {
  const ScratchDirectory scratch;
  const Job job = kept_job(scratch);
  const std::string expected = bytes_of(job.output.mesh);
  const FileMark before = mark_of(stitch_file(job));
  fs::remove(fs::path(job.run.work_dir) / kMeshStage / "000001.h5");
  test::run(job);
  CHECK_FALSE(mark_of(stitch_file(job)) == before);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("ABoundaryBeyondTheBudgetIsRefusedBeforeItIsRead") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  job.fill.enabled = GENERATE(true, false);
  CHECK_FALSE(stitch_error(job, std::uint64_t{1} << 30));
  // What the process takes before it holds a point, by memory_forecast.cpp.
  const auto error = stitch_error(job, std::uint64_t{64} << 20);
  REQUIRE(error);
  CHECK(error->kind() == ErrorKind::kResource);
  const std::string text = error->what();
  INFO(text);
  CHECK(text.find("boundary edges in ") != std::string::npos);
  CHECK(text.find("at least 65 MiB") != std::string::npos);
  CHECK((text.find("fill.enabled = false") != std::string::npos) == job.fill.enabled);
}

TEST_CASE("AStoredBoundaryIsRefusedWhereTheBudgetIsSmallerNow") {
  const ScratchDirectory scratch;
  const Job job = kept_job(scratch);
  const auto read = [](const SurfaceInputs& inputs, const ResolvedJob& resolved,
                       const ChunkStore& store) {
    if (!stored_stitch(inputs, resolved, store)) throw std::logic_error("nothing is stored");
  };
  CHECK_FALSE(error_of(job, std::uint64_t{1} << 30, read));
  const auto error = error_of(job, std::uint64_t{64} << 20, read);
  REQUIRE(error);
  CHECK(error->kind() == ErrorKind::kResource);
}

TEST_CASE("TheBoundaryCostsLessWhereNoHolesAreFilled") {
  ResolvedJob job;
  job.partition.memory_bytes = std::uint64_t{200} << 20;
  HoleLoad load;
  load.edges = 1'400'000;
  load.loops = 200'000;
  CHECK_THROWS_AS(require_memory_for_boundary(job, Partition(), load), Error);
  job.fill.enabled = false;
  CHECK_NOTHROW(require_memory_for_boundary(job, Partition(), load));
  load.edges *= 10;
  CHECK_THROWS_AS(require_memory_for_boundary(job, Partition(), load), Error);
}

}  // namespace orbweave
