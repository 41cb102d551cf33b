// orbweave config: what it prints is what the program reads.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave::test;

TEST_CASE("ThePrintedJobFileRunsOnceItNamesScanAndMesh") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "500", "-o", "scan.ply"}).status == 0);
  const auto printed = run_in(in, {"config", "--defaults"});
  CHECK(printed.status == 0);
  write_text(in / "job.toml", printed.out);
  const auto incomplete = run_in(in, {"run", "job.toml"});
  CHECK(incomplete.status == 2);
  CHECK_THAT(incomplete.err, Contains("job.toml: names no scans"));
  const auto ran = run_in(in, {"run", "job.toml", "--set", "input.files=scan.ply", "--set",
                               "output.mesh=mesh.ply", "--progress", "none"});
  CHECK(ran.status == 0);
  REQUIRE(run_in(in, {"reconstruct", "scan.ply", "-o", "same.ply", "--progress", "none"}).status ==
          0);
  CHECK(file_text(in / "mesh.ply") == file_text(in / "same.ply"));
}

TEST_CASE("ThePrintedSchemaIsJson") {
  const auto printed = run_program({"config", "--schema"});
  CHECK(printed.status == 0);
  const auto schema = nlohmann::json::parse(printed.out);
  CHECK(schema["properties"]["partition"]["properties"]["memory"]["default"] == 4294967296);
}

TEST_CASE("ConfigPrintsOneThingAtATime") {
  CHECK_THAT(run_program({"config"}).err, Contains("--defaults, --schema or --reference"));
  CHECK(run_program({"config"}).status == 2);
  CHECK(run_program({"config", "--schema", "--defaults"}).status == 2);
}
