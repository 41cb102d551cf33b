// What a second run says of the room that it takes, and what it removes of the first.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "engine/pipeline/pipeline.h"
#include "io/store/chunk_store.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::job_for;
using test::painted_torus;
using test::run;
using test::ScratchDirectory;

}  // namespace

TEST_CASE("AResumedRunPredictsTheDiskThatItTakes") {
  const ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(4000, 0.0, 1));
  job.run.keep_work_dir = true;
  run(job);
  fs::remove(job.output.mesh);
  const RunReport resumed = run(job);
  REQUIRE(resumed.stages.front().name == "reconstruct");
  CHECK(resumed.predicted.disk_bytes >= resumed.measured.disk_bytes);
  CHECK(resumed.predicted.disk_bytes <= 2 * resumed.measured.disk_bytes);
}

TEST_CASE("BinsThatAreOfNoUseGoWithTheNextRun") {
  const ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(1000, 0.0, 1));
  job.run.keep_work_dir = true;
  job.run.work_dir = (scratch / "work").string();
  const fs::path left = scratch / "work/points_cut";
  {
    ChunkStore store(job.run.work_dir);
    store.begin_stage("points_cut", "of other points");
    REQUIRE(store.claim(left / "bins.1"));
    std::ofstream(left / "bins.1") << "points";
  }
  run(job);
  CHECK(fs::exists(scratch / "work/points"));
  CHECK_FALSE(fs::exists(left));
}

}  // namespace orbweave
