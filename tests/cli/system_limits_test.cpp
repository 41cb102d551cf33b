// However little address space or how few open files there are, a job ends well or says what is
// short: no signal ends it, and nothing half-written is left.
#include <catch2/catch.hpp>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using orbweave::test::names_in;
using orbweave::test::run_in;
using orbweave::test::run_limited;
using orbweave::test::ScratchDirectory;

TEST_CASE("AJobEndsPlainlyWithinAnyAddressSpace") {
  constexpr int kLoaderFailed = 127;  // shared libraries do not fit
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "3000", "-o", "scan.ply"}).status == 0);
  int refused = 0, done = 0;
  for (int kibibytes = 60'000; kibibytes <= 400'000; kibibytes += 10'000) {
    CAPTURE(kibibytes);
    const auto result =
        run_limited(in, "ulimit -v " + std::to_string(kibibytes),
                    {"reconstruct", "scan.ply", "-o", "mesh.ply", "--threads", "4"});
    CAPTURE(result.err);
    if (result.status == kLoaderFailed) continue;
    CHECK((result.status == 0 || result.status == 4));
    if (result.status == 0) {
      ++done;
      CHECK(names_in(in) == std::vector<std::string>{"mesh.ply", "scan.ply"});
      std::filesystem::remove(in / "mesh.ply");
    } else {
      ++refused;
      CHECK_THAT(result.err, Contains("orbweave: error: "));
      for (const std::string& name : names_in(in))
        CHECK((name == "scan.ply" || name == "mesh.work"));
    }
  }
  CHECK(refused > 0);
  CHECK(done > 0);
}

TEST_CASE("TooManyOpenFilesAskForAHigherLimit") {
  const ScratchDirectory in;
  const std::vector<std::string> job = {
      "reconstruct", "scan.ply", "-o", "mesh.ply", "--threads", "2", "--chunk-points", "500"};
  REQUIRE(run_in(in, {"generate", "torus", "--points", "3000", "-o", "scan.ply"}).status == 0);
  const auto result = run_limited(in, "ulimit -n 8", job);
  CHECK(result.status == 4);
  CHECK_THAT(result.err, Contains("Too many open files") && Contains("ulimit -n") &&
                             !Contains("space") && Contains("mesh.work; the same command resumes"));
  CHECK(names_in(in) == std::vector<std::string>{"mesh.work", "scan.ply"});
  CHECK(run_in(in, job).status == 0);
  CHECK(names_in(in) == std::vector<std::string>{"mesh.ply", "scan.ply"});
}
