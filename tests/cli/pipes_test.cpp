// Named pipes and standard input where commands read files: they work or are refused at once.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave::test;

namespace {

using Arguments = std::vector<std::string>;

/// Pipes that nobody writes to: whoever opens one waits for ever.
void make_pipes(const ScratchDirectory& in) {
  for (const char* name : {"scan.xyz", "mesh.ply", "mesh.stl"})
    REQUIRE(mkfifo((in / name).c_str(), 0600) == 0);
}

/// The program with a pipe that a file is written to meanwhile.
ProgramResult run_fed(const ScratchDirectory& in, const std::string& file, const std::string& pipe,
                      const Arguments& arguments) {
  return run_limited(in, "(cat " + file + " > " + pipe + " &)", arguments);
}

Arguments operator+(Arguments left, const Arguments& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

}  // namespace

TEST_CASE("APipeThatWouldBeReadTwiceIsRefusedUnopened") {
  const ScratchDirectory in;
  make_pipes(in);
  const Arguments before = names_in(in);
  for (const Arguments& arguments : {Arguments{"reconstruct", "scan.xyz", "-o", "m.ply"},
                                     {"plan", "scan.xyz"},
                                     {"inspect", "mesh.ply"},
                                     {"inspect", "scan.xyz", "--picture", "p.png"},
                                     {"inspect", "scan.xyz", "--undersampled"},
                                     {"inspect", "scan.xyz", "scan.xyz"},
                                     {"convert", "mesh.ply", "m.stl"},
                                     {"convert", "mesh.stl", "m.ply"},
                                     {"compare", "mesh.ply", "mesh.ply"},
                                     {"simplify", "mesh.ply", "-o", "m.ply", "--ratio", "0.5"},
                                     {"tileset", "mesh.ply", "-o", "tiles"},
                                     {"view", "mesh.ply", "-o", "page.html"},
                                     {"view", "mesh.ply", "--folder", "shown"}}) {
    CAPTURE(arguments);
    const auto result = run_in(in, arguments);
    CHECK(result.status == 3);
    CHECK_THAT(result.err,
               Contains("the file is read more than once, which a pipe does not allow") &&
                   Contains("Save it first, such as by: cat "));
    CHECK(names_in(in) == before);
  }
}

TEST_CASE("StandardInputThatWouldBeReadTwiceIsRefused") {
  const ScratchDirectory in;
  write_text(in / "cloud.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  for (const Arguments& arguments : {Arguments{"simplify", "-", "-o", "m.ply", "--ratio", "0.5"},
                                     {"tileset", "-", "-o", "tiles"},
                                     {"view", "-", "-o", "page.html"},
                                     {"inspect", "-", "--picture", "p.png"},
                                     {"inspect", "-", "--undersampled"},
                                     {"inspect", "-", "-"},
                                     {"compare", "-", "-"}}) {
    CAPTURE(arguments);
    const auto result = run_limited(in, "exec < cloud.xyz", arguments);
    CHECK(result.status == 2);
    CHECK_THAT(result.err,
               Contains("the file is read more than once, which standard input does not allow"));
    CHECK(names_in(in) == Arguments{"cloud.xyz"});
  }
}

TEST_CASE("APipeThatIsReadOnceIsReadAsAFile") {
  const ScratchDirectory in;
  write_text(in / "cloud.txt", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
  REQUIRE(run_in(in, {"generate", "cube", "--points", "500", "-o", "c.ply", "--truth", "t.ply"})
              .status == 0);
  for (const char* name : {"scan.xyz", "mesh.ply", "mesh.stl"})
    REQUIRE(mkfifo((in / name).c_str(), 0600) == 0);
  const auto inspected = run_fed(in, "cloud.txt", "scan.xyz", {"inspect", "scan.xyz"});
  CHECK(inspected.status == 0);
  CHECK_THAT(inspected.out, Catch::Matches("(.|\n)*points +4\n(.|\n)*"));
  const auto converted = run_fed(in, "cloud.txt", "scan.xyz", {"convert", "scan.xyz", "out.ply"});
  CHECK(converted.status == 0);
  CHECK_THAT(converted.out, Contains("out.ply: 4 points"));
  const auto filled = run_fed(in, "t.ply", "mesh.ply", {"fill", "mesh.ply", "-o", "filled.ply"});
  CHECK(filled.status == 0);
  REQUIRE(run_in(in, {"fill", "t.ply", "-o", "same.ply"}).status == 0);
  CHECK(file_text(in / "filled.ply") == file_text(in / "same.ply"));
  const auto compared = run_fed(in, "t.ply", "mesh.ply", {"compare", "mesh.ply", "t.ply"});
  CHECK(compared.status == 0);
  CHECK_THAT(compared.out, Contains("same"));
}

TEST_CASE("APipeForAMeshThatIsNotWrittenFrontToBackIsRefusedBeforeTheWork") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "cube", "--points", "500", "-o", "c.ply"}).status == 0);
  for (const char* name : {"mesh.glb", "mesh.vtp", "mesh.xdmf"})
    REQUIRE(mkfifo((in / name).c_str(), 0600) == 0);
  const Arguments before = names_in(in);
  for (const Arguments& output :
       {Arguments{"-o", "mesh.glb"},
        {"-o", "mesh.vtp"},
        {"-o", "mesh.xdmf"},
        {"-o", "mesh.ply", "--simplify", "ratio=0.5", "--simplified", "mesh.glb"}}) {
    CAPTURE(output);
    const Arguments job = Arguments{"c.ply", "--progress", "plain"} + output;
    const auto refused = run_in(in, Arguments{"reconstruct"} + job);
    CHECK(refused.status == 2);
    CHECK_THAT(refused.err, Contains("to a pipe or a device") && !Contains("begins"));
    CHECK(run_in(in, Arguments{"plan"} + job).status == 2);
    CHECK(names_in(in) == before);
  }
}

TEST_CASE("AMeshFromStandardInputLosesNoFacesUnsaid") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "cube", "--points", "500", "-o", "c.ply", "--truth", "t.ply"})
              .status == 0);
  const std::string fed = "exec < t.ply";
  const auto refused = run_limited(in, fed, {"convert", "-", "out.ply"});
  CHECK(refused.status == 3);
  CHECK_THAT(refused.err, Contains("standard input: a mesh is not converted from a stream") &&
                              Contains("49,152 faces") && Contains("cat > mesh.ply"));
  CHECK_FALSE(std::filesystem::exists(in / "out.ply"));
  CHECK(run_limited(in, fed, {"convert", "-", "points.xyz"}).status == 0);
  CHECK(run_limited(in, "exec < c.ply", {"convert", "-", "out.ply"}).status == 0);
  const auto inspected = run_limited(in, fed, {"inspect", "-"});
  CHECK(inspected.status == 0);
  CHECK_THAT(inspected.err, Contains("warning: standard input holds a mesh of 49,152 faces"));
}

TEST_CASE("StandardOutputByNameIsWrittenAlsoWhereItIsAPipe") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "500", "-o", "scan.ply"}).status == 0);
  std::filesystem::create_symlink("/dev/stdout", in / "linked.ply");
  const std::string through_pipe =
      "{ \"$0\" \"$@\"; echo $? > status; } | cat > got; exit \"$(cat status)\"; true";
  const Arguments job = {"reconstruct", "scan.ply", "-o", "mesh.ply"};
  const auto reported = run_limited(in, through_pipe, job + Arguments{"--report", "/dev/stdout"});
  CAPTURE(reported.err);
  CHECK(reported.status == 0);
  CHECK_THAT(file_text(in / "got"), Catch::StartsWith("{") && Contains("\"checksum\""));
  const auto drawn = run_limited(in, through_pipe, job + Arguments{"--picture", "/dev/fd/1"});
  CHECK(drawn.status == 0);
  CHECK(file_text(in / "got").substr(1, 3) == "PNG");
  const auto made = run_limited(in, through_pipe, {"reconstruct", "scan.ply", "-o", "linked.ply"});
  CHECK(made.status == 0);
  CHECK_THAT(file_text(in / "got"), Catch::StartsWith(file_text(in / "mesh.ply")));
  const auto converted = run_limited(in, through_pipe, {"convert", "scan.ply", "linked.ply"});
  CHECK(converted.status == 0);
  CHECK(file_text(in / "got").size() >= std::filesystem::file_size(in / "scan.ply"));
}
