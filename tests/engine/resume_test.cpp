// What a second run of a job takes over from the first, what it computes again, and what it says.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/stage/resolved_job.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "io/job/job_file.h"
#include "io/store/chunk_store.h"
#include "io/store/chunk_store_file.h"
#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"
#include "tests/engine/told_jobs.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/raw_scans.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::job_for;
using test::kept_job;
using test::mesh_bytes;
using test::painted_torus;
using test::RecordingProgress;
using test::results_in;
using test::run_told;
using test::run_until;
using test::ScratchDirectory;
using test::Told;
using test::without_work;

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

/// The numbers of the cleaning as a job file writes them, taken out of the job.
std::string take_cleaning(Job& job) {
  std::string lines;
  for (const JobKey& key : job_keys())
    if (std::string_view(key.section) == "cleaning")
      lines += std::string(key.key) + " = " + value_text(key.get(job), key.type) + "\n";
  job.cleaning = {};
  return lines;
}

/// The job with a section of cleaning under that name.
Job with_cleaning(Job job, const std::string& section, const std::string& lines) {
  job.cleaning = parse_job("[" + section + "]\n" + lines, "job.toml").cleaning;
  return job;
}

}  // namespace

TEST_CASE("AChangedChunkSizeIsNamedAndEverythingIsComputedAgain", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  const std::string expected = bytes_of(job.output.mesh);
  job.partition.chunk_points = 600;
  const Told told = run_told(job);
  CHECK(told.again() ==
        "partition.chunk_points changed from 400 to 600: points, mesh and holes are computed "
        "again\n");
  CHECK(told.stage("count") != nullptr);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("ChangedRadiiAreNamedAndThePointsStay", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  job.reconstruct.ball_radii.pop_back();
  const Told told = run_told(job);
  CHECK(told.again().find("reconstruct.ball_radii changed from [") == 0);
  CHECK(told.again().find(": mesh and holes are computed again") != std::string::npos);
  CHECK(told.stage("count") == nullptr);
  CHECK(told.stage("reconstruct")->chunks_reused == 0);
  CHECK((bytes_of(job.output.mesh) == without_work(job)));
}

TEST_CASE("GivenRadiiTakeThePointsThatWereMeasuredForAutomaticOnes", "[costly]") {
  const ScratchDirectory scratch;
  const Job given = kept_job(scratch);
  Job job = given;
  job.reconstruct.ball_radii.clear();
  REQUIRE(run_told(job).stage("count") != nullptr);
  const Told told = run_told(given);
  CHECK(told.again().find("reconstruct.ball_radii changed from [") == 0);
  CHECK(told.again().find(": mesh and holes are computed again") != std::string::npos);
  CHECK(told.stage("count") == nullptr);
  CHECK((bytes_of(given.output.mesh) == without_work(given)));
  CHECK(run_told(job).stage("count") == nullptr);
  CHECK((bytes_of(job.output.mesh) == without_work(job)));
  job.reconstruct.levels = 2;
  CHECK(run_told(job).stage("count") != nullptr);
}

TEST_CASE("RadiiThatAreGivenWhilePointsAreCleanedLeaveThePassesBefore", "[costly]") {
  const ScratchDirectory scratch;
  const Job automatic = test::cleaning_job(scratch, 2500);
  REQUIRE(automatic.reconstruct.ball_radii.empty());
  run_until(automatic, "raw_patches");
  Job given = automatic;
  given.reconstruct.ball_radii = {0.12, 0.2};
  const Told told = run_told(given);
  for (const char* stage :
       {"raw count", "raw_outliers", "raw_normals", "raw_smooth_1", "raw_thinned"}) {
    INFO(stage);
    CHECK(told.stage(stage) == nullptr);
  }
  CHECK(told.again().empty());
  CHECK((bytes_of(given.output.mesh) == without_work(given)));
}

TEST_CASE("OfKeysThatCountForTheFirstTimeThoseThatWereSetAreNamed", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  job.cleaning.outlier_sigma = 4.0;
  CHECK(run_told(job).again() ==
        "cleaning.outlier_sigma is new (4.0): points, mesh and holes are computed again\n");
  job.cleaning.outlier_sigma = 0.0;
  CHECK(run_told(job).again() ==
        "cleaning.outlier_sigma is no longer there: points, mesh and holes are computed again\n");
}

TEST_CASE("AChangedOptionOfTheFillComputesHolesAlone", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  job.fill.max_edges = 3;
  const Told told = run_told(job);
  CHECK(told.again().find("fill.max_edges changed from") == 0);
  CHECK(told.again().find(": holes are computed again") != std::string::npos);
  CHECK(told.stage("count") == nullptr);
  CHECK(told.stage("reconstruct")->chunks_reused == told.stage("reconstruct")->chunks);
  CHECK((bytes_of(job.output.mesh) == without_work(job)));
}

TEST_CASE("TheCheckOfTheSurfaceAloneIsNotThatOfItsPatches", "[costly]") {
  const ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(4000, 2.0, 34));
  job.partition.chunk_points = 1000;
  job.fill.allow_intersections = true;
  job.output.check_surface = true;
  Job open = job;
  open.fill.enabled = false;
  open.run.keep_work_dir = true;
  const auto alone = [](Job of) {
    of.run.work_dir += ".alone";
    of.run.keep_work_dir = false;
    return run_told(of).report.mesh;
  };
  const MeshFacts filled = alone(job);
  REQUIRE(filled.patch_crossing_pairs > 0u);
  run_until(job, "check");
  CHECK(run_told(open).report.mesh.crossing_pairs == alone(open).crossing_pairs);
  const MeshFacts again = run_told(job).report.mesh;
  CHECK(again.patch_crossing_pairs == filled.patch_crossing_pairs);
  CHECK(again.crossing_pairs == filled.crossing_pairs);
}

TEST_CASE("WhatNoResultDependsOnComputesNothingAgain", "[costly]") {
  const ScratchDirectory scratch;
  const Job first = kept_job(scratch);
  const auto check = [](const char* what, const Job& job) {
    INFO(what);
    const Told told = run_told(job);
    CHECK(told.again().empty());
    CHECK(told.stage("count") == nullptr);
    CHECK(told.stage("reconstruct")->chunks_reused == told.stage("reconstruct")->chunks);
  };
  Job job = first;
  job.output.binary = false;
  check("output.format", job);
  job = first;
  job.output.report = (scratch / "report.json").string();
  job.output.picture = (scratch / "mesh.png").string();
  check("output.report and output.picture", job);
  job = first;
  job.run.threads = 1;
  check("run.threads", job);
  job = first;
  job.input.units_per_meter = 1000.0;
  check("input.units_per_meter", job);
  job = first;
  job.reconstruct.levels = 3;
  check("reconstruct.levels, with radii given", job);
  job = first;
  job.normals.neighbors = 20;
  check("normals.neighbors, with normals from the file", job);
  job = first;
  job.partition.memory_bytes *= 2;
  check("more memory", job);
  job.partition.memory_bytes /= 8;
  check("less memory, which the chunks fit", job);
}

TEST_CASE("ASmallerBudgetKeepsChunksThatFitIt") {
  const ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(3000, 0.3, 31));
  job.run.keep_work_dir = true;
  test::run(job);
  const std::string expected = bytes_of(job.output.mesh);
  job.partition.memory_bytes /= 8;
  const Told told = run_told(job);
  CHECK(told.again().empty());
  CHECK(told.stage("count") == nullptr);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("ChunksThatASmallerBudgetHasNoRoomForAreCutAgainAndItSaysSo") {
  const ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(3000, 0.3, 31));
  job.run.keep_work_dir = true;
  // What the job gives is lowered to what the budget has room for, in the first run as in this.
  job.partition.chunk_points = GENERATE(0, 1'000'000'000);
  CAPTURE(job.partition.chunk_points);
  test::run(job);
  const std::string expected = bytes_of(job.output.mesh);
  {
    // As if the last chunk had been cut for a budget that had room for a thousand million points.
    ChunkStore store(job.run.work_dir);
    std::string text = store.document("points", "partition").value();
    const std::size_t end = text.find(']', text.find("\"first_vertex\":["));
    const std::size_t last = text.rfind(',', end) + 1;
    text.replace(last, end - last, "1000000000");
    store.commit_document("points", "partition", text);
  }
  job.partition.memory_bytes /= 4;
  const Told told = run_told(job);
  CHECK(told.again().find("partition.memory changed from \"4GiB\" to \"1GiB\", which chunks of ") ==
        0);
  CHECK(told.again().find("points do not fit: points, mesh and holes are computed again") !=
        std::string::npos);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("AJobWhoseWorkDirectoryCannotBeRemovedIsDoneAndSaysSo") {
  constexpr uid_t kNobody = 65534;
  const ScratchDirectory scratch;
  const fs::path folder = scratch / "folder";
  Job job = job_for(scratch, painted_torus(1500, 0.3, 31));
  job.run.work_dir = (folder / "job.work").string();
  const uid_t user = geteuid();
  RunWatch watch;
  watch.at_outputs_written = [&] {
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      fs::permissions(entry.path(), fs::perms::all);
    constexpr fs::perms kLook = fs::perms(0555);
    fs::permissions(folder, kLook);
    fs::permissions(scratch.path(), kLook | fs::perms::owner_write);
    if (user == 0) REQUIRE(seteuid(kNobody) == 0);
  };
  RecordingProgress progress;
  const StopToken stop;
  Communicator alone;
  CHECK_NOTHROW(run_job(job, {"test"}, progress, stop, alone, &watch));
  REQUIRE(seteuid(user) == 0);
  fs::permissions(folder, fs::perms::owner_all);
  const std::string said = progress.lines.back();
  INFO(said);
  CHECK(said.find("all outputs are written, but ") == 0);
  CHECK(said.find("Permission denied") != std::string::npos);
  CHECK(fs::exists(job.output.mesh));
  CHECK(fs::is_empty(job.run.work_dir));
}

TEST_CASE("RawPointsGoAsSoonAsTheNextPassIsCompleteAndResumingTakesTheLatest", "[costly]") {
  const ScratchDirectory scratch;
  const Job job = test::cleaning_job(scratch, 2500);
  Job undisturbed = job;
  undisturbed.run.work_dir += ".alone";
  undisturbed.output.mesh += ".alone.ply";
  const CleaningFacts cleaning = run_told(undisturbed).report.cleaning;
  const std::string expected = bytes_of(undisturbed.output.mesh);
  const fs::path work = job.run.work_dir;
  run_until(job, "raw_normals");
  CHECK(results_in(work / "raw") == 0);
  CHECK(results_in(work / "raw_outliers") > 3);
  run_until(job, "raw_patches");
  CHECK(results_in(work / "raw_outliers") == 0);
  CHECK(results_in(work / "raw_normals") == 0);
  CHECK(results_in(work / "raw_smooth_1") == 0);
  CHECK(results_in(work / "raw_thinned") > 3);
  const Told told = run_told(job);
  for (const char* stage :
       {"raw count", "raw_outliers", "raw_normals", "raw_smooth_1", "raw_thinned"}) {
    INFO(stage);
    CHECK(told.stage(stage) == nullptr);
  }
  CHECK(told.stage("raw_patches") != nullptr);
  CHECK(told.again().empty());
  CHECK(told.report.cleaning.points_moved > 0);
  CHECK(told.report.cleaning.points_moved == cleaning.points_moved);
  CHECK(told.report.cleaning.mean_move == cleaning.mean_move);
  CHECK(told.report.points_dropped.contains("thinned"));
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("KilledBetweenTheEndOfAPassAndTheRemovalOfItsSourceMakesNoDifference", "[costly]") {
  const ScratchDirectory scratch;
  const Job job = test::cleaning_job(scratch, 2500);
  const std::string expected = without_work(job);
  const fs::path work = job.run.work_dir;
  run_until(job, "raw_outliers");
  fs::copy(work / "raw", scratch / "raw");
  run_until(job, "raw_normals");
  REQUIRE(results_in(work / "raw") == 0);
  fs::remove_all(work / "raw");
  fs::copy(scratch / "raw", work / "raw");
  run_until(job, "raw_smooth_1");
  CHECK(results_in(work / "raw") == 0);
  CHECK((mesh_bytes(job) == expected));
}

TEST_CASE("AWorkDirectoryGoesOnUnderEitherNameOfTheCleaningSection", "[costly]") {
  const ScratchDirectory scratch;
  Job plain = test::cleaning_job(scratch, 1500);
  const std::string numbers = take_cleaning(plain);
  const auto [before, after] =
      GENERATE(std::pair("prepare", "cleaning"), std::pair("cleaning", "prepare"));
  CAPTURE(before, after);
  run_until(with_cleaning(plain, before, numbers), "raw_thinned");
  const Told told = run_told(with_cleaning(plain, after, numbers));
  CHECK(told.again().empty());
  CHECK(told.stage("raw_normals") == nullptr);
  CHECK(told.stage("raw_thinned") != nullptr);
}

TEST_CASE("StoredKeysKeepTheFirstNameOfTheCleaningSection") {
  const ScratchDirectory scratch;
  const Job job = test::cleaning_job(scratch, 500);
  const std::string key = points_key(resolve(job, job.input.files));
  CHECK(key.find("\nprepare.thin_to_spacing = ") != std::string::npos);
  CHECK(key.find("cleaning.") == std::string::npos);
}

TEST_CASE("AChangedPassIsRunAgainOnWhatIsThereAndOtherwiseFromTheScans", "[costly]") {
  const ScratchDirectory scratch;
  const Job first = test::cleaning_job(scratch, 2500);
  run_until(first, "raw_patches");  // the thinned points are complete
  Job job = first;
  job.cleaning.thin_to_spacing *= 1.5;
  const Told told = run_told(job);
  CHECK(told.again().find("cleaning.thin_to_spacing changed from") == 0);
  CHECK(told.again().find("thinned points") != std::string::npos);
  CHECK(told.stage("raw count") != nullptr);  // what thinning was made from had gone
  CHECK((bytes_of(job.output.mesh) == without_work(job)));

  run_until(first, "raw_thinned");
  const Told kept = run_told(job);
  CHECK(kept.stage("raw count") == nullptr);
  CHECK((bytes_of(job.output.mesh) == without_work(job)));
}

TEST_CASE("PassesThatAreNoLongerTheLastAreNoDamage", "[costly]") {
  const ScratchDirectory scratch;
  Job before = test::cleaning_job(scratch, 2500);
  before.cleaning.thin_to_spacing = 0.0;
  Job after = before;
  const auto [had, has] = GENERATE(std::pair(3, 2), std::pair(2, 3), std::pair(2, 1));
  CAPTURE(had, has);
  before.cleaning.smooth_passes = had;
  after.cleaning.smooth_passes = has;
  // The last pass is complete, or was still at work.
  const std::string stage = GENERATE(as<std::string>(), "raw_patches", "raw_smooth_2");
  run_until(before, stage);
  const Told told = run_told(after);
  CHECK(told.says("damaged").empty());
  const std::string bytes = bytes_of(after.output.mesh);
  after.run.work_dir += ".alone";
  const CleaningFacts alone = run_told(after).report.cleaning;
  CHECK(told.report.cleaning.points_moved == alone.points_moved);
  CHECK(told.report.cleaning.mean_move == alone.mean_move);
  CHECK((bytes_of(after.output.mesh) == bytes));
}

TEST_CASE("PointsOfAPassThatALaterOneHasUsedUpAreReadAgain", "[costly]") {
  const ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(2500, 0.3, 31));
  job.cleaning.outlier_sigma = 4.0;
  job.cleaning.merge_tolerance = 0.01;
  run_until(job, "count");
  job.cleaning.merge_tolerance = 0.0;
  const Told told = run_told(job);
  CHECK(told.says("damaged").empty());
  CHECK_FALSE(told.says("the raw points are read again").empty());
  CHECK((bytes_of(job.output.mesh) == without_work(job)));
}

TEST_CASE("APassThatIsNewNamesTheKeyThatAsksForIt", "[costly]") {
  const ScratchDirectory scratch;
  Job job = test::cleaning_job(scratch, 2500);
  job.cleaning = {};
  run_until(job, "raw_patches");
  job.cleaning.outlier_sigma = 6.0;
  CHECK(run_told(job).again() ==
        "cleaning.outlier_sigma changed from 0.0 to 6.0: normals are computed again\n");
  CHECK((bytes_of(job.output.mesh) == without_work(job)));
}

TEST_CASE("WhatAPowerCutLeavesResumesToTheSameBytes", "[costly]") {
  const ScratchDirectory scratch;
  const Job job = [&] {
    Job made = kept_job(scratch);
    made.run.keep_work_dir = false;
    return made;
  }();
  const std::string expected = bytes_of(job.output.mesh);
  const fs::path work = job.run.work_dir;
  fs::copy(work, scratch / "whole", fs::copy_options::recursive);
  const auto cut = [&](const fs::path& file, double share) {
    fs::resize_file(file, static_cast<std::uintmax_t>(share * double(fs::file_size(file))));
  };
  const auto unnamed = [](const fs::path& file) {
    fs::rename(file, file.parent_path() / ("." + file.filename().string() + ".part"));
  };
  const std::vector<std::pair<const char*, std::function<void()>>> cuts = {
      {"results without their bytes",
       [&] {
         for (const char* c : {"000001", "000004"})
           cut(work / "mesh" / (c + std::string(".h5")), 0.0);
       }},
      {"half a result", [&] { cut(work / "mesh" / "000002.h5", 0.5); }},
      {"names that are gone", [&] { fs::remove(work / "mesh" / "000003.h5"); }},
      {"renames that are gone", [&] { unnamed(work / "mesh" / "000003.h5"); }},
      {"a key without its bytes", [&] { cut(work / "mesh" / "key.json", 0.0); }},
      {"half a key", [&] { cut(work / "points" / "key.json", 0.5); }},
      {"half a partition", [&] { cut(work / "points" / "partition.json", 0.5); }},
      {"a partition without its checksum",
       [&] { fs::remove(work / "points" / "partition.json.xxh3"); }},
      {"points without their bytes", [&] { cut(work / "points" / "000002.h5", 0.0); }},
      {"a stage that is gone", [&] { fs::remove_all(work / "mesh"); }},
      {"half the word that the job has ended", [&] { cut(work / "ended.json", 0.5); }},
  };
  for (const auto& [what, damage] : cuts) {
    INFO(what);
    fs::remove_all(work);
    fs::copy(scratch / "whole", work, fs::copy_options::recursive);
    damage();
    fs::remove(job.output.mesh);  // what has ended would be left alone
    REQUIRE((mesh_bytes(job) == expected));
    CHECK_FALSE(fs::exists(work));
  }
}

TEST_CASE("ARemovalThatWasCutShortIsFinishedAndTheJobIsNotRunAgain", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  const auto written = fs::last_write_time(job.output.mesh);
  const fs::path work = job.run.work_dir;
  job.run.keep_work_dir = false;
  SECTION("with results left") { fs::remove_all(work / "points"); }
  SECTION("with little left") {
    for (const char* name : {"points", "mesh", "stitch", "holes", "orbweave.log",
                             "orbweave-steps.jsonl", "orbweave-store.json"})
      fs::remove_all(work / name);
  }
  const RunReport report = test::run(job);
  CHECK(report.ended_before);
  CHECK_FALSE(fs::exists(work));
  CHECK(fs::last_write_time(job.output.mesh) == written);
  // From here on it is a new job.
  CHECK_FALSE(test::run(job).ended_before);
}

TEST_CASE("AJobThatHasEndedIsRunAgainWhereItsOutputOrItsOptionsChanged", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  const std::string expected = bytes_of(job.output.mesh);
  job.run.keep_work_dir = false;
  SECTION("the mesh is gone") { fs::remove(job.output.mesh); }
  SECTION("the mesh is another") { std::ofstream(job.output.mesh) << "ply\n"; }
  SECTION("an option changed") { job.fill.max_edges = 3; }
  CHECK_FALSE(test::run(job).ended_before);
  if (job.fill.max_edges == 0) CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("AJobThatHasEndedIsRunAgainWhereATileOrThePageOfItsReportIsGone", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  job.output.tiles = true;
  job.output.report = (scratch / "report.json").string();
  test::run(job);
  job.run.keep_work_dir = false;
  const fs::path tile = fs::path(job.output.mesh).replace_extension(".tiles") / "000001.ply";
  const fs::path page = scratch / "report.html";
  bool is_whole = false;
  SECTION("nothing is gone") { is_whole = true; }
  SECTION("a tile is gone") { REQUIRE(fs::remove(tile)); }
  SECTION("the page is gone") { REQUIRE(fs::remove(page)); }
  CHECK(test::run(job).ended_before == is_whole);
  CHECK(fs::exists(tile));
  CHECK(fs::exists(page));
}

TEST_CASE("WhatAKilledWriterLeftBesideTheOutputsGoesByItsRecordAndWhatOthersWriteStays") {
  const ScratchDirectory scratch;
  const Job job = job_for(scratch, painted_torus(3000, 0.2, 33));
  const fs::path left = scratch / ".mesh.ply.0123456789abcdef.part";
  const fs::path replaced = scratch / ".mesh.ply.1123456789abcdef.part";
  const fs::path written = scratch / ".mesh.ply.fedcba9876543210.part";
  const fs::path other = scratch / ".mesh-of-mine.ply.0123456789abcdef.part";
  {
    ChunkStore store(job.run.work_dir);
    const FileDescriptor kept_open = store.record()->try_create(replaced);
    REQUIRE(kept_open.valid());
    REQUIRE(store.record()->try_create(left).valid());
    fs::rename(replaced, scratch / "elsewhere");  // its inode is not given away again
  }
  for (const fs::path& path : {left, replaced, written, other})
    std::ofstream(path) << "half a mesh";
  test::run(job);
  CHECK_FALSE(fs::exists(left));
  CHECK(bytes_of(replaced) == "half a mesh");  // another file of that name
  CHECK(bytes_of(written) == "half a mesh");
  CHECK(bytes_of(other) == "half a mesh");
}

TEST_CASE("FreshTakesNothingOver", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  job.run.fresh = true;
  const Told told = run_told(job);
  CHECK(told.stage("count") != nullptr);
  CHECK(told.stage("reconstruct")->chunks_reused == 0);
}

}  // namespace orbweave
