// The tileset of a job: that of its mesh file, however the job was cut and interrupted.
#include "engine/pipeline/output/tileset_stage.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "engine/levels/tileset.h"
#include "engine/levels/tileset_work.h"
#include "engine/pipeline/output/mesh_for_levels.h"
#include "engine/pipeline/pipeline.h"
#include "io/error.h"
#include "io/meshes/mesh_stream.h"
#include "tests/support/jobs.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using Catch::Matchers::Contains;
using test::bytes_of;
using test::job_for;
using test::NamedCloud;
using test::RecordingProgress;
using test::run;
using test::ScratchDirectory;

using FilesOfFolder = std::map<std::string, std::string>;

FilesOfFolder files_in(const fs::path& folder) {
  FilesOfFolder files;
  for (const auto& entry : fs::directory_iterator(folder))
    files[entry.path().filename().string()] = bytes_of(entry.path());
  return files;
}

Job tileset_job(const ScratchDirectory& scratch, const NamedCloud& named) {
  Job job = job_for(scratch, named);
  job.output.tileset = (scratch / "levels").string();
  job.output.picture_up = UpAxis::kY;
  return job;
}

/// The tileset of a mesh file, made by itself.
FilesOfFolder tileset_of(const ScratchDirectory& scratch, const Job& job) {
  TilesetOptions options;
  options.compression = job.output.tileset_compression;
  options.up_axis = 1;
  options.levels.directory = scratch / "alone.work";
  const TilesetWork work(options.levels.directory);
  const StopToken stop;
  write_tileset(*open_mesh_stream(job.output.mesh), scratch / "alone", options, {}, stop);
  return files_in(scratch / "alone");
}

void check_any_cut(std::size_t points, std::uint64_t small_chunks, std::size_t least_files,
                   TileCompression compression = TileCompression::kNone) {
  const NamedCloud named = test::noisy_torus(points, 0.0, 7);
  FilesOfFolder first;
  for (const std::uint64_t chunk_points : {small_chunks, std::uint64_t{1'000'000}}) {
    const ScratchDirectory scratch;
    Job job = tileset_job(scratch, named);
    job.output.tileset_compression = compression;
    job.partition.chunk_points = chunk_points;
    job.run.threads = chunk_points == small_chunks ? 1 : 2;
    const RunReport report = run(job);
    const FilesOfFolder files = files_in(job.output.tileset);
    CHECK(files.size() >= least_files);
    CHECK(files.contains(kTilesetName));
    CHECK(files == tileset_of(scratch, job));
    CHECK(report.stages.back().name == "tileset");
    CHECK(report.stages.back().bytes_written > 0);
    if (!first.empty()) CHECK(files == first);
    first = files;
  }
}

/// What becomes of the job where the mesh file is changed by `change` as soon as it is there.
void check_changed_mesh(const Job& job, const std::string& expected,
                        const std::function<void()>& change) {
  RunWatch watch;
  watch.at_mesh_written = change;
  RecordingProgress progress;
  const StopToken stop;
  Communicator alone;
  try {
    run_job(job, {"test"}, progress, stop, alone, &watch);
    FAIL("nobody noticed");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kResource);
    CHECK(error.parts().file == job.output.mesh);
    CHECK(error.problem().find("the mesh changed before") == 0);
  }
  CHECK(fs::exists(job.run.work_dir));
  run(job);
  CHECK(bytes_of(job.output.mesh) == expected);
}

void check_refused(const Job& job, const std::string& found) {
  INFO(job.output.mesh);
  try {
    check_tileset(job);
    FAIL("the tileset was not refused");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    CHECK_THAT(error.what(), Contains("output.tileset") && Contains(found));
  }
}

TEST_CASE("NothingIsMadeOfAMeshFileThatIsGoneBeforeItIsLookedAt") {
  const ScratchDirectory scratch;
  const std::string mesh = (scratch / "mesh.ply").string();
  const MeshFileState written = state_of_mesh_file(mesh);
  CHECK(written.content.empty());
  try {
    make_of_mesh_file(mesh, written, [] { FAIL("made of nothing"); });
    FAIL("nobody noticed");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kResource);
    CHECK(error.parts().found == "no such file");
  }
}

TEST_CASE("TwoCommandsThatMakeTheSameTilesetDoNotTakeEachOthersFiles") {
  const ScratchDirectory scratch;
  const fs::path directory = scratch / "tiles.work";
  {
    const TilesetWork first(directory);
    try {
      const TilesetWork second(directory);
      FAIL("both are at work");
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kResource);
      CHECK(error.problem() == "the work directory is in use by another process");
    }
    CHECK(fs::exists(directory / (std::string(kRecordName) + "0")));
  }
  CHECK_FALSE(fs::exists(directory));
  const TilesetWork next(directory);
}

TEST_CASE("StatusSaysThatATilesetIsDoneWhileTheMeshIsSimplified") {
  const ScratchDirectory scratch;
  Job job = tileset_job(scratch, test::noisy_torus(2000, 0.0, 7));
  job.output.simplify = SimplifyTarget{SimplifyTarget::Kind::kRatio, 0.5};
  for (const std::string at : {"tileset", "simplify"}) {
    INFO(at);
    StopToken stop;
    RecordingProgress progress;
    progress.at_stage = [&](const std::string& name) {
      if (name == at) stop.request();
    };
    CHECK_THROWS_AS(run_job(job, {"test"}, progress, stop), Error);
    const WorkStatus status = work_status(job.run.work_dir);
    const bool is_behind = at == "simplify";
    CHECK(fs::exists(job.output.tileset) == is_behind);
    const auto tileset = std::ranges::find(status.stages, "tileset", &StageStatus::name);
    CHECK((tileset != status.stages.end() && tileset->done) == is_behind);
  }
}

TEST_CASE("NothingIsMadeOfAMeshFileThatIsMovedOrReplacedMeanwhileAndTheWorkIsKept") {
  const ScratchDirectory scratch;
  Job job = tileset_job(scratch, test::noisy_torus(2000, 0.0, 7));
  job.output.simplify = SimplifyTarget{SimplifyTarget::Kind::kRatio, 0.5};
  run(job);
  const std::string expected = bytes_of(job.output.mesh);
  const FilesOfFolder tiles = files_in(job.output.tileset);
  const fs::path elsewhere = scratch / "elsewhere.ply";
  const auto move = [&] { fs::rename(job.output.mesh, elsewhere); };
  check_changed_mesh(job, expected, move);
  CHECK(bytes_of(elsewhere) == expected);
  check_changed_mesh(job, expected, [&] {
    fs::copy_file(job.input.files.front(), job.output.mesh, fs::copy_options::overwrite_existing);
  });
  check_changed_mesh(job, expected, [&] { fs::resize_file(job.output.mesh, 1000); });
  job.output.tileset.clear();
  check_changed_mesh(job, expected, move);
  CHECK(files_in(scratch / "levels") == tiles);
}

TEST_CASE("TilesetOfAJobIsThatOfItsMeshFileInAnyCut") { check_any_cut(1500, 300, 3); }

TEST_CASE("CompressedTilesetOfAJobIsThatOfItsMeshFileInAnyCut") {
  check_any_cut(1500, 300, 3, TileCompression::kMeshopt);
}

TEST_CASE("TilesetOfSeveralLevelsIsThatOfItsMeshFileInAnyCut", "[costly]") {
  check_any_cut(40'000, 6000, 5);
}

TEST_CASE("TilesetOfAMeshWithAnOriginIsThatOfItsMeshFile") {
  NamedCloud far = test::noisy_torus(1500, 0.0, 7);
  for (Vec3& p : far.cloud.positions) p = p + Vec3{4.1e5, 5.2e6, 100.0};
  const ScratchDirectory scratch;
  Job job = tileset_job(scratch, far);
  job.output.float_positions = true;
  const RunReport report = run(job);
  REQUIRE(report.origin != Vec3{});
  CHECK(files_in(job.output.tileset) == tileset_of(scratch, job));
}

TEST_CASE("TilesetThatIsMissingIsMadeByTheNextRun") {
  const ScratchDirectory scratch;
  Job job = tileset_job(scratch, test::noisy_torus(1500, 0.0, 7));
  RecordingProgress progress;
  StopToken stop;
  progress.at_stage = [&](const std::string& stage) {
    if (stage == "tileset") stop.request();
  };
  CHECK_THROWS_AS(run_job(job, {"test"}, progress, stop), Error);
  REQUIRE(progress.stages.back() == "tileset");
  CHECK_FALSE(fs::exists(job.output.tileset));
  const std::string mesh = bytes_of(job.output.mesh);
  CHECK_FALSE(run(job).ended_before);
  CHECK(bytes_of(job.output.mesh) == mesh);
  const FilesOfFolder files = files_in(job.output.tileset);
  job.run.keep_work_dir = true;
  run(job);  // replaces its own
  CHECK(files_in(job.output.tileset) == files);
  fs::remove_all(job.output.tileset);
  run(job);
  CHECK(files_in(job.output.tileset) == files);
}

TEST_CASE("TilesetIsRefusedWhereTheMeshCannotBeReadAgain") {
  Job job;
  job.output.tileset = "levels";
  for (const char* mesh : {"a.stl", "a.obj", "a.glb", "a.ply.gz"}) {
    job.output.mesh = mesh;
    check_refused(job, mesh);
  }
  job.output.mesh = "-";
  check_refused(job, "standard output");
  job.output.mesh = "a.ply";
  CHECK_NOTHROW(check_tileset(job));
  job.partition.memory_bytes = std::uint64_t{100} << 20;
  check_refused(job, "at least 168");
  job.output.tiles = true;
  check_refused(job, "output.tiles = true");
}

TEST_CASE("TilesetThatIsNamedAsTilesWouldBeIsKept") {
  const ScratchDirectory scratch;
  Job job = tileset_job(scratch, test::noisy_torus(500, 0.0, 7));
  job.output.tileset = fs::path(job.output.mesh).replace_extension(".tiles").string();
  for (int time = 0; time < 2; ++time) {
    for (const std::string& note : run(job).notes) CHECK_THAT(note, !Contains("earlier run"));
    CHECK(fs::exists(fs::path(job.output.tileset) / "tileset.json"));
  }
}

TEST_CASE("TilesetOfAJobLeavesOtherFoldersAlone") {
  const ScratchDirectory scratch;
  Job job = tileset_job(scratch, test::noisy_torus(500, 0.0, 7));
  fs::create_directory(job.output.tileset);
  test::write_text(fs::path(job.output.tileset) / "notes.txt", "mine");
  CHECK_THROWS_WITH(run(job), Contains("notes.txt"));
  CHECK(bytes_of(fs::path(job.output.tileset) / "notes.txt") == "mine");
  CHECK_FALSE(fs::exists(job.output.mesh));
  const Job same = [&] {
    Job changed = job;
    changed.output.tileset = (fs::path(job.input.files.front()).parent_path()).string();
    return changed;
  }();
  CHECK_THROWS_AS(run(same), Error);
}

}  // namespace
}  // namespace orbweave
