// Whatever lies in the place of a stored file, the job ends with its own mesh, or says what is in
// its way and leaves it there. ORBWEAVE_DAMAGES sets how many damages are tried per
// stage, ORBWEAVE_DAMAGE_SEED which.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "engine/pipeline/pipeline.h"
#include "io/error.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/program.h"
#include "tests/support/raw_scans.h"
#include "tests/support/stored_damage.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::kStoredDamages;
using test::mesh_bytes;
using test::RecordingProgress;
using test::run_until;
using test::ScratchDirectory;
using test::StoredDamage;
using test::StoredDirectories;

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

void copy_tree(const fs::path& from, const fs::path& to) {
  fs::remove_all(to);
  fs::copy(from, to, fs::copy_options::recursive);
}

std::uint64_t number_from(const char* variable, std::uint64_t usual) {
  const char* wanted = std::getenv(variable);
  return wanted == nullptr ? usual : std::strtoull(wanted, nullptr, 10);
}

/// Runs a damaged job to its end. Only a directory may be in its way, is named then, and stays.
std::string bytes_in_the_end(const Job& job, const fs::path& damaged, StoredDamage damage) {
  try {
    return mesh_bytes(job);
  } catch (const Error& error) {
    INFO(error.what());
    REQUIRE(damage == StoredDamage::kDirectory);
    REQUIRE(error.kind() == ErrorKind::kUsage);
    REQUIRE(std::string(error.what()).find(damaged.string()) != std::string::npos);
    REQUIRE_FALSE(fs::exists(job.output.mesh));
  }
  REQUIRE(test::file_text(damaged / test::kUsersFile) == "of the user");
  fs::remove_all(damaged);
  return mesh_bytes(job);
}

/// A job that was stopped, with what may come in place of its files.
class StoppedJob {
 public:
  /// `before` are other options under which the job was run before, in the same directory.
  StoppedJob(const ScratchDirectory& scratch, const Job& before, const Job& job,
             const std::string& stage)
      : job_(job), whole_(scratch / "whole") {
    fs::remove_all(job.run.work_dir);
    run_until(before, stage);
    copy_tree(job.run.work_dir, scratch / "older");
    run_until(job, stage);
    copy_tree(job.run.work_dir, whole_);
    Job other = job;
    other.run.work_dir = (scratch / "other").string();
    fs::remove_all(other.run.work_dir);
    run_until(other, stage);
    directories_ = {job.run.work_dir, scratch / "older", scratch / "other"};
  }

  std::vector<fs::path> files() const { return test::stored_files(whole_); }

  /// False where the damage does not apply to the file.
  bool damage_and_resume(const fs::path& file, StoredDamage damage, std::mt19937_64& random,
                         const std::string& expected) {
    copy_tree(whole_, job_.run.work_dir);
    fs::remove(job_.output.mesh);
    if (!test::apply(damage, file, directories_, random)) return false;
    INFO(test::name_of(damage) << " " << file);
    const bool same = bytes_in_the_end(job_, job_.run.work_dir / file, damage) == expected;
    REQUIRE(same);
    return true;
  }

 private:
  Job job_;
  fs::path whole_;
  StoredDirectories directories_;
};

/// Tries `count` damages, every kind in turn, on files drawn from all.
void damage_at_random(StoppedJob& stopped, std::size_t count, std::mt19937_64& random,
                      const std::string& expected) {
  const std::vector<fs::path> files = stopped.files();
  REQUIRE(files.size() > 5);
  std::size_t done = 0;
  for (std::size_t trial = 0; done < count && trial < 20 * count; ++trial) {
    const StoredDamage damage = kStoredDamages[trial % kStoredDamages.size()];
    const fs::path& file = files[random() % files.size()];
    done += stopped.damage_and_resume(file, damage, random, expected) ? 1 : 0;
  }
  CHECK(done == count);
}

Job raw_job(const ScratchDirectory& scratch) {
  Job job = test::cleaning_job(scratch, 1000);
  job.partition.chunk_points = 250;
  return job;
}

}  // namespace

TEST_CASE("WhateverTakesThePlaceOfAStoredFileTheMeshIsTheSame", "[slow]") {
  const ScratchDirectory scratch;
  const Job job = raw_job(scratch);
  const std::string expected = mesh_bytes(job);
  std::mt19937_64 random(number_from("ORBWEAVE_DAMAGE_SEED", 19));
  for (const char* stage :
       {"raw_outliers", "raw_smooth_1", "raw_patches", "sort", "stitch", "holes", "export"}) {
    INFO(stage);
    Job before = job;
    if (std::string(stage).starts_with("raw"))
      before.cleaning.outlier_sigma *= 1.5;
    else
      before.reconstruct.levels = 1;
    StoppedJob stopped(scratch, before, job, stage);
    damage_at_random(stopped, number_from("ORBWEAVE_DAMAGES", 4), random, expected);
  }
}

TEST_CASE("TheNextRunSaysWhoseResultLiesInPlaceOfAnother") {
  const ScratchDirectory scratch;
  const Job job = raw_job(scratch);
  const std::string expected = mesh_bytes(job);
  const fs::path work = job.run.work_dir;
  const auto exchange = [&](const std::string& stage) {
    fs::rename(work / stage / "000001.h5", work / "aside");
    fs::rename(work / stage / "000003.h5", work / stage / "000001.h5");
    fs::rename(work / "aside", work / stage / "000003.h5");
  };
  const auto told = [&] {
    RecordingProgress progress;
    const StopToken stop;
    run_job(job, {"test"}, progress, stop);
    std::string lines;
    for (const std::string& line : progress.lines) lines += line + "\n";
    return lines;
  };
  run_until(job, "raw_smooth_1");
  exchange("raw_normals");
  CHECK(told().find("found the result of chunk 3 of stage raw_normals. The same command computes "
                    "it again; computing it again\n") != std::string::npos);
  CHECK((bytes_of(job.output.mesh) == expected));

  fs::remove(job.output.mesh);
  run_until(job, "stitch");
  exchange("mesh");
  CHECK(told().find("found the result of chunk 3 of stage mesh") != std::string::npos);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("AllResultsOfAStageMayComeFromElsewhere", "[soak]") {
  const ScratchDirectory scratch;
  Job job = raw_job(scratch);
  job.partition.chunk_points = 100;
  const std::string expected = mesh_bytes(job);
  Job other = job;
  other.run.work_dir += ".other";
  run_until(other, "stitch");
  run_until(job, "stitch");
  const fs::path work = job.run.work_dir;
  const std::size_t results = test::results_in(work / "mesh");
  REQUIRE(results > 9);  // more than damages that are repaired one by one
  SECTION("copied over those of the job") {
    for (const auto& entry : fs::directory_iterator(fs::path(other.run.work_dir) / "mesh"))
      if (entry.path().extension() == ".h5")
        fs::copy_file(entry.path(), work / "mesh" / entry.path().filename(),
                      fs::copy_options::overwrite_existing);
  }
  SECTION("moved to their places") {
    // They may be all that is left of the other job.
    const char* stage = GENERATE("mesh", "points");
    copy_tree(fs::path(other.run.work_dir) / stage, work / stage);
    const auto before = bytes_of(work / stage / "000000.h5");
    try {
      mesh_bytes(job);
      FAIL("the other job's results were replaced");
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kUsage);
      CHECK(std::string(error.what()).find((work / stage).string()) != std::string::npos);
    }
    CHECK((bytes_of(work / stage / "000000.h5") == before));
    fs::rename(work / stage, scratch / "moved away");
  }
  CHECK((mesh_bytes(job) == expected));
}

}  // namespace orbweave
