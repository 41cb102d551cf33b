// orbweave config: what it prints is what the program reads.
#include <catch2/catch.hpp>
#include <cstdio>
#include <memory>
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

TEST_CASE("ListsOfIntegersHaveIntegersByDefault") {
  CHECK_THAT(run_program({"config", "--defaults"}).out, Contains("\ndrop_classes = [7, 18]\n"));
  CHECK_THAT(run_program({"config", "--reference"}).out, Contains("Default: `[7, 18]`"));
}

TEST_CASE("ThePrintedSchemaIsJson") {
  const auto printed = run_program({"config", "--schema"});
  CHECK(printed.status == 0);
  const auto schema = nlohmann::json::parse(printed.out);
  CHECK(schema["properties"]["partition"]["properties"]["memory"]["default"] == 4294967296);
}

TEST_CASE("ConfigPrintsOneThingAtATime") {
  CHECK_THAT(run_program({"config"}).err, Contains("--defaults, --schema, --reference"));
  CHECK(run_program({"config"}).status == 2);
  CHECK(run_program({"config", "--schema", "--defaults"}).status == 2);
}

TEST_CASE("EveryCommandHasAManualPageThatTheProgramsPageNames") {
  const auto program = run_program({"config", "--manual", "orbweave"});
  CHECK(program.status == 0);
  for (const char* command : {"run", "reconstruct", "fill", "plan", "status", "inspect", "compare",
                              "convert", "generate", "config"}) {
    const std::string name = std::string("orbweave-") + command;
    CHECK_THAT(program.out, Contains(".BR orbweave\\-" + std::string(command) + " (1)"));
    const auto page = run_program({"config", "--manual", name});
    CAPTURE(name);
    CHECK(page.status == 0);
    CHECK_THAT(page.out, Contains(".SH EXIT STATUS") && Contains(".SH SYNOPSIS"));
  }
  const auto team = run_program({"config", "--manual", "orbweave-mpi"});
  CHECK_THAT(program.out, Contains(".BR orbweave\\-mpi (1)"));
  CHECK_THAT(team.out, Contains("mpirun") && Contains(".BR orbweave\\-reconstruct (1)") &&
                           Contains(".SH EXIT STATUS") && !Contains("orbweave\\-fill"));
  const auto unknown = run_program({"config", "--manual", "orbweave-weave"});
  CHECK(unknown.status == 2);
  CHECK_THAT(unknown.err, Contains("no manual page of this name") && Contains("orbweave-run"));
}

TEST_CASE("HelpOfConfigListsItsOptionsOnceAsThoseOfOtherCommands") {
  CHECK_THAT(run_program({"config", "--help"}).out,
             Contains("\nOptions:\n") && Contains("--completion") && !Contains("Group"));
  const std::string page = run_program({"config", "--manual", "orbweave-config"}).out;
  const std::string help = "Print this help message";
  CHECK(page.find(help) != std::string::npos);
  CHECK(page.find(help) == page.rfind(help));
}

TEST_CASE("ManualPagesPromiseResumptionOfJobsAlone") {
  for (const char* name : {"orbweave-convert", "orbweave-run"}) {
    const auto page = run_program({"config", "--manual", name});
    CHECK_THAT(page.out, Contains("a job keeps what is done") && !Contains("what is done is kept"));
  }
}

TEST_CASE("ManualPagesShowOptionsWithTheirValues") {
  const auto page = run_program({"config", "--manual", "orbweave-reconstruct"});
  CHECK_THAT(page.out, Contains("\\fB\\-o\\fR, \\fB\\-\\-output\\fR \\fIFILE\\fR") &&
                           Contains("(required)") && Contains("\\fISCAN\\fR"));
}

TEST_CASE("CompletionKnowsCommandsOptionsAndChoicesOfEachShell") {
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const auto printed = run_program({"config", "--completion", shell});
    CAPTURE(shell);
    CHECK(printed.status == 0);
    CHECK_THAT(printed.out, Contains("reconstruct") && Contains("ball-radii") &&
                                Contains("biharmonic triharmonic"));
  }
  const auto unknown = run_program({"config", "--completion", "tcsh"});
  CHECK(unknown.status == 2);
  CHECK_THAT(unknown.err, Contains("bash, zsh or fish"));
}

TEST_CASE("BashCompletesChoicesAndLeavesNamesOfFilesToItself") {
  const ScratchDirectory in;
  write_text(in / "complete.bash", run_program({"config", "--completion", "bash"}).out);
  write_text(in / "my scan.ply", "");
  write_text(in / "ask.bash",
             "cd '" + in.path().string() +
                 "' && source complete.bash && complete -p orbweave\n"
                 "ask() { COMP_WORDS=(orbweave \"$@\"); COMP_CWORD=$#; _orbweave; "
                 "echo \"$* is ${COMPREPLY[*]}.\"; }\n"
                 "ask recon; ask reconstruct --normals es; ask reconstruct --ball; "
                 "ask reconstruct my; ask reconstruct --poses my; ask fill --kernel tri\n");
  const std::string command = "bash '" + (in / "ask.bash").string() + "'";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  std::string said;
  for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get()))
    said += static_cast<char>(c);
  CAPTURE(said);
  // Bash itself completes where the function finds nothing: also names with blanks.
  CHECK_THAT(said, Contains("-o default") && Contains("reconstruct my is .") &&
                       Contains("reconstruct --poses my is ."));
  CHECK_THAT(said, Contains("recon is reconstruct.") && Contains("--normals es is estimate.") &&
                       Contains("--ball is --ball-radii.") &&
                       Contains("--kernel tri is triharmonic."));
}

TEST_CASE("TheReferenceHasKeysOptionsFieldsAndExitStatuses") {
  const auto printed = run_program({"config", "--reference"});
  CHECK(printed.status == 0);
  CHECK_THAT(printed.out,
             Contains("### `fill.max_edges`") && Contains("### `orbweave compare`") &&
                 Contains("| `mesh.watertight` | true or false | whether the mesh is closed") &&
                 Contains("| `holes[].confidence` | number | how far the patch can be trusted") &&
                 Contains("| 130 | interrupted"));
}
