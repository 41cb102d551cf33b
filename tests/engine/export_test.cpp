// The mesh file: written by several threads and processes at once, in pieces, as tiles; of any
// size.
#include "engine/pipeline/output/export_stage.h"

#include <algorithm>
#include <atomic>
#include <barrier>
#include <catch2/catch.hpp>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "engine/planning/plan_job.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/points/own_attribute.h"
#include "io/store/chunk_store.h"
#include "io/store/chunk_store_file.h"
#include "io/system/owned_files.h"
#include "partition/communicator.h"
#include "tests/io/reading.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::job_for;
using test::mesh_bytes;
using test::NamedCloud;
using test::raw;
using test::run;
using test::ScratchDirectory;

/// Members of a team that are threads of the test.
class ThreadTeam : public Communicator {
 public:
  struct Shared {
    explicit Shared(int members) : size(members), meeting(members) {}
    int size;
    std::barrier<> meeting;
    std::atomic<std::uint64_t> next{0};
    std::atomic<std::uint64_t> word{0};
    std::vector<std::string> texts = std::vector<std::string>(static_cast<std::size_t>(size));
  };
  ThreadTeam(Shared& shared, int rank) : shared_(shared), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return shared_.size; }
  using Communicator::barrier;
  void barrier(const StopToken&, const std::function<void()>&) override {
    shared_.meeting.arrive_and_wait();
  }
  std::uint64_t broadcast(std::uint64_t word, const StopToken&) override {
    if (is_root()) shared_.word = word;
    shared_.meeting.arrive_and_wait();
    const std::uint64_t told = shared_.word;
    shared_.meeting.arrive_and_wait();
    return told;
  }
  std::vector<std::string> gather(const std::string& text, const StopToken&) override {
    shared_.texts[static_cast<std::size_t>(rank_)] = text;
    shared_.meeting.arrive_and_wait();
    const std::vector<std::string> told = is_root() ? shared_.texts : std::vector<std::string>();
    shared_.meeting.arrive_and_wait();
    return told;
  }
  void reset_counter(const StopToken&) override {
    shared_.meeting.arrive_and_wait();
    if (rank_ == 0) shared_.next = 0;
    shared_.meeting.arrive_and_wait();
  }

 protected:
  std::uint64_t count_up(std::uint64_t amount) override { return shared_.next.fetch_add(amount); }

 private:
  Shared& shared_;
  int rank_;
};

/// Runs the job by so many members; returns the leader's report.
RunReport run_by_team(const Job& job, int members) {
  ThreadTeam::Shared shared(members);
  std::vector<RunReport> reports(static_cast<std::size_t>(members));
  std::vector<std::exception_ptr> failures(reports.size());
  std::vector<std::thread> threads;
  for (int rank = 0; rank < members; ++rank) {
    threads.emplace_back([&, rank] {
      const auto at = static_cast<std::size_t>(rank);
      try {
        ThreadTeam communicator(shared, rank);
        test::RecordingProgress progress;
        const StopToken stop;
        reports[at] = run_job(job, {"test"}, progress, stop, communicator);
      } catch (...) {
        failures[at] = std::current_exception();
        shared.meeting.arrive_and_drop();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  return reports.front();
}

void remove_ball(PointCloud& cloud, Vec3 center, double radius) {
  PointCloud kept;
  kept.schema = cloud.schema;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (norm(cloud.positions[i] - center) >= radius) kept.append(cloud, i);
  }
  cloud = std::move(kept);
}

/// Rough enough that pieces are removed, vertices split and many holes filled; one hole is large.
NamedCloud rough_torus(std::size_t points = 3000) {
  NamedCloud named = test::painted_torus(points, 0.9, 33);
  remove_ball(named.cloud, {1.0, 0.0, 0.4}, 0.3);
  return named;
}

Job rough_job(const ScratchDirectory& scratch, const NamedCloud& named) {
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 700;
  job.fill.min_triangles = 6;
  return job;
}

std::size_t entries_in(const fs::path& directory) {
  const fs::directory_iterator all(directory);
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

/// The tiles of a mesh put together by their vertices' numbers and the index's runs.
struct JoinedTiles {
  TriangleMesh mesh;
  std::size_t files = 0;
  std::size_t shared = 0;  ///< vertices that more than one tile has
};

/// One tile into the whole; what several tiles have must be the same.
void join(const TriangleMesh& tile, const nlohmann::json& facts, JoinedTiles& joined,
          std::vector<bool>& seen) {
  const std::size_t columns = tile.vertices.schema.attributes.size() - 1;
  const std::size_t width = joined.mesh.vertices.schema.attribute_bytes();
  REQUIRE(tile.vertices.schema.attributes.back().name == "vertex_id");
  std::vector<std::uint32_t> ids;
  for (std::size_t i = 0; i < tile.vertices.size(); ++i) {
    ids.push_back(static_cast<std::uint32_t>(attribute_value(tile.vertices, i, columns)));
    PointCloud& all = joined.mesh.vertices;
    const std::size_t id = ids.back();
    REQUIRE(id < all.size());
    const auto* row = tile.vertices.attributes.data() + i * tile.vertices.schema.attribute_bytes();
    if (seen[id]) {
      ++joined.shared;
      REQUIRE(all.positions[id] == tile.vertices.positions[i]);
      REQUIRE(all.normals[id] == tile.vertices.normals[i]);
      REQUIRE(std::equal(row, row + width, all.attributes.data() + id * width));
    }
    seen[id] = true;
    all.positions[id] = tile.vertices.positions[i];
    all.normals[id] = tile.vertices.normals[i];
    std::copy(row, row + width, all.attributes.data() + id * width);
  }
  REQUIRE(std::is_sorted(ids.begin(), ids.end()));
  std::size_t row = 0;
  for (const auto& run : facts.at("runs")) {
    REQUIRE(run.at(0) == row);
    const std::size_t first = run.at(1), rows = run.at(2);
    for (std::size_t i = 0; i < rows; ++i, ++row) {
      const Triangle& t = tile.triangles.at(row);
      joined.mesh.triangles.at(first + i) = {ids[t[0]], ids[t[1]], ids[t[2]]};
      if (!tile.hole.empty()) joined.mesh.hole.at(first + i) = tile.hole.at(row);
    }
  }
  REQUIRE(row == tile.triangles.size());
}

JoinedTiles join_tiles(const fs::path& directory, const TriangleMesh& like) {
  const auto index = nlohmann::json::parse(bytes_of(directory / "tiles.json"));
  JoinedTiles joined;
  joined.mesh.vertices.schema = like.vertices.schema;
  joined.mesh.vertices.positions.resize(index.at("vertices"));
  joined.mesh.vertices.normals.resize(index.at("vertices"));
  joined.mesh.vertices.attributes.resize(joined.mesh.vertices.size() *
                                         like.vertices.schema.attribute_bytes());
  joined.mesh.triangles.resize(index.at("triangles"));
  if (!like.hole.empty()) joined.mesh.hole.resize(index.at("triangles"));
  std::vector<bool> seen(joined.mesh.vertices.size(), false);
  for (const auto& facts : index.at("tiles")) {
    const TriangleMesh tile = read_mesh(directory / facts.at("file").get<std::string>());
    CHECK(tile.vertices.size() == facts.at("vertices"));
    CHECK(tile.triangles.size() == facts.at("triangles"));
    const Box bounds = tile.vertices.bounds();
    CHECK(facts.at("bounds") == nlohmann::json({{bounds.min.x, bounds.min.y, bounds.min.z},
                                                {bounds.max.x, bounds.max.y, bounds.max.z}}));
    join(tile, facts, joined, seen);
    ++joined.files;
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](bool one) { return one; }));
  return joined;
}

/// The mesh as a set of faces: the row of each triangle of the one mesh.
std::map<Triangle, std::size_t> rows_of(const TriangleMesh& mesh) {
  std::map<Triangle, std::size_t> rows;
  for (std::size_t row = 0; row < mesh.triangles.size(); ++row)
    REQUIRE(rows.emplace(mesh.triangles[row], row).second);
  return rows;
}

/// Requires that tiles on a map grid have every triangle of the mesh once, in the tile of the cell
/// of its centroid, in the mesh's order, with the mesh's vertices. Returns how many tiles.
std::size_t require_map_tiles_of(const fs::path& directory, const TriangleMesh& mesh, double size) {
  const auto index = nlohmann::json::parse(bytes_of(directory / "tiles.json"));
  REQUIRE(index.at("tile_size") == size);
  const std::map<Triangle, std::size_t> rows = rows_of(mesh);
  std::vector<int> seen(mesh.triangles.size(), 0);
  for (const auto& facts : index.at("tiles")) {
    const std::string name = facts.at("file");
    INFO(name);
    const TriangleMesh tile = read_mesh(directory / name);
    REQUIRE(tile.vertices.size() == facts.at("vertices"));
    REQUIRE(tile.triangles.size() == facts.at("triangles"));
    JoinedTiles joined;
    joined.mesh = mesh;
    std::vector<bool> known(mesh.vertices.size(), true);
    nlohmann::json no_runs = {{"runs", nlohmann::json::array()}};
    TriangleMesh points = tile;
    points.triangles.clear();
    join(points, no_runs, joined, known);  // every vertex is the mesh's
    const std::size_t ids = tile.vertices.schema.attributes.size() - 1;
    const auto id = [&](std::uint32_t vertex) {
      return static_cast<std::uint32_t>(attribute_value(tile.vertices, vertex, ids));
    };
    std::size_t next = 0;
    for (std::size_t i = 0; i < tile.triangles.size(); ++i) {
      const Triangle& t = tile.triangles[i];
      const std::size_t row = rows.at({id(t[0]), id(t[1]), id(t[2])});
      REQUIRE(row >= next);
      next = row + 1;
      ++seen[row];
      if (!mesh.hole.empty()) REQUIRE(tile.hole.at(i) == mesh.hole[row]);
      const auto& at = tile.vertices.positions;
      const Vec3 centroid = (at[t[0]] + at[t[1]] + at[t[2]]) / 3.0;
      REQUIRE(std::floor(centroid.x / size) * size == facts.at("corner").at(0));
      REQUIRE(std::floor(centroid.y / size) * size == facts.at("corner").at(1));
    }
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
  return index.at("tiles").size();
}

void require_same_mesh(const TriangleMesh& a, const TriangleMesh& b) {
  REQUIRE((a.vertices.positions == b.vertices.positions));
  REQUIRE((a.vertices.normals == b.vertices.normals));
  REQUIRE((a.vertices.attributes == b.vertices.attributes));
  REQUIRE((a.triangles == b.triangles));
  REQUIRE((a.hole == b.hole));
}

}  // namespace

TEST_CASE("ATeamWritesTheSameFileAsOneProcess", "[slow]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  for (const bool fill : {true, false}) {
    Job job = rough_job(scratch, named);
    job.fill.enabled = fill;
    const RunReport alone = run(job);
    const std::string expected = bytes_of(job.output.mesh);
    for (const int members : {2, 3}) {
      fs::remove(job.output.mesh);
      const RunReport report = run_by_team(job, members);
      INFO("fill " << fill << ", members " << members);
      REQUIRE((bytes_of(job.output.mesh) == expected));
      CHECK(report.mesh.checksum == alone.mesh.checksum);
      CHECK(report.mesh.bounds == alone.mesh.bounds);
      CHECK(report.holes.size() == alone.holes.size());
    }
  }
  CHECK(entries_in(scratch.path()) == 2);  // the cloud and the mesh: no temporary is left
}

TEST_CASE("ATeamWritesFormatsWithoutFixedRowsAsWell", "[slow]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  for (const char* mesh : {"mesh.obj", "mesh.stl", "mesh.ply.gz"}) {
    Job job = rough_job(scratch, named);
    job.output.mesh = (scratch / mesh).string();
    const std::string expected = mesh_bytes(job);
    fs::remove(job.output.mesh);
    run_by_team(job, 2);
    INFO(mesh);
    REQUIRE((bytes_of(job.output.mesh) == expected));
  }
}

TEST_CASE("PlacedRowsAreThoseOfTheStreamingWriter", "[costly]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  for (const bool narrow : {true, false}) {
    Job job = rough_job(scratch, named);
    job.output.float_positions = narrow;
    job.run.keep_work_dir = true;
    const std::string placed = mesh_bytes(job);
    // Compressed files have no places: they go through the writer that streams.
    job.output.mesh = (scratch / "streamed.ply.gz").string();
    run(job);
    const TriangleMesh streamed = read_mesh(job.output.mesh);
    const TriangleMesh mesh = read_mesh(scratch / "mesh.ply");
    CHECK(mesh.vertices.positions == streamed.vertices.positions);
    CHECK(mesh.vertices.normals == streamed.vertices.normals);
    CHECK(mesh.vertices.attributes == streamed.vertices.attributes);
    CHECK(mesh.triangles == streamed.triangles);
    CHECK(mesh.hole == streamed.hole);
  }
}

TEST_CASE("ConfidenceOfTheFacesIsThatOfTheReportWhateverWritesTheMesh", "[costly]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  job.output.confidence = true;
  const RunReport report = run(job);
  const std::string placed = bytes_of(job.output.mesh);
  CHECK(placed.find("property float confidence\n") != std::string::npos);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  std::string faces;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::int32_t hole = mesh.hole[t];
    const double confidence =
        hole == 0 ? 1.0 : report.holes.at(static_cast<std::size_t>(hole) - 1).confidence;
    faces += '\x03';
    for (const std::uint32_t corner : mesh.triangles[t]) faces += raw(corner);
    faces += raw(hole) + raw(static_cast<float>(confidence));
  }
  CHECK(placed.ends_with(faces));
  run_by_team(job, 2);
  CHECK((bytes_of(job.output.mesh) == placed));
}

TEST_CASE("ADeviceGetsTheMeshDirectly", "[costly]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  const RunReport expected = run(job);
  job.output.mesh = "/dev/null";
  CHECK_THROWS_AS(run(job), Error);  // no extension tells the format
  fs::create_symlink("/dev/null", scratch / "null.ply");
  job.output.mesh = (scratch / "null.ply").string();
  CHECK(run(job).mesh.checksum == expected.mesh.checksum);
  CHECK(run_by_team(job, 2).mesh.checksum == expected.mesh.checksum);
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("JoinedTilesAreTheOneMesh", "[slow]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  for (const bool fill : {true, false}) {
    for (const std::uint64_t chunk_points : {250u, 1500u, 1'000'000u}) {
      INFO("fill " << fill << ", chunk_points " << chunk_points);
      Job job = rough_job(scratch, named);
      job.fill.enabled = fill;
      job.partition.chunk_points = chunk_points;
      job.output.tiles = false;
      job.run.keep_work_dir = true;
      const RunReport whole = run(job);
      const TriangleMesh mesh = read_mesh(job.output.mesh);
      fs::remove(job.output.mesh);
      job.output.tiles = true;
      job.run.keep_work_dir = false;
      const RunReport report = run(job);
      CHECK_FALSE(fs::exists(job.output.mesh));
      const JoinedTiles joined = join_tiles(scratch / "mesh.tiles", mesh);
      require_same_mesh(joined.mesh, mesh);
      CHECK(report.mesh.checksum == whole.mesh.checksum);
      CHECK(report.mesh.bounds == whole.mesh.bounds);
      CHECK((joined.files > 1) == (chunk_points < 1'000'000u));
      CHECK((joined.shared > 0) == (joined.files > 1));
    }
  }
  CHECK(entries_in(scratch.path()) == 2);  // the cloud and the tiles of the last run
}

TEST_CASE("TilesAreTheSameForAnyThreadsAndProcesses", "[slow]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  job.output.tiles = true;
  const auto files = [&] {
    std::map<std::string, std::string> bytes;
    for (const auto& entry : fs::directory_iterator(scratch / "mesh.tiles")) {
      bytes[entry.path().filename().string()] = bytes_of(entry.path());
    }
    return bytes;
  };
  run(job);
  const auto expected = files();
  REQUIRE(expected.size() > 4);
  for (const int threads : {1, 5}) {
    job.run.threads = threads;
    run(job);
    CHECK((files() == expected));
  }
  for (const int members : {2, 3}) {
    run_by_team(job, members);
    CHECK((files() == expected));
  }
}

TEST_CASE("MapTilesHaveEachTriangleOfTheMeshInTheCellOfItsCentroid", "[costly]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  for (const bool fill : {true, false}) {
    Job job = rough_job(scratch, named);
    job.fill.enabled = fill;
    job.run.keep_work_dir = true;
    const RunReport whole = run(job);
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    fs::remove(job.output.mesh);
    job.output.tiles = true;
    for (const double size : {0.5, 64.0}) {  // exact in binary: the test's own floor is exact, too
      INFO("fill " << fill << ", size " << size);
      job.output.tile_size = size;
      const RunReport report = run(job);
      CHECK(report.mesh.checksum == whole.mesh.checksum);
      CHECK(report.mesh.bounds == whole.mesh.bounds);
      const std::size_t tiles = require_map_tiles_of(scratch / "mesh.tiles", mesh, size);
      CHECK(tiles >= 4);  // the torus lies around the origin
      CHECK((tiles == 4) == (size == 64.0));
      CHECK(fs::exists(scratch / "mesh.tiles" / (size == 64.0 ? "-64_0.ply" : "-0.5_0.0.ply")));
    }
  }
}

TEST_CASE("MapTilesAreTheSameForAnyChunksThreadsMemoryAndProcesses", "[slow]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  job.output.tiles = true;
  job.output.tile_size = 0.3;
  const auto files = [&] {
    std::map<std::string, std::string> bytes;
    for (const auto& entry : fs::directory_iterator(scratch / "mesh.tiles"))
      bytes[entry.path().filename().string()] = bytes_of(entry.path());
    return bytes;
  };
  run(job);
  const auto expected = files();
  REQUIRE(expected.size() > 10);
  for (const std::uint64_t chunk_points : {250u, 1500u, 1'000'000u}) {
    job.partition.chunk_points = chunk_points;
    run(job);
    CHECK((files() == expected));
  }
  job.partition.memory_bytes = std::uint64_t{512} << 20;
  for (const int threads : {1, 5}) {
    job.run.threads = threads;
    run(job);
    CHECK((files() == expected));
  }
  run_by_team(job, 2);
  CHECK((files() == expected));
}

TEST_CASE("AnInterruptionBehindTheMeshLeavesItWholeAndSaysSo") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  const std::string expected = test::mesh_bytes(job);
  job.output.picture = scratch / "mesh.png";
  for (const auto& [name_of_stage, leaves_mesh] :
       {std::pair("export", false), std::pair("picture", true)}) {
    const std::string stage = name_of_stage;
    INFO(stage);
    fs::remove(job.output.mesh);
    StopToken stop;
    test::RecordingProgress progress;
    progress.at_stage = [&](const std::string& name) {
      if (name == stage) stop.request();
    };
    bool is_written = false;
    RunWatch watch;
    watch.at_mesh_written = [&] { is_written = true; };
    Communicator alone;
    CHECK_THROWS_AS(run_job(job, {"test"}, progress, stop, alone, &watch), Error);
    CHECK(is_written == leaves_mesh);
    CHECK(fs::exists(job.output.mesh) == leaves_mesh);
    CHECK_FALSE(fs::exists(job.output.picture));
    if (leaves_mesh) CHECK(bytes_of(job.output.mesh) == expected);
    run(job);
    CHECK(bytes_of(job.output.mesh) == expected);
    CHECK(fs::exists(job.output.picture));
    fs::remove(job.output.picture);
  }
}

TEST_CASE("InterruptedMapTilesLeaveNothingAndResume", "[costly]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  job.output.tiles = true;
  job.output.tile_size = 0.5;
  job.run.threads = 1;
  class StopInExport : public test::RecordingProgress {
   public:
    StopInExport(StopToken& stop, int after) : stop_(stop), left_(after) {}
    void begin_stage(const std::string& name, std::uint64_t, const std::string&) override {
      in_export_ = name == "export";
    }
    void advance(std::uint64_t) override {
      if (in_export_ && --left_ == 0) stop_.request();
    }

   private:
    StopToken& stop_;
    int left_;
    bool in_export_ = false;
  };
  const int after = GENERATE(1, 20);  // while the mesh is cut, while tiles are written
  StopToken stop;
  StopInExport progress(stop, after);
  CHECK_THROWS_AS(run_job(job, {"test"}, progress, stop), Error);
  CHECK(entries_in(scratch.path()) == 2);  // the cloud and the work directory
  run(job);
  const std::string resumed = bytes_of(scratch / "mesh.tiles" / "tiles.json");
  fs::remove_all(scratch / "mesh.tiles");
  run(job);
  CHECK(bytes_of(scratch / "mesh.tiles" / "tiles.json") == resumed);  // has all checksums
}

TEST_CASE("MapTilesThatCannotBeNamedAreRefused") {
  ScratchDirectory scratch;
  NamedCloud named = rough_torus(300);
  for (Vec3& position : named.cloud.positions) position = 10.0 * position;
  Job job = job_for(scratch, named);
  for (double& radius : job.reconstruct.ball_radii) radius *= 10.0;
  const auto refusal = [&] {
    try {
      run(job);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kUsage);
      CHECK(error.parts().place == "output.tile_size");
      return std::string(error.what());
    }
    return std::string();
  };
  job.output.tile_size = 500.0;
  CHECK_THAT(refusal(), Catch::Contains("output.tiles = true"));
  test::RecordingProgress progress;
  CHECK_THROWS_WITH(plan_job(job, progress, StopToken()), Catch::Contains("output.tiles = true"));
  CHECK_FALSE(fs::exists(job.run.work_dir));
  job.output.tiles = true;
  job.output.tile_size = 1e-9;
  CHECK_THAT(refusal(), Catch::Contains("too small"));
  CHECK_FALSE(fs::exists(scratch / "mesh.tiles"));
}

TEST_CASE("AJobOfTooManyMapTilesIsRefusedAndGoesOnWithLargerOnes", "[costly]") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, test::noisy_torus(60'000, 0.0, 7));
  job.output.tiles = true;
  job.output.tile_size = 1e-5;  // nearly a tile for each triangle
  try {
    run(job);
    FAIL("written");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    CHECK_THAT(error.what(), Catch::Contains("100,000 tiles"));
  }
  CHECK(entries_in(scratch.path()) == 2);  // the cloud and the work directory
  job.output.tile_size = 1.0;
  const RunReport report = run(job);
  const auto reconstruct =
      std::ranges::find(report.stages, name_of(Stage::kReconstruct), &StageFacts::name);
  REQUIRE(reconstruct != report.stages.end());
  CHECK(reconstruct->chunks_reused == reconstruct->chunks);
}

TEST_CASE("TilesCanBeCompressedText", "[costly]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  run(job);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  job.output.mesh = (scratch / "text.ply.gz").string();
  job.output.binary = false;
  job.output.tiles = true;
  run(job);
  require_same_mesh(join_tiles(scratch / "text.tiles", mesh).mesh, mesh);
}

TEST_CASE("InterruptedTilesLeaveNothingAndResume", "[costly]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  run(job);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  fs::remove(job.output.mesh);
  job.output.tiles = true;
  job.run.keep_work_dir = true;
  run(job);
  fs::rename(scratch / "mesh.tiles", scratch / "finished");
  class StopInExport : public test::RecordingProgress {
   public:
    StopToken* stop = nullptr;
    void begin_stage(const std::string& name, std::uint64_t, const std::string&) override {
      in_export_ = name == "export";
    }
    void advance(std::uint64_t) override {
      if (in_export_) stop->request();
    }

   private:
    bool in_export_ = false;
  };
  job.run.threads = 1;  // more might have begun with all tiles before the first is done
  StopToken stop;
  StopInExport progress;
  progress.stop = &stop;
  CHECK_THROWS_AS(run_job(job, {"test"}, progress, stop), Error);
  CHECK(entries_in(scratch.path()) == 3);  // the cloud, the finished tiles, the work directory
  run(job);
  require_same_mesh(join_tiles(scratch / "mesh.tiles", mesh).mesh, mesh);
}

TEST_CASE("TilesReplaceTilesAndNothingElse", "[costly]") {
  const NamedCloud named = rough_torus();
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  job.output.tiles = true;
  job.partition.chunk_points = 250;
  run(job);
  const std::size_t many = entries_in(scratch / "mesh.tiles");
  job.partition.chunk_points = 1'000'000;
  // What a process that was killed left.
  const fs::path abandoned = scratch / ".mesh.tiles.0123456789abcdef.part";
  const fs::path foreign = scratch / ".mesh.tiles.fedcba9876543210.part";
  {
    ChunkStore store(job.run.work_dir);
    REQUIRE(store.record()->make_directory(abandoned));
    for (const char* name : {"000000.ply", ".000001.ply.0123456789abcdef.part"}) {
      REQUIRE(store.record()->try_create(abandoned / name).valid());
      std::ofstream(abandoned / name) << "half a tile";
    }
  }
  fs::copy(scratch / "mesh.tiles", foreign);
  run(job);
  CHECK(entries_in(scratch / "mesh.tiles") == 2);
  CHECK(many > 2);
  CHECK_FALSE(fs::exists(abandoned));
  CHECK(entries_in(foreign) == many);
  std::ofstream(scratch / "mesh.tiles" / "notes.txt") << "mine";
  try {
    run(job);
    FAIL("replaced");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    CHECK_THAT(error.what(), Catch::Contains("notes.txt"));
  }
  CHECK(bytes_of(scratch / "mesh.tiles" / "notes.txt") == "mine");
}

TEST_CASE("WhatCannotBeTilesIsRefusedBeforeTheWork") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, rough_torus(300));
  job.output.tiles = true;
  for (const std::string& mesh :
       {std::string("-"), (scratch / "mesh.obj").string(), (scratch / "mesh.stl").string()}) {
    job.output.mesh = mesh;
    try {
      run(job);
      FAIL("written");
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kUsage);
    }
    CHECK_FALSE(fs::exists(job.run.work_dir));
  }
}

TEST_CASE("AScansOwnVertexIdsAreKept") {
  NamedCloud named = rough_torus();
  named.cloud.schema.attributes.front().name = "vertex_id";
  ScratchDirectory scratch;
  Job job = rough_job(scratch, named);
  job.output.tiles = true;
  run(job);
  const auto tile = read_mesh(scratch / "mesh.tiles" / "000000.ply").vertices;
  REQUIRE(tile.schema.attributes.size() == 3);
  CHECK(tile.schema.attributes[0].name == "scan_vertex_id");
  CHECK(tile.schema.attributes[2].name == "vertex_id");
}

TEST_CASE("AttributesOfTheProgramDisplaceThoseOfTheScanToNamesThatAreFree") {
  PointSchema schema;
  schema.attributes = {{"id", ScalarType::kInt32}, {"scan_id", ScalarType::kInt32}};
  add_own_attribute(schema, {"id", ScalarType::kUint8});
  REQUIRE(schema.attributes.size() == 3);
  CHECK(schema.attributes[0].name == "scan_id_2");
  CHECK(schema.attributes[1].name == "scan_id");
  CHECK(schema.attributes[2] == AttributeField{"id", ScalarType::kUint8});
}

TEST_CASE("PointsTooManyForTheFormatAreRefusedOnceTheyAreCounted") {
  OutputOptions output;
  output.mesh = "mesh.stl";
  CHECK_NOTHROW(check_format_holds(output, 2'000'000'000));
  CHECK_THROWS_AS(check_format_holds(output, 3'000'000'000), Error);
  output.mesh = "mesh.ply";
  CHECK_NOTHROW(check_format_holds(output, 3'000'000'000'000));
}

}  // namespace orbweave
