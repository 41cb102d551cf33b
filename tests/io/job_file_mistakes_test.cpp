// What is wrong with a job file or a setting is told with its place and what would be right.
#include <catch2/catch.hpp>

#include "io/error.h"
#include "io/job/job_file.h"
#include "io/job/toml_document.h"
#include "io/text/nearest_name.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

/// The message of the usage error that `text` leads to as a job file called job.toml.
std::string message_of(const std::string& text) {
  try {
    parse_job(text, "job.toml");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    return error.what();
  }
  return "accepted";
}

std::string message_of_setting(const std::string& assignment) {
  Job job;
  try {
    set_job_key(job, assignment);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    return error.what();
  }
  return "accepted";
}

using Catch::Contains;
using Catch::StartsWith;

TEST_CASE("AnUnknownKeyNamesFileLineAndTheNearestKnownKey") {
  CHECK(message_of("[reconstruct]\n\nball_radi = [1.0]\n") ==
        "job.toml: line 3: unknown key reconstruct.ball_radi. "
        "Did you mean reconstruct.ball_radii?");
  // The right key in the wrong section, and outside of every section.
  CHECK_THAT(message_of("[run]\nmemory = 1\n"), Contains("Did you mean partition.memory?"));
  CHECK_THAT(message_of("threads = 1\n"), Contains("Did you mean run.threads?"));
  CHECK_THAT(message_of("[output]\nformat.x = 1\n"), Contains("output.format"));
  CHECK_THAT(message_of("[fill]\nmax_diametre = 1\n"), Contains("Did you mean fill.max_diameter?"));
}

TEST_CASE("AnUnknownSectionNamesFileLineAndTheNearestKnownSection") {
  CHECK(message_of("[input]\n[partitions]\n") ==
        "job.toml: line 2: unknown section [partitions]. Did you mean [partition]?");
  CHECK_THAT(message_of("reconstruct = 3\n"), Contains("unknown key reconstruct"));
  CHECK_THAT(message_of("[[input]]\nfiles = []\n"), Contains("line 1: unknown key input"));
}

TEST_CASE("ValuesThatAreNoneAndForeignCommentsAreToldWithWhatIsRight") {
  for (const char* value : {"m.ply", "True", "yes", "0,05", "[0,05]", "[\u201cm.ply\u201d]"}) {
    const std::string text = "[output]\nmesh = " + std::string(value) + "\n";
    INFO(text);
    CHECK_THAT(message_of(text),
               StartsWith("job.toml: line 2: not valid TOML: ") && Contains("a text in quotes"));
  }
  CHECK_THAT(message_of("[input]\nfiles = [\"scans\\q.ply\"]\n"),
             StartsWith("job.toml: line 2: not valid TOML: ") && Contains("in single quotes"));
  for (const char* line : {"// comment", "; comment"})
    CHECK_THAT(message_of("[output]\n" + std::string(line) + "\n"), Contains("a comment behind #"));
}

TEST_CASE("AJobFileInUtf16IsToldAsThat") {
  CHECK_THAT(message_of(std::string("\xFF\xFE[\0i\0]\0", 8)),
             StartsWith("job.toml: the job file is UTF-16") && Contains("-Encoding utf8"));
}

TEST_CASE("ASectionThatIsNoTableSaysSo") {
  CHECK(message_of("[partition]\n[[input]]\nfiles = []\n") ==
        "job.toml: line 2: unknown key input: this is the name of a section; found a list of "
        "tables, expected [input] once, and its keys below");
  CHECK(message_of("input = \"a.ply\"\n") ==
        "job.toml: line 1: unknown key input: this is the name of a section; found \"a.ply\", "
        "expected [input] once, and its keys below");
  CHECK_THAT(message_of("output = [{mesh = \"m.ply\"}]\n"), Contains("found a list of tables"));
  CHECK_THAT(message_of("[[inputs]]\nfiles = []\n"),
             Contains("unknown section [inputs]. Did you mean [input]?"));
  CHECK(message_of("[[input.files]]\na = 1\n") ==
        "job.toml: line 1: input.files has an unsuitable value; found a list of tables, expected "
        "a list of paths and patterns such as [\"scans/*.ply\"]");
  CHECK_THAT(message_of("[output.mesh]\nname = \"m.ply\"\n"),
             Contains("output.mesh has an unsuitable value; found a table"));
  CHECK(message_of_setting("input=scan.ply") ==
        "unknown key input: this is the name of a section; found scan.ply, expected a key of it: "
        "input.KEY=VALUE");
}

TEST_CASE("AKeyWithTheNameOfASectionBelowAnotherIsToldWhereItBelongs") {
  const std::string below = "[output]\nmesh = \"m.ply\"\n";
  CHECK(message_of(below + "fill.max_edges = 3\n") ==
        "job.toml: line 3: unknown key output.fill: fill is a section, and what stands below "
        "[output] belongs to that; expected [fill] on a line of its own, and its keys below");
  CHECK_THAT(message_of(below + "fill = {max_edges = 3}\n"), Contains("expected [fill] on a line"));
  CHECK_THAT(message_of(below + "output.report = \"r.json\"\n"),
             Contains("expected the key without the name of its section"));
}

TEST_CASE("ScalesThatCannotBeComputedWithAreRefused") {
  for (const char* value :
       {"1e-320", "1e-300", "9e-76", "1.1e75", "1e308", "0", "-1", "nan", "inf"})
    CHECK_THAT(message_of("[input]\nunits_per_meter = " + std::string(value) + "\n"),
               Contains("input.units_per_meter has an unsuitable value; found " +
                        std::string(value) + ", expected \"auto\" or a number from 1e-75 to 1e75"));
  for (const char* value : {"1e-75", "1000", "1e75", "\"auto\""})
    CHECK(message_of("[input]\nunits_per_meter = " + std::string(value) + "\n") == "accepted");
}

TEST_CASE("ASectionUnderTwoNamesNamesBothPlaces") {
  CHECK(
      message_of("[cleaning]\nauto = true\n\n[prepare]\nsmooth_radius = 1.0\n") ==
      "job.toml: line 4: one section under two names; found [cleaning] in line 1 and [prepare] in "
      "line 4, expected [cleaning] alone");
  CHECK_THAT(message_of("prepare.auto = true\n[cleaning]\n"),
             Contains("found [prepare] in line 1 and [cleaning] in line 2"));
  CHECK_THAT(message_of("[prepare]\nsmooth_radi = 1\n"),
             StartsWith("job.toml: line 2: unknown key prepare.smooth_radi. Did you mean "
                        "cleaning.smooth_radius?"));
}

TEST_CASE("AWordThatIsLikeNoKeyIsAnsweredByTheKeysThatThereAre") {
  CHECK_THAT(message_of("[run]\nzeta = 1\n"),
             Contains("unknown key run.zeta. The keys of [run] are ") && Contains("threads, "));
  CHECK_THAT(message_of("[fill]\nmax_dia = 1\n"), Contains("Did you mean fill.max_diameter?"));
  CHECK_THAT(message_of("[fil]\nmax_diameter = 1\n"), Contains("Did you mean [fill]?"));
  CHECK_THAT(message_of("[zzz]\n"), Contains("The sections are input, "));
}

TEST_CASE("TheFirstMistakeOfSeveralIsReported") {
  CHECK_THAT(message_of("[run]\nzeta = 1\nalpha = 2\n[aaa]\n"), StartsWith("job.toml: line 2: "));
}

TEST_CASE("AnUnsuitableValueNamesFileLineValueAndRange") {
  CHECK(message_of("[reconstruct]\nlevels = 9 # many\n") ==
        "job.toml: line 2: reconstruct.levels has an unsuitable value; found 9, expected "
        "\"auto\" or an integer from 1 to 8");
}

struct Unsuitable {
  const char* section;
  const char* line;
};

TEST_CASE("ValuesOutsideTheirRangeAreRejected") {
  const auto [section, line] = GENERATE(
      Unsuitable{"input", "files = 3"}, Unsuitable{"input", "files = [\"a\", 3]"},
      Unsuitable{"input", "files = [\"\"]"}, Unsuitable{"input", "files = [[\"a\"]]"},
      Unsuitable{"input", "columns = true"}, Unsuitable{"input", "separator = \"x\""},
      Unsuitable{"partition", "memory = \"4 GoB\""}, Unsuitable{"partition", "memory = 4"},
      Unsuitable{"partition", "memory = -1"}, Unsuitable{"partition", "memory = \"\""},
      Unsuitable{"partition", "memory = 99999999999999999999"},
      Unsuitable{"partition", "chunk_points = 0"}, Unsuitable{"partition", "chunk_points = 1.5"},
      Unsuitable{"partition", "chunk_points = \"all\""}, Unsuitable{"normals", "source = \"x\""},
      Unsuitable{"reconstruct", "method = 1"}, Unsuitable{"reconstruct", "ball_radii = []"},
      Unsuitable{"reconstruct", "ball_radii = [0.0]"},
      Unsuitable{"reconstruct", "ball_radii = [-1.0]"},
      Unsuitable{"reconstruct", "ball_radii = [2, 1]"},
      Unsuitable{"reconstruct", "ball_radii = [1, 1]"},
      Unsuitable{"reconstruct", "ball_radii = [nan]"},
      Unsuitable{"reconstruct", "ball_radii = [1, inf]"},
      Unsuitable{"reconstruct", "ball_radii = [1e999]"},
      Unsuitable{"reconstruct", "ball_radii = [\"1\"]"},
      Unsuitable{"reconstruct", "ball_radii = [1e-300]"},
      Unsuitable{"reconstruct", "ball_radii = [9e-76, 1]"},
      Unsuitable{"reconstruct", "ball_radii = [1, 1.1e75]"},
      Unsuitable{"reconstruct", "ball_radii = [1, 65537]"},
      Unsuitable{"reconstruct", "ball_radii = [1, 65530, 65531, 65532]"},
      Unsuitable{"input", "pose = [\"a.ply 1 2\"]"},
      Unsuitable{"input", "pose = [\"a.ply 0 0 0 0 0 0 0\"]"},
      Unsuitable{"input", "scanner = [1, 2]"}, Unsuitable{"input", "scanner = [0, 0, 0, 0]"},
      Unsuitable{"input", "scanner = [1, 2, 3, 1]"}, Unsuitable{"input", "las_classes = [256]"},
      Unsuitable{"input", "las_classes = [2.5]"}, Unsuitable{"input", "drop_classes = [-1]"},
      Unsuitable{"input", "drop_classes = \"all\""}, Unsuitable{"input", "crop = [1, 2, 3]"},
      Unsuitable{"input", "crop = [0, 0, 1, -1]"},
      Unsuitable{"input", "crop_area = \"POLYGON ((0 0, 1 1))\""}, Unsuitable{"input", "every = 0"},
      Unsuitable{"input", "every = 1.5"}, Unsuitable{"input", "returns = \"second\""},
      Unsuitable{"cleaning", "auto = 1"}, Unsuitable{"cleaning", "outlier_sigma = -1"},
      Unsuitable{"cleaning", "merge_tolerance = inf"},
      Unsuitable{"cleaning", "smooth_radius = \"1\""}, Unsuitable{"cleaning", "smooth_passes = 9"},
      Unsuitable{"cleaning", "thin_to_spacing = nan"}, Unsuitable{"normals", "source = \"guess\""},
      Unsuitable{"normals", "neighbors = 2"}, Unsuitable{"normals", "orientation = \"down\""},
      Unsuitable{"normals", "viewpoint = [1, 2]"}, Unsuitable{"normals", "up = [0, 0, 0]"},
      Unsuitable{"reconstruct", "ball_radii = \"many\""}, Unsuitable{"reconstruct", "levels = 0"},
      Unsuitable{"reconstruct", "levels = \"2\""}, Unsuitable{"fill", "enabled = 0"},
      Unsuitable{"fill", "kernel = \"cubic\""}, Unsuitable{"fill", "kernel = 2"},
      Unsuitable{"fill", "neighborhood = 0.99"}, Unsuitable{"fill", "neighborhood = inf"},
      Unsuitable{"fill", "neighborhood = nan"}, Unsuitable{"fill", "neighborhood = [2.0]"},
      Unsuitable{"fill", "max_diameter = 0"}, Unsuitable{"fill", "max_diameter = -inf"},
      Unsuitable{"fill", "max_diameter = nan"}, Unsuitable{"fill", "max_diameter = \"1\""},
      Unsuitable{"fill", "max_perimeter = -1.0"}, Unsuitable{"fill", "max_edges = -1"},
      Unsuitable{"fill", "max_edges = 2.0"}, Unsuitable{"fill", "max_edges = inf"},
      Unsuitable{"fill", "keep_outer_border = 1"}, Unsuitable{"fill", "allow_intersections = 1"},
      Unsuitable{"fill", "min_triangles = -3"}, Unsuitable{"output", "patch_color = \"blue\""},
      Unsuitable{"output", "patch_color = \"#4477c\""},
      Unsuitable{"output", "patch_color = \"#4477cg\""},
      Unsuitable{"output", "patch_color = \"#4477cc00\""},
      Unsuitable{"output", "patch_color = \"#+4-7 c\""},
      Unsuitable{"output", "patch_color = 4478668"}, Unsuitable{"output", "mesh = 3"},
      Unsuitable{"output", "mesh = \"a\\u0000b\""}, Unsuitable{"output", "format = \"ascii\""},
      Unsuitable{"output", "precision = \"half\""}, Unsuitable{"output", "attributes = 1"},
      Unsuitable{"output", "report = false"}, Unsuitable{"output", "picture = []"},
      Unsuitable{"run", "threads = -1"}, Unsuitable{"run", "threads = 5000"},
      Unsuitable{"run", "work_dir = 1979-05-27"}, Unsuitable{"run", "keep_work_dir = \"yes\""});
  const std::string text(line);
  const std::string key = text.substr(0, text.find(' '));
  CAPTURE(section, line);
  CHECK_THAT(message_of("[" + std::string(section) + "]\n\n" + line + "\n"),
             StartsWith("job.toml: line 3: " + std::string(section) + "." + key) &&
                 Contains("; found ") && Contains(", expected "));
}

TEST_CASE("BallRadiiThatCannotBeComputedWithAreRefusedBeforeTheScanIsRead") {
  const auto message = [](const std::string& radii) {
    return message_of("[reconstruct]\nball_radii = " + radii + "\n");
  };
  CHECK(message("[1e-300]") ==
        "job.toml: line 2: reconstruct.ball_radii: a ball radius cannot be computed with; found "
        "[1e-300], expected radii from 1e-75 to 1e75");
  CHECK(
      message("[1, 65537]") ==
      "job.toml: line 2: reconstruct.ball_radii: the largest ball radius is more than 65536 times "
      "the smallest; found [1, 65537], expected radii that differ by a factor of at most 65536");
  CHECK_THAT(message("[1, 60000, 65000, 65536]"),
             Contains("together are more than 131072 times") && Contains("expected fewer"));
  for (const std::string radii : {"[1e-75]", "[1e75]", "[1, 65536]", "[1, 2, 60000, 65536]"})
    CHECK_NOTHROW(parse_job("[reconstruct]\nball_radii = " + radii + "\n", "job.toml"));
}

TEST_CASE("WhatThisVersionDoesNotHaveIsSaid") {
  CHECK_THAT(message_of("[reconstruct]\nmethod = \"poisson\"\n"),
             Contains("found \"poisson\"") && Contains("\"ball_pivoting\"") &&
                 Contains("\"tight_cocone\""));
}

TEST_CASE("BrokenTomlNamesFileAndLine") {
  CHECK(message_of("[input]\nfiles = \n") ==
        "job.toml: line 2: not valid TOML: missing value after key-value separator '='; found "
        "'files = '");
  CHECK_THAT(message_of("[input\n"), Contains("line 1: not valid TOML"));
  CHECK_THAT(message_of("\n\nfoo bar\n"), Contains("line 3: not valid TOML"));
  CHECK_THAT(message_of("[run]\nthreads = 1\nthreads = 2\n"), Contains("line 3: not valid TOML"));
}

TEST_CASE("BytesThatAreNoUtf8TextAreAnError") {
  for (const char* bytes : {"\x90", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80",
                            "\xff", "\xc3", "\xe2\x82", "\x01", "\x7f"}) {
    for (const char* quote : {"\"", "'", "'''", "\"\"\""})
      CHECK_THAT(message_of("[output]\nmesh = " + std::string(quote) + "a" + bytes + quote + "\n"),
                 StartsWith("job.toml: line 2: not valid TOML: a byte that is no UTF-8 text"));
  }
  const std::string good = "\u00fc \u20ac \U0001f600";
  CHECK(parse_job("[output]\nmesh = \"" + good + "\"\n", "").output.mesh == good);
}

TEST_CASE("DeepNestingIsAnErrorAndNoCrash") {
  CHECK_THAT(message_of("a = " + std::string(60000, '[')), Contains("nested too deeply"));
  std::string dotted = "a";
  for (int i = 0; i < 30000; ++i) dotted += ".a";
  CHECK_THAT(message_of("\n" + dotted + " = 1\n"), Contains("line 2: nested too deeply"));
  CHECK_THAT(message_of("[" + dotted + "]\n"), Contains("nested too deeply"));
  CHECK_THAT(message_of("# " + std::string(kTomlLimitBytes, '.')), Contains("too long"));
  // Brackets and dots in names are no nesting.
  const std::string name(100, '[');
  CHECK(parse_job("[output]\nmesh = \"" + name + ".\\\"" + name + "\"\n", "").output.mesh.size() ==
        202);
  CHECK(parse_job("[output]\nmesh = '''" + name + "'" + name + "'''\n", "").output.mesh.size() ==
        201);
}

TEST_CASE("AMissingJobFileIsAUsageError") {
  const test::ScratchDirectory scratch;
  for (const auto& path : {scratch / "none.toml", scratch.path()}) {
    try {
      read_job_file(path);
      FAIL("accepted " << path);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kUsage);
      CHECK_THAT(error.what(), StartsWith(path.string() + ": cannot "));
    }
  }
}

TEST_CASE("AssignmentsSplitAtTheFirstEqualsSign") {
  Job job;
  set_job_key(job, "output.mesh = \"a line of a job file.ply\"");
  CHECK(job.output.mesh == "a line of a job file.ply");
  set_job_key(job, "run.threads = 3");
  CHECK(job.run.threads == 3);
  set_job_key(job, "output.mesh= blank.ply");
  CHECK(job.output.mesh == " blank.ply");
  set_job_key(job, "output.mesh=a=b.ply");
  CHECK(job.output.mesh == "a=b.ply");
  CHECK(message_of_setting("output.mesh") ==
        "no value given for a key; found \"output.mesh\", expected section.key=value");
}

TEST_CASE("SettingAKeyReportsTheSameMistakes") {
  CHECK(message_of_setting("reconstruct.ball_radi=1") ==
        "unknown key reconstruct.ball_radi. Did you mean reconstruct.ball_radii?");
  CHECK(message_of_setting("reconstruct.levels=9") ==
        "reconstruct.levels has an unsuitable value; found 9, expected \"auto\" or an integer from "
        "1 to 8");
  CHECK_THAT(message_of_setting("reconstruct.ball_radii=0.5,x"), Contains("ascending order"));
  CHECK_THAT(message_of_setting("run.threads=two"), Contains("found \"two\""));
  CHECK_THAT(message_of_setting("run.threads=1\nlevels = 2"), Contains("run.threads"));
}

TEST_CASE("AnUnsuitableValueOfAnOptionNamesTheOption") {
  Job job;
  CHECK_THROWS_WITH(set_job_option(job, "reconstruct.levels", "9"),
                    "--levels has an unsuitable value; found 9, expected \"auto\" or an integer "
                    "from 1 to 8");
}

TEST_CASE("TheNearestNameIsTheOneWithTheFewestEdits") {
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("memroy", "memory") == 1);
  CHECK(edit_distance("", "abc") == 3);
  CHECK(nearest_name("recontsruct", {"run", "reconstruct", "inspect"}) == "reconstruct");
  CHECK(nearest_name("x", {}).empty());
}

}  // namespace
}  // namespace orbweave
