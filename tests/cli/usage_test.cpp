// What a user meets before anything runs: help, versions, misspelt words.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using orbweave::test::run_in;
using orbweave::test::run_program;

TEST_CASE("EveryCommandHelpsWithAnExample") {
  const std::string command = GENERATE("run", "reconstruct", "fill", "plan", "status", "inspect",
                                       "compare", "convert", "generate", "config");
  CAPTURE(command);
  const auto result = run_program({command, "--help"});
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  CHECK_THAT(result.out, Contains("Usage: orbweave " + command));
  CHECK_THAT(result.out, Contains("Example:") && Contains("  orbweave " + command + " "));
}

TEST_CASE("ProgramHelpListsEveryCommand") {
  const auto result = run_program({"--help"});
  CHECK(result.status == 0);
  for (const char* command : {"run", "reconstruct", "fill", "plan", "status", "inspect", "compare",
                              "convert", "generate", "config"})
    CHECK_THAT(result.out, Contains(std::string("\n  ") + command + " "));
}

TEST_CASE("VersionIsNameNumberAndTheLicenceOfParts") {
  const auto result = run_program({"--version"});
  CHECK(result.status == 0);
  CHECK_THAT(result.out, Catch::Matchers::Matches(
                             "orbweave [0-9]+\\.[0-9]+\\.[0-9]+\n(Built with .*GPL.*\n)?"));
}

TEST_CASE("NoCommandIsWrongUsageThatListsCommands") {
  const auto result = run_program({});
  CHECK(result.status == 2);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Contains("orbweave: error: no command given") && Contains("reconstruct"));
}

TEST_CASE("MisspeltCommandGetsTheNearestOne") {
  const auto result = run_program({"recnstruct", "a.ply"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err,
             Contains("unknown command \"recnstruct\"") && Contains("Did you mean 'reconstruct'?"));
}

TEST_CASE("MisspeltOptionGetsTheNearestOne") {
  const auto result = run_program({"convert", "a.ply", "b.ply", "--normals-from-face"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains("unknown option --normals-from-face") &&
                             Contains("Did you mean --normals-from-faces?"));
}

TEST_CASE("AnEmptyValueIsNotTheNextOption") {
  const orbweave::test::ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "500", "-o", "cloud.ply"}).status == 0);
  const auto result =
      run_in(in, {"reconstruct", "cloud.ply", "-o", "mesh.ply", "--picture=", "--progress=none"});
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  CHECK(std::filesystem::exists(in / "mesh.ply"));
  CHECK_THAT(run_in(in, {"reconstruct", "cloud.ply", "--output=", "--cleaning"}).err,
             Contains("names no mesh to write"));
  CHECK_THAT(run_in(in, {"reconstruct", "cloud.ply", "-o", "mesh.ply",
                         "--smooth-passes=", "--picture=a.png"})
                 .err,
             Contains("--smooth-passes has an unsuitable value; found \"\""));
}

TEST_CASE("AnEmptyNameIsToldWithTheArgument") {
  std::vector<std::string> words = GENERATE(
      std::vector<std::string>{"inspect", ""}, std::vector<std::string>{"run", ""},
      std::vector<std::string>{"status", ""}, std::vector<std::string>{"fill", "", "-o", "a.ply"},
      std::vector<std::string>{"compare", "", "b.ply"},
      std::vector<std::string>{"reconstruct", "", "-o", "mesh.ply"});
  CAPTURE(words);
  const auto result = run_program(words);
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains(": the name is empty. Where a variable of the shell"));
}

TEST_CASE("AnOptionOfAKeyIsToldAsASettingWhereAJobFileIsRun") {
  const auto told = [](const char* option) { return run_program({"run", "job.toml", option}).err; };
  CHECK_THAT(told("--max-edges=3"), Contains("unknown option --max-edges. Give a key of the job "
                                             "another value by --set fill.max_edges=VALUE. See"));
  CHECK_THAT(told("--no-fill"), Contains("--set fill.enabled=false"));
  CHECK_THAT(told("--nonsense"), !Contains("--set"));
}

TEST_CASE("MissingArgumentIsWrongUsageThatPointsToHelp") {
  const auto result = run_program({"convert", "a.ply"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains("OUT") && Contains("See 'orbweave convert --help'"));
}

TEST_CASE("WhatIsMissingIsToldAlsoBehindTheEndOfTheOptions") {
  const auto result = run_program({"reconstruct", "--", "-scan.ply", "-o", "mesh.ply"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err,
             Contains("--output is required") && Contains("See 'orbweave reconstruct --help'"));
  const auto extra = run_program({"convert", "--", "a.ply", "b.ply", "-c.ply"});
  CHECK(extra.status == 2);
  CHECK_THAT(extra.err, Contains("-c.ply"));
}

TEST_CASE("ErrorsCarryNoColourIntoALog") {
  CHECK(run_program({"nonsense"}).err.find('\033') == std::string::npos);
}
