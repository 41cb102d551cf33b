// Where the coordinates of a mesh file are counted from.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "io/error.h"
#include "io/job/output_origin.h"
#include "io/meshes/shift_file.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;

namespace orbweave {
namespace {

const Box kUtm{{512'300.5, 4'176'100.25, 1500}, {512'380.5, 4'176'170.25, 1530}};

std::string message_of(const Job& job, const OutputOrigin& chosen) {
  try {
    check_output_origin(job, chosen);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("FloatsMoveNoPointOfABoxByMoreThanIsSaid") {
  test::Random random(7);
  for (const Vec3 origin : {Vec3{}, Vec3{512'340, 4'176'140, 0}}) {
    const double most = largest_float_move(kUtm, origin);
    double seen = 0.0;
    for (int i = 0; i < 20'000; ++i) {
      Vec3 p = kUtm.min;
      for (int axis = 0; axis < 3; ++axis) p[axis] += random.uniform() * kUtm.extent()[axis];
      Vec3 narrow;
      for (int axis = 0; axis < 3; ++axis)
        narrow[axis] = static_cast<double>(static_cast<float>(p[axis] - origin[axis]));
      seen = std::max(seen, norm(narrow + origin - p));
    }
    CHECK(seen <= most);
    CHECK(seen > 0.5 * most);
  }
}

TEST_CASE("AnOriginIsChosenOnlyWhereFloatsWouldMoveVertices") {
  OutputOptions output;
  CHECK(output_origin(output, false, kUtm, 0.05).origin == Vec3{});
  const OutputOrigin chosen = output_origin(output, true, kUtm, 0.05);
  // Heights of 1500 lose too much as well at that spacing.
  CHECK(chosen.origin == Vec3{512'341, 4'176'135, 1515});
  CHECK(chosen.largest_move <= 0.05e-3);
  // Coarse points in the same place: the heights may stay as they are.
  CHECK(output_origin(output, true, kUtm, 0.5).origin == Vec3{512'341, 4'176'135, 0});
  CHECK(output_origin(output, true, {{-1, -1, -1}, {1, 1, 1}}, 0.01).origin == Vec3{});
  const Box small{{512'300.501, 4'176'100.25, 15}, {512'300.541, 4'176'100.27, 15.02}};
  const OutputOrigin of_small = output_origin(output, true, small, 1e-5);
  CHECK(of_small.origin == Vec3{512'300.521, 4'176'100.26, 15});
  CHECK(of_small.largest_move <= 1e-8);
  CHECK(output_origin(output, true, kUtm, 0.0).origin.x != 0.0);  // spacing unknown
  CHECK(output_origin(output, true, Box{}, 0.1).origin == Vec3{});
}

TEST_CASE("AGivenOriginHoldsInEveryFormat") {
  OutputOptions output;
  output.origin_rule = OriginRule::kGiven;
  output.origin = {500'000, 4'000'000, 0};
  CHECK(output_origin(output, false, kUtm, 0.05).origin == output.origin);
  CHECK(output_origin(output, true, kUtm, 0.05).origin == output.origin);
  CHECK(output_origin(output, true, kUtm, 0.05).largest_move > 0.0);
}

TEST_CASE("FloatsThatLoseTooMuchAreRefusedWithTheFigure") {
  Job job;
  job.output.mesh = "m.stl";
  job.output.origin_rule = OriginRule::kNone;
  CHECK_THAT(message_of(job, output_origin(job.output, true, kUtm, 0.05)),
             Contains("m.stl") && Contains("output.origin") && Contains("up to 0.125973") &&
                 Contains("2.51946 of the point spacing") &&
                 Contains("at most a thousandth of the spacing 0.05") &&
                 Contains("output.origin = \"auto\""));
  CHECK(message_of(job, output_origin(job.output, true, kUtm, 400.0)).empty());
  job.output.origin_rule = OriginRule::kAuto;
  CHECK(check_output_origin(job, output_origin(job.output, true, kUtm, 0.05)).empty());
  const Box corridor{{0, 0, 0}, {40'000, 300, 20}};
  CHECK_THAT(check_output_origin(job, output_origin(job.output, true, corridor, 0.05)),
             Contains("of the point spacing") && Contains("keeps doubles"));
  const Box with_strays{{0, 0, 0}, {1e7, 300, 20}};
  CHECK_THAT(message_of(job, output_origin(job.output, true, with_strays, 0.05)),
             Contains("at most a tenth of the spacing"));
}

TEST_CASE("CoordinatesBeyondTheRangeOfFloatsAreRefused") {
  const test::ScratchDirectory in;
  for (const char* unit : {"e80", "e39", "e-46", "e-80"}) {
    const std::string one = std::string("1") + unit;
    test::write_text(in / "a.obj", "v 0 0 0\nv " + one + " 0 0\nv 0 " + one + " 0\nf 1 2 3\n");
    for (const char* file : {"b.stl", "b.glb"}) {
      INFO(unit << " " << file);
      const test::ProgramResult result = test::run_in(in, {"convert", "a.obj", file});
      CHECK(result.status == 2);
      CHECK_THAT(result.err, Contains("the floats of the mesh file") && Contains("keeps doubles"));
    }
    CHECK(test::run_in(in, {"convert", "a.obj", "b.ply"}).status == 0);
  }
  CHECK(test::names_in(in) == std::vector<std::string>{"a.obj", "b.ply"});
  test::write_text(in / "a.obj", "v 0 0 0\nv 1e38 0 0\nv 0 1e38 0\nf 1 2 3\n");
  CHECK(test::run_in(in, {"convert", "a.obj", "b.stl"}).status == 0);
}

TEST_CASE("DoublesFarFromAGivenOriginAreRefusedAsFloatsAre") {
  Job job;
  job.output.mesh = "m.ply";
  job.output.origin_rule = OriginRule::kGiven;
  const Box unit{{-1, -1, -1}, {1, 1, 1}};
  const auto message_at = [&](Vec3 origin, double spacing) {
    job.output.origin = origin;
    return message_of(job, output_origin(job.output, false, unit, spacing));
  };
  CHECK_THAT(message_at({1e20, 0, 0}, 0.05),
             Contains("the doubles of the mesh file") && Contains("m.ply") &&
                 Contains("output.origin") && Contains("at most a tenth of the spacing 0.05") &&
                 Contains("output.origin = \"auto\" keeps the coordinates as they are"));
  CHECK_THAT(message_at({0, 1e15, 0}, 0.05), Contains("up to 0.0625, which is 1.25"));
  CHECK_THAT(message_at({1e308, 0, -1e308}, 0.05), Contains("up to"));
  CHECK_THAT(message_at({1e20, 0, 0}, 0.0), Contains("at most a ten-thousandth of the extent 2"));
  CHECK(message_at({1e6, 0, 0}, 0.05).empty());
  CHECK(message_at({1e6, 0, 0}, 0.0).empty());
  job.output.origin = {1e13, 0, 0};
  CHECK_THAT(check_output_origin(job, output_origin(job.output, false, unit, 0.05)),
             Contains("the doubles of m.ply move its vertices by up to 0.000976"));
}

TEST_CASE("NoCommandLosesCoordinatesToAnOriginFarAway") {
  const test::ScratchDirectory in;
  REQUIRE(test::run_in(
              in, {"generate", "sphere", "--points", "2000", "-o", "s.ply", "--truth", "t.ply"})
              .status == 0);
  using Command = std::vector<std::string>;
  for (const Command& command :
       {Command{"reconstruct", "s.ply", "-o", "m.ply"}, Command{"convert", "s.ply", "m.ply"},
        Command{"convert", "t.ply", "m.obj"}, Command{"fill", "t.ply", "-o", "m.ply"},
        Command{"simplify", "t.ply", "-o", "m.ply", "--triangles", "500"}})
    for (const char* origin : {"1e20,0,0", "0,0,1e16"}) {
      INFO(command[0] << " " << origin);
      Command whole = command;
      whole.insert(whole.end(), {"--origin", origin});
      const test::ProgramResult result = test::run_in(in, whole);
      CHECK(result.status == 2);
      CHECK_THAT(result.err, Contains("doubles of the mesh file would move its vertices"));
      CHECK_FALSE(std::filesystem::exists(in / "m.ply"));
      CHECK_FALSE(std::filesystem::exists(in / "m.obj"));
    }
  CHECK(test::run_in(in, {"convert", "s.ply", "c.ply", "--origin", "1000,0,0"}).status == 0);
}

TEST_CASE("TilesCountedFromAnOriginAreReadWhereTheyLieInTheWorld") {
  const test::ScratchDirectory in;
  std::string scan;
  for (int i = 0; i < 400; ++i)
    scan +=
        std::to_string(512'300 + i % 20) + " " + std::to_string(4'176'100 + i / 20) + " 5 0 0 1\n";
  test::write_text(in / "s.xyz", scan);
  const std::string cells = GENERATE("0", "10");
  REQUIRE(test::run_in(in, {"reconstruct", "s.xyz", "-o", "m.ply", "--tiles", "--tile-size", cells,
                            "--origin", "512300,4176100,0"})
              .status == 0);
  std::string tile;
  for (const auto& entry : std::filesystem::directory_iterator(in / "m.tiles"))
    if (entry.path().extension() == ".ply") tile = entry.path();
  CHECK(origin_beside(tile) == Vec3{512'300, 4'176'100, 0});
  const auto converted = test::run_in(in, {"convert", tile, "tile.xyz"});
  CHECK(converted.err.empty());
  CHECK_THAT(test::file_text(in / "tile.xyz"), Contains("512310 4176110 5 "));
  // Alone it tells of an origin, and nobody else does.
  std::filesystem::copy_file(tile, in / "alone.ply");
  CHECK(origin_beside(in / "alone.ply") == Vec3{});
  CHECK_THAT(test::run_in(in, {"convert", "alone.ply", "alone.xyz"}).err, Contains("as they are"));
  std::filesystem::copy_file(tile, in / "m.tiles" / "other.ply");
  test::write_text(in / "m.tiles" / "tiles.json",
                   "{\"format\": \"orbweave tiles\", \"tiles\": []}");
  CHECK(origin_beside(in / "m.tiles" / "other.ply") == Vec3{});
}

TEST_CASE("AShiftFileIsReadBackAsItWasWritten") {
  const test::ScratchDirectory scratch;
  const Vec3 origin{512'340, 4'176'135.125, 0};
  CHECK(write_shift(scratch / "a;b.stl", origin) == scratch / "a;b.stl.shift.txt");
  CHECK_THAT(test::file_text(scratch / "a;b.stl.shift.txt"),
             Contains("\na_b.stl; -512340; -4176135.125; 0; 1;\n"));
  CHECK(origin_beside(scratch / "a;b.stl") == origin);
  // A later mesh of that name without an origin is not to be moved by the earlier one's.
  CHECK_FALSE(write_shift(scratch / "a;b.stl", {}).empty());
  CHECK(origin_beside(scratch / "a;b.stl") == Vec3{});
  CHECK(write_shift(scratch / "other.stl", {}).empty());
  CHECK_FALSE(std::filesystem::exists(scratch / "other.stl.shift.txt"));
  test::write_text(scratch / "bad.stl.shift.txt", "a; 1; x; 3; 1;\n");
  CHECK_THROWS_WITH(origin_beside(scratch / "bad.stl"), Contains("bad.stl.shift.txt"));
  // A list of several files, with the mark of Windows: the line of the name counts.
  test::write_text(
      scratch / "list.stl.shift.txt",
      "\xEF\xBB\xBF// a list\r\n\r\nother.stl; 1; 2; 3; 1;\r\nlist.stl; 4; 5; 6; 1;\r\n");
  CHECK(origin_beside(scratch / "list.stl") == Vec3{-4, -5, -6});
  test::write_text(scratch / "same.stl.shift.txt", "a; 1; 2; 3; 1;\nb; 1; 2; 3; 1;\n");
  CHECK(origin_beside(scratch / "same.stl") == Vec3{-1, -2, -3});
  test::write_text(scratch / "two.stl.shift.txt", "a; 1; 2; 3; 1;\nb; 1; 2; 4; 1;\n");
  CHECK_THROWS_WITH(
      origin_beside(scratch / "two.stl"),
      Contains("two.stl.shift.txt: holds several shifts, and which is that of "
               "two.stl is not said; found \"a; 1; 2; 3; 1;\" and \"b; 1; 2; 4; 1;\""));
  test::write_text(scratch / "worse.stl.shift.txt", "a; 1; 2; 3; 1;\nb; 1; 2;\n");
  CHECK_THROWS_WITH(origin_beside(scratch / "worse.stl"),
                    Contains("worse.stl.shift.txt: line 2") && Contains("found \"b; 1; 2;\""));
  test::write_text(scratch / "scaled.stl.shift.txt", "a; 1; 2; 3; 0.5;\n");
  CHECK_THROWS_AS(origin_beside(scratch / "scaled.stl"), Error);
}

}  // namespace orbweave
