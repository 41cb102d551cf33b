// Paths of scanners that moved: what they say between their places, and how files of them are read.
#include "io/clouds/trajectory.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>
#include <string>

#include "io/clouds/scan_source.h"
#include "io/clouds/text_source.h"
#include "io/clouds/trajectory_file.h"
#include "io/error.h"
#include "io/points/point_views.h"
#include "tests/support/program.h"

namespace orbweave::test {
namespace {

using Catch::Matchers::Contains;

Trajectory read_text(const std::string& text) {
  return read_trajectory_text(
      ByteReader(memory_byte_source(std::as_bytes(std::span(text)), "path.txt")));
}

bool is_near(const std::optional<Vec3>& place, Vec3 expected) {
  return place && norm(*place - expected) < 1e-6;
}

/// Ten metres a second along x, from x = 0 at `first` on, for `seconds`; a place each second.
std::vector<Trajectory::Place> drive(double first, int seconds) {
  std::vector<Trajectory::Place> places;
  for (int i = 0; i <= seconds; ++i) places.push_back({first + i, {10.0 * i, 5.0, 2.0}});
  return places;
}

/// The view of each point of a text cloud x y z time.
std::vector<ViewCode> views_of(const std::string& text, const Trajectory& path,
                               DroppedPoints& left_out) {
  ScanOptions options;
  options.with_view = true;
  options.trajectory = std::make_shared<const Trajectory>(path);
  const auto source = open_scan_source(
      open_text_source(ByteReader(memory_byte_source(std::as_bytes(std::span(text)), "a.txt")), {},
                       TextKind::kAny),
      options, "a.txt");
  const PointCloud cloud = read_all(*source);
  left_out = source->left_out();
  std::vector<ViewCode> views(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    std::memcpy(&views[i], cloud.attribute_row(i).data() + *view_offset(cloud.schema),
                sizeof(ViewCode));
  return views;
}

}  // namespace

TEST_CASE("AScannerMovesEvenlyBetweenTwoPlacesOfItsPath") {
  const Trajectory path(drive(100.0, 60));
  CHECK(is_near(path.at(100.0), {0, 5, 2}));
  CHECK(is_near(path.at(130.25), {302.5, 5, 2}));
  CHECK(is_near(path.at(160.0), {600, 5, 2}));
  // A few steps before its first and behind its last place it stands there.
  CHECK(is_near(path.at(95.0), {0, 5, 2}));
  CHECK(is_near(path.at(165.0), {600, 5, 2}));
  CHECK_FALSE(path.at(91.0));
  CHECK_FALSE(path.at(169.0));
  CHECK_FALSE(path.at(std::nan("")));
}

TEST_CASE("AtTheTimeOfAPlaceTheScannerIsThereToTheLastDigit") {
  const std::vector<Trajectory::Place> places = {{330.0, {7411999.7, 3025411999.9, 302.0}},
                                                 {1599.5, {439509.5, 7411999.7, 302.0}},
                                                 {1600.5, {439509.9, 7411999.1, 302.3}}};
  const Trajectory path(places);
  for (const Trajectory::Place& place : places) CHECK(path.at(place.time) == place.position);
}

TEST_CASE("TheOrderOfThePlacesOfAPathDoesNotMatter") {
  std::vector<Trajectory::Place> places = drive(7.0, 400);
  const Trajectory path(places);
  std::ranges::reverse(places);
  std::swap(places[3], places[300]);
  const Trajectory other(places);
  for (double time = 0.0; time < 420.0; time += 0.37) CHECK(path.at(time) == other.at(time));
}

TEST_CASE("ATimeIsFoundHoweverUnevenlyThePlacesLieInTime") {
  std::vector<Trajectory::Place> places;
  for (int i = 0; i < 2000; ++i) places.push_back({1e-4 * i, {1e-3 * i, 0, 0}});
  for (int i = 1; i < 50; ++i) places.push_back({0.2 + 0.01 * i, {2.0 + 0.1 * i, 0, 0}});
  const Trajectory path(places);
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    const double middle = 0.5 * (places[i].time + places[i + 1].time);
    CHECK(is_near(path.at(middle), 0.5 * (places[i].position + places[i + 1].position)));
    CHECK(is_near(path.at(places[i].time), places[i].position));
  }
}

TEST_CASE("AGapOfAPathIsBridgedWhereTheScannerStoodStillOrWentStraightOn") {
  std::vector<Trajectory::Place> places = drive(0.0, 60);
  // The next flight line, elsewhere.
  for (const Trajectory::Place& place : drive(300.0, 60))
    places.push_back({place.time, place.position + Vec3{0, 500, 0}});
  const Trajectory lines(places);
  CHECK(is_near(lines.at(330.0), {300, 505, 2}));
  CHECK_FALSE(lines.at(180.0));
  // A carried scanner whose path has a place every ten metres: it stood for four minutes.
  places = drive(0.0, 60);
  for (const Trajectory::Place& place : drive(300.0, 60))
    places.push_back({place.time, place.position + Vec3{600, 0, 0}});
  CHECK(is_near(Trajectory(places).at(180.0), {600, 5, 2}));
  // A path without the places that a straight line has no need of.
  places = drive(0.0, 60);
  for (const Trajectory::Place& place : drive(300.0, 60))
    places.push_back({place.time, place.position + Vec3{3000, 0, 0}});
  CHECK(is_near(Trajectory(places).at(180.0), {1800, 5, 2}));
}

TEST_CASE("SecondsOfTheWeekAndOfGpsAreOneClock") {
  constexpr double kWeek = 604'800.0;
  const double adjusted = 3.1e8, standard = adjusted + 1e9, of_week = std::fmod(standard, kWeek);
  const Vec3 place{300, 5, 2};
  for (const double path : {adjusted, standard, of_week})
    for (const double point : {adjusted, standard, of_week}) {
      INFO(path << " " << point);
      CHECK(is_near(Trajectory(drive(path, 60)).at(point + 30.0), place));
      CHECK_FALSE(Trajectory(drive(path, 60)).at(point + 3600.0));
    }
}

TEST_CASE("TrajectoriesOfUsualProgramsAreRead") {
  const Vec3 half{10.5, 20.0, 30.0};
  const auto middle = [](const std::string& text) { return read_text(text).at(1.5); };
  CHECK(is_near(middle("1 10 20 30\n2 11 20 30\n"), half));
  CHECK(is_near(middle("time x y z roll\n1 10 20 30 0.5\n\n2 11 20 30 0.5\n"), half));
  CHECK(is_near(
      middle("# timestamp tx ty tz qx qy qz qw\n1 10 20 30 0 0 0 1\n2 11 20 30 0 0 0 1\n"), half));
  CHECK(is_near(middle("%time x y z q0 q1 q2 q3\r\n1 10 20 30 0 0 0 1\r\n2 11 20 30 0 0 0 1\r\n"),
                half));
  CHECK(is_near(middle("\xEF\xBB\xBFx,y,z,Gps_Time\n10,20,30,1\n11,20,30,2\n"), half));
  CHECK(is_near(
      middle("Project: site\nGPS Time (s);Easting [m];Northing [m];Roll;Ellipsoid "
             "Height;Height [m]\n(s);(m);(m);(deg);(m);(m)\n1;10;20;0;77;30\n2;11;20;0;77;30\n"),
      half));
  CHECK(is_near(middle("2\t11\t20\t30\n1\t10\t20\t30\n"), half));
  // Two files, one behind the other.
  CHECK(is_near(middle("t,x,y,z\n1,10,20,30\nt,x,y,z\n2,11,20,30\n"), half));
}

TEST_CASE("TrajectoriesOfPointsWithTimesAreRead") {
  const ScratchDirectory in;
  write_text(in / "path.ply",
             "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
             "property double z\nproperty double gps_time\nend_header\n10 20 30 1\n11 20 30 2\n");
  CHECK(is_near(read_trajectory(in / "path.ply").at(1.5), {10.5, 20, 30}));
  write_text(in / "none.ply",
             "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n"
             "property double z\nend_header\n10 20 30\n");
  CHECK_THROWS_WITH(read_trajectory(in / "none.ply"), Contains("have no time"));
  // A name that no format of clouds has.
  write_text(in / "path.trj", "1 10 20 30\n2 11 20 30\n");
  CHECK(is_near(read_trajectory(in / "path.trj").at(1.5), {10.5, 20, 30}));
  CHECK_THROWS_WITH(read_trajectory(in / "missing.txt"), Contains("missing.txt"));
}

TEST_CASE("TrajectoriesThatAreNoneAreRefusedWithTheLine") {
  const auto fault = [](const std::string& text) {
    try {
      read_text(text);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kBadInput);
      return std::string(error.what());
    }
    return std::string("read");
  };
  CHECK_THAT(fault("1 10 20 30\n2 11 20\n"), Contains("path.txt: line 2, column 4") &&
                                                 Contains("the end of the line") &&
                                                 Contains("a number, the z"));
  CHECK_THAT(fault("1 10 20 30\n2 11 nan 30\n"), Contains("line 2, column 3") && Contains("nan"));
  CHECK_THAT(fault("1 10 20 30\n2 eleven 20 30\n"), Contains("column 2") && Contains("the x"));
  CHECK_THAT(fault("time,latitude,longitude,height\n1,48.1,9.2,300\n2,48.1,9.2,300\n"),
             Contains("line 1") && Contains("degrees of longitude and latitude"));
  for (const char* text : {"", "time x y z\n", "1 10 20 30\n", "1 10 20 30\n1 10 20 31\n"}) {
    INFO(text);
    CHECK_THAT(fault(text), Contains("fewer than two places"));
  }
  CHECK_THAT(fault("-1e308 0 0 0\n1e308 0 0 0\n"), Contains("too large"));
}

TEST_CASE("ALongTrajectoryIsThinnedEvenlyAndKeepsItsEnds") {
  constexpr int kLines = 450'000;
  std::string text;
  for (int i = 0; i < kLines; ++i) {
    const std::string number = std::to_string(i);
    text += number + " " + number + " 0 2\n";
  }
  const Trajectory path = read_text(text);
  CHECK(path.first_time() == 0.0);
  CHECK(path.last_time() == kLines - 1);
  for (double time = 0.0; time <= kLines - 1; time += 1234.5)
    CHECK(is_near(path.at(time), {time, 0, 2}));
}

TEST_CASE("PointsAreSeenFromWhereTheScannerWasAtTheirTime") {
  DroppedPoints left_out;
  const auto views = views_of("x y z time\n300 5 0 30\n300 5 9 30\n0 5 2 10\n1 1 1 999\n",
                              Trajectory(drive(0.0, 60)), left_out);
  REQUIRE(views.size() == 3);
  CHECK(norm(decode_view(views[0]) - Vec3{0, 0, 1}) < 1e-3);
  CHECK(norm(decode_view(views[1]) - Vec3{0, 0, -1}) < 1e-3);
  CHECK(norm(decode_view(views[2]) - Vec3{1, 0, 0}) < 1e-3);
  CHECK(left_out == DroppedPoints{{kOutsideTrajectory, 1}});
}

TEST_CASE("PointsWithoutATimeCannotFollowATrajectory") {
  DroppedPoints left_out;
  CHECK_THROWS_WITH(views_of("x y z\n300 5 0\n", Trajectory(drive(0.0, 60)), left_out),
                    Contains("the points have no time") && Contains("input.trajectory"));
}

}  // namespace orbweave::test
