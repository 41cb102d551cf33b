// The table of stages, and what is known of a job once it is resolved.
#include "engine/pipeline/stage/stages.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "engine/pipeline/damage_repair.h"
#include "engine/pipeline/stage/resolved_job.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "tests/support/jobs.h"

using namespace orbweave;
using namespace orbweave::test;
namespace fs = std::filesystem;

namespace {

using Names = std::vector<std::string>;

Names stages_in(const fs::path& work) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(work))
    if (entry.is_directory()) names.insert(entry.path().filename().string());
  return {names.begin(), names.end()};
}

}  // namespace

TEST_CASE("AStageWhoseKeyChangedTakesTheLaterOnesOfItsLineWithIt") {
  CHECK(directories_from("points") == Names{"points", "cells", "power_crust", "mesh", "stitch",
                                            "holes", "crossings", "settled", "tileset",
                                            "simplify"});
  CHECK(directories_from("stitch") ==
        Names{"stitch", "holes", "crossings", "settled", "tileset", "simplify"});
  CHECK(directories_from("raw_thinned") == Names{"raw_thinned", "raw_patches", "raw_turns"});
  const Names smoothed = directories_from("raw_smooth_7");
  CHECK(smoothed ==
        Names{"raw_smooth_7", "raw_smooth_8", "raw_thinned", "raw_patches", "raw_turns"});
  CHECK(directories_from("tiles").empty());
}

TEST_CASE("EveryDirectoryBelongsToOneStage") {
  for (const StageInfo& info : kStages) {
    if (*info.directory == '\0') continue;
    const std::string directory =
        info.repeats == 1 ? info.directory : directory_of(info.stage, info.repeats);
    INFO(directory);
    REQUIRE(stage_in(directory) != nullptr);
    CHECK(stage_in(directory)->line == info.line);
    CHECK(stage_in(directory)->repair == info.repair);
  }
  CHECK(stage_in("raw_smooth_9") == nullptr);
  CHECK(stage_in("raw_smooth") == nullptr);
  CHECK(stage_in("") == nullptr);
}

TEST_CASE("FreshDropsWhatStagesStoreButOutputsOnTheirWay") {
  const Names dropped = directories_dropped_by_fresh();
  CHECK(dropped.front() == "raw_cut");
  CHECK(std::set<std::string>(dropped.begin(), dropped.end()).size() == dropped.size());
  for (const char* directory :
       {"raw", "raw_smooth_1", "points_cut", "points", "mesh", "holes", "tileset", "simplify"})
    CHECK(std::count(dropped.begin(), dropped.end(), directory) == 1);
  for (const char* directory : {"export", "tiles"})
    CHECK(std::count(dropped.begin(), dropped.end(), directory) == 0);
}

TEST_CASE("DamageRemovesAsMuchAsTheTableSays") {
  const ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  for (const char* stage : {"points", "points_cut", "mesh", "stitch", "raw", "raw_cut"})
    store.begin_stage(stage, "key");
  SECTION("a stitched mesh goes alone") {
    drop_damaged(store, scratch / "work" / "stitch" / "000000.h5");
    CHECK(stages_in(scratch / "work") == Names{"mesh", "points", "points_cut", "raw", "raw_cut"});
  }
  SECTION("points go with their bins") {
    drop_damaged(store, scratch / "work" / "points" / "000000.h5");
    CHECK(stages_in(scratch / "work") == Names{"mesh", "raw", "raw_cut", "stitch"});
  }
  SECTION("raw points go with all passes over them") {
    drop_damaged(store, scratch / "work" / "raw" / "000000.h5");
    CHECK(stages_in(scratch / "work") == Names{"mesh", "points", "points_cut", "stitch"});
  }
  SECTION("a chunk's mesh goes alone") {
    drop_damaged(store, scratch / "work" / "mesh" / "000000.h5");
    CHECK(store.has_key("mesh", "key"));
  }
}

TEST_CASE("WhatFollowsFromAResolvedJobNeedsNoFile") {
  const ScratchDirectory scratch;
  NamedCloud named = painted_torus(500, 0.0, 3);
  named.cloud.normals.clear();
  named.cloud.schema.has_normals = false;
  const Job job = job_for(scratch, named);
  const ResolvedJob resolved = resolve(job, job.input.files);
  CHECK(resolved.estimates_normals);
  CHECK(resolved.needs_cleaning_or_normals());
  CHECK(resolved.orientation_rule(0) == Orientation::kScanner);
  CHECK(resolved.orientation_rule(1) == Orientation::kPropagate);
  const std::string key = points_key(resolved), raw = raw_points_key(resolved);
  for (const std::string& file : job.input.files) fs::remove(file);
  CHECK(points_key(resolved) == key);
  CHECK(raw_points_key(resolved) == raw);
  CHECK(trusted_files(resolved).size() == job.input.files.size());
}

TEST_CASE("AScanThatChangedWhileTheMeshWasMadeIsReadAgainByTheNextRun") {
  const ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(1000, 0.0, 5));
  job.run.keep_work_dir = true;
  RecordingProgress progress;
  progress.at_stage = [&](const std::string& stage) {
    if (stage != "export") return;
    for (const std::string& file : job.input.files)
      fs::last_write_time(file, fs::last_write_time(file) + std::chrono::hours(1));
  };
  run_job(job, {"test"}, progress, StopToken());
  job.run.keep_work_dir = false;
  CHECK_FALSE(test::run(job).ended_before);
}
