// Raw scans of a virtual scanner, as a user makes them.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "io/clouds/open_point_source.h"
#include "io/points/point_source.h"
#include "io/points/scan_pose.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

ProgramResult generate_scans(const ScratchDirectory& in, const std::vector<std::string>& more) {
  std::vector<std::string> words = {"generate", "torus",   "--points",          "3000", "--scans",
                                    "6",        "--noise", "--misregistration", "0.5"};
  words.insert(words.begin() + 7, "0.2");
  words.insert(words.end(), more.begin(), more.end());
  return run_program(words, {.directory = in.path()});
}

}  // namespace

TEST_CASE("RawScansAreTheSameBytesEveryTimeAndHaveNoNormals") {
  const ScratchDirectory in;
  for (const char* name : {"a.ply", "b.ply"}) REQUIRE(generate_scans(in, {"-o", name}).status == 0);
  CHECK(file_text(in / "a.ply") == file_text(in / "b.ply"));
  CHECK(generate_scans(in, {"-o", "-"}).out == file_text(in / "a.ply"));
  const PointCloud cloud = read_all(*open_point_source(in / "a.ply"));
  CHECK(cloud.size() > 2700);
  CHECK(cloud.size() < 3300);
  CHECK_FALSE(cloud.schema.has_normals);
  CHECK(cloud.schema.attributes == std::vector<AttributeField>{{"scan", ScalarType::kUint8}});
  REQUIRE(generate_scans(in, {"--seed", "2", "-o", "b.ply"}).status == 0);
  CHECK(file_text(in / "a.ply") != file_text(in / "b.ply"));
}

TEST_CASE("SeparateScansWithTheirPosesAreTheMergedCloud") {
  const ScratchDirectory in;
  REQUIRE(generate_scans(in, {"-o", "merged.ply"}).status == 0);
  const auto separate = generate_scans(in, {"--separate", "-o", "scans.ply"});
  REQUIRE(separate.status == 0);
  CHECK_THAT(separate.out, Contains("scans_5.ply: ") && Contains("scans.conf: poses"));
  const std::vector<ScanPose> poses = read_stanford_poses(in / "scans.conf");
  REQUIRE(poses.size() == 6);
  std::vector<Vec3> world;
  for (int scan = 0; scan < 6; ++scan) {
    const auto path = in / ("scans_" + std::to_string(scan) + ".ply");
    const RigidMotion pose = pose_of_scan(poses, path);
    for (const Vec3& p : read_all(*open_point_source(path)).positions)
      world.push_back(pose.point(p));
  }
  CHECK(world == read_all(*open_point_source(in / "merged.ply")).positions);
}

TEST_CASE("NamesOfSeparateScansKeepTheWholeExtension") {
  const ScratchDirectory in;
  const auto result = run_program(
      {"generate", "plane", "--points", "100", "--scans", "6", "--separate", "-o", "flat.ply.gz"},
      {.directory = in.path()});
  REQUIRE(result.status == 0);
  CHECK(read_all(*open_point_source(in / "flat_0.ply.gz")).size() > 80);
  // The other five look at its edge or its back.
  CHECK_FALSE(std::filesystem::exists(in / "flat_1.ply.gz"));
  CHECK_THAT(result.out, Contains("flat_1.ply.gz: not written"));
  CHECK(read_stanford_poses(in / "flat.conf").size() == 1);
}

TEST_CASE("SeparateScansWhoseNamesHoldBlanksAreReadWithTheirPoses") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "room", "--points", "1000", "--separate", "-o", "my room.ply"})
              .status == 0);
  CHECK(run_in(in, {"run", "my room.toml", "--progress", "none"}).status == 0);
  REQUIRE(generate_scans(in, {"--separate", "-o", "my scans.ply"}).status == 0);
  CHECK(read_stanford_poses(in / "my scans.conf")[0].file == "my scans_0.ply");
}

TEST_CASE("OptionsOfScansWithoutScansAreUsageErrors") {
  const ScratchDirectory in;
  const auto status = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"generate", "sphere", "--points", "100"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words, {.directory = in.path()}).status;
  };
  CHECK(status({"--misregistration", "1", "-o", "a.ply"}) == 2);
  CHECK(status({"--separate", "-o", "a.ply"}) == 2);
  CHECK(status({"--scans", "6", "--separate", "-o", "-"}) == 2);
  CHECK(status({"--scans", "256", "-o", "a.ply"}) == 2);
  CHECK(status({"--scans", "0", "-o", "a.ply"}) == 2);
  CHECK(status({"--scans", "6", "--density", "varying", "-o", "a.ply"}) == 2);
  CHECK(std::filesystem::is_empty(in.path()));
}

TEST_CASE("SeparateScansOfARoomComeWithAJobFileThatReconstructsThem", "[costly]") {
  const ScratchDirectory in;
  const auto made = run_program({"generate", "room", "--points", "20000", "--separate", "-o",
                                 "room.ply", "--truth", "truth.ply"},
                                {.directory = in.path()});
  REQUIRE(made.status == 0);
  CHECK_THAT(made.out, Contains("room_3.ply: ") && Contains("room.toml: job file with the poses"));
  const auto done = run_program({"run", "room.toml"}, {.directory = in.path()});
  INFO(done.err);
  REQUIRE(done.status == 0);
  CHECK_THAT(done.out + done.err, Contains("room-mesh.ply"));
  const auto merged = run_program({"generate", "room", "--points", "20000", "-o", "merged.ply"},
                                  {.directory = in.path()});
  REQUIRE(merged.status == 0);
  std::size_t separate = 0;
  for (const char* name : {"room_0.ply", "room_1.ply", "room_2.ply", "room_3.ply"})
    separate += read_all(*open_point_source(in / name)).size();
  CHECK(read_all(*open_point_source(in / "merged.ply")).size() == separate);
}

TEST_CASE("TwoComponentsComeWithTheirTrueSurfaceAndCloseByDefault") {
  const ScratchDirectory in;
  CHECK_THAT(run_in(in, {"generate", "--help"}).out, Contains("two-components"));
  for (const char* name : {"a.ply", "b.ply"})
    REQUIRE(run_in(in, {"generate", "two-components", "--points", "3000", "-o", name, "--truth",
                        "truth.ply"})
                .status == 0);
  CHECK(file_text(in / "a.ply") == file_text(in / "b.ply"));
  REQUIRE(run_in(in, {"reconstruct", "a.ply", "-o", "mesh.ply"}).status == 0);
  for (const char* mesh : {"truth.ply", "mesh.ply"}) {
    const auto facts = nlohmann::json::parse(run_in(in, {"inspect", mesh, "--json"}).out);
    CHECK(facts["watertight"] == true);
    CHECK(facts["components"] == 2);
    CHECK(facts["euler_characteristic"] == 2);
  }
}

TEST_CASE("TheTrueSurfaceIsNotWrittenToStandardOutput") {
  const ScratchDirectory in;
  for (const char* shape : {"sphere", "room"})
    for (const char* out : {"cloud.ply", "-"}) {
      const auto refused =
          run_in(in, {"generate", shape, "--points", "1000", "-o", out, "--truth", "-"});
      CHECK(refused.status == 2);
      CHECK(refused.out.empty());
      CHECK_THAT(refused.err, Contains("--truth: ") && Contains("the name of a file"));
    }
  CHECK(names_in(in).empty());
}

TEST_CASE("OptionsOfScenesAndOfShapesAreToldApart") {
  const ScratchDirectory in;
  const auto result = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "generate");
    words.insert(words.end(), {"--points", "2000", "-o", "a.ply"});
    return run_program(words, {.directory = in.path()});
  };
  CHECK(result({"room", "--scans", "6"}).status == 2);
  CHECK(result({"house", "--density", "varying"}).status == 2);
  CHECK(result({"sphere", "--undisturbed"}).status == 2);
  const auto growth = result({"torus", "--noise-growth", "2"});
  CHECK(growth.status == 2);
  CHECK_THAT(growth.err, Contains("--noise-growth is an option of scenes"));
  CHECK(result({"rom"}).status == 2);
  CHECK_THAT(result({"rom"}).err, Contains("Did you mean 'room'?"));
  CHECK(std::filesystem::is_empty(in.path()));
}
