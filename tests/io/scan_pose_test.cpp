// Poses: their notations, and what they do to points.
#include "io/points/scan_pose.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "io/clouds/scan_source.h"
#include "io/error.h"
#include "io/points/point_views.h"
#include "tests/support/clouds.h"

using Catch::Matchers::Contains;
using namespace orbweave;

namespace {

void check_near(Vec3 a, Vec3 b) {
  INFO(a.x << " " << a.y << " " << a.z);
  CHECK(norm(a - b) < 1e-12 * (1.0 + norm(b)));
}

const double kHalf = std::sqrt(0.5);

}  // namespace

TEST_CASE("AQuaternionTurnsColumnVectorsAndAStanfordOneRowVectors") {
  // A quarter turn about z takes x to y.
  const ScanPose plain =
      parse_pose("a.ply 1 2 3 0 0 " + std::to_string(kHalf) + " " + std::to_string(kHalf));
  CHECK(plain.file == "a.ply");
  CHECK(norm(plain.motion.point({1, 0, 0}) - Vec3{1, 3, 3}) < 1e-6);
  const auto stanford = parse_stanford_poses(
      "camera 0 0 0 0 0 0 1\nbmesh a.ply 1 2 3 0 0 1 1\nmesh whole.ply\n", "x.conf");
  REQUIRE(stanford.size() == 1);
  check_near(stanford[0].motion.point({1, 0, 0}), {1, 1, 3});
}

TEST_CASE("AByteOrderMarkHidesNoPose") {
  const auto poses = parse_stanford_poses(
      "\xEF\xBB\xBF"
      "bmesh a.ply 1 2 3 0 0 0 1\r\nbmesh b.ply 4 5 6 0 0 0 1\r\n",
      "x.conf");
  REQUIRE(poses.size() == 2);
  CHECK(poses[0].file == "a.ply");
}

TEST_CASE("AQuaternionOfAnyLengthTurnsAlike") {
  const RigidMotion turn = parse_pose("a 1 2 3 2 1 0 3").motion;
  for (const char* scaled : {"a 1 2 3 2e-162 1e-162 0 3e-162", "a 1 2 3 2e-300 1e-300 0 3e-300",
                             "a 1 2 3 2e200 1e200 0 3e200"}) {
    CAPTURE(scaled);
    const RigidMotion motion = parse_pose(scaled).motion;
    check_near(motion.point({4, 5, 6}), turn.point({4, 5, 6}));
  }
}

TEST_CASE("AMatrixIsAppliedToColumnVectors") {
  const ScanPose pose = parse_pose("s.ptx 0 -1 0 10  1 0 0 20  0 0 1 30  0 0 0 1");
  check_near(pose.motion.point({1, 2, 3}), {8, 21, 33});
  check_near(pose.motion.direction({1, 0, 0}), {0, 1, 0});
}

TEST_CASE("TheNameOfAScanMayHoldBlanks") {
  CHECK(parse_pose("a 1 2 3 2 1 0 3").motion == parse_pose("Scan 001.ply 1 2 3 2 1 0 3").motion);
  CHECK(parse_pose("  old  scans/Scan 001.ply\t1 2 3 0 0 0 1 ").file == "old  scans/Scan 001.ply");
  CHECK(parse_pose("1 1 2 3 0 0 0 1").file == "1");
  const ScanPose matrix = parse_pose("my scan.ply 1 0 0 5  0 1 0 6  0 0 1 7  0 0 0 1");
  CHECK(matrix.file == "my scan.ply");
  CHECK(matrix.motion.translation == Vec3{5, 6, 7});
  const auto stanford = parse_stanford_poses("\tbmesh my bmesh.ply 1 2 3 0 0 0 1\r\n", "x.conf");
  REQUIRE(stanford.size() == 1);
  CHECK(stanford[0].file == "my bmesh.ply");
  CHECK(stanford[0].motion.translation == Vec3{1, 2, 3});
  CHECK_THROWS_WITH(parse_pose("a 1 2 3 0 0 0 1 5"), Contains("9 words"));
  CHECK_THROWS_WITH(parse_pose("my scan.ply 1 2 3 0 0 0 x"), Contains("9 words"));
}

TEST_CASE("WhatIsNoRigidMotionIsRefusedWithTheReason") {
  CHECK_THROWS_WITH(parse_pose("a 2 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), Contains("length one"));
  CHECK_THROWS_WITH(parse_pose("a -1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), Contains("mirrors"));
  CHECK_THROWS_WITH(parse_pose("a 1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1"), Contains("last row"));
  CHECK_THROWS_WITH(parse_pose("a 0 0 0 0 0 0 0"), Contains("quaternion"));
  CHECK_THROWS_WITH(parse_pose("a 0 0 0 0 0 0 x"), Contains("\"x\" is no number"));
  CHECK_THROWS_WITH(parse_pose("a 0 0 0"), Contains("4 words"));
  CHECK_THROWS_WITH(parse_stanford_poses("\nbmesh a.ply 0 0 0 0 0 0 inf\n", "p.conf"),
                    Contains("p.conf: line 2"));
  CHECK_THROWS_WITH(parse_stanford_poses("camera 1\n", "p.conf"), Contains("no pose of any scan"));
}

TEST_CASE("APoseIsFoundByPathThenByNameAndHasToBeThere") {
  const RigidMotion one = parse_pose("x 1 0 0 0 0 0 1").motion;
  const RigidMotion two = parse_pose("x 2 0 0 0 0 0 1").motion;
  const std::vector<ScanPose> poses = {{"a/s.ply", one}, {"b/s.ply", two}, {"t.ply", two}};
  CHECK(pose_of_scan(poses, "a/s.ply") == one);
  CHECK(pose_of_scan(poses, "b/s.ply") == two);
  CHECK(pose_of_scan(poses, "deep/t.ply") == two);
  CHECK(pose_of_scan({}, "any.ply") == RigidMotion{});
  CHECK_THROWS_WITH(pose_of_scan(poses, "c/s.ply"), Contains("two poses for one scan"));
  CHECK_THROWS_WITH(pose_of_scan(poses, "u.ply"), Contains("no pose for this scan"));
}

TEST_CASE("APoseNamedByPathIsFoundFromAnyFolder") {
  const RigidMotion one = parse_pose("x 1 0 0 0 0 0 1").motion;
  const RigidMotion two = parse_pose("x 2 0 0 0 0 0 1").motion;
  const std::vector<ScanPose> poses = {{"s1/cloud.ply", one}, {"../data/s2/cloud.ply", two}};
  for (const std::string folder : {"", "./", "jobs/../data/", "/home/user/data/", "../data/"}) {
    CAPTURE(folder);
    CHECK(pose_of_scan(poses, folder + "s1/cloud.ply") == one);
    CHECK(pose_of_scan(poses, folder + "s2/cloud.ply") == two);
  }
  const std::vector<ScanPose> whole = {{"/data/s1/cloud.ply", one}, {"/data/s2/cloud.ply", two}};
  CHECK(pose_of_scan(whole, "s1/cloud.ply") == one);
  CHECK(pose_of_scan(whole, "../s2/cloud.ply") == two);
  CHECK_THROWS_WITH(pose_of_scan(whole, "s3/cloud.ply"), Contains("two poses for one scan"));
  const std::vector<ScanPose> nested = {{"cloud.ply", one}, {"s2/cloud.ply", two}};
  for (const std::string folder : {"", "data/"}) {
    CAPTURE(folder);
    CHECK(pose_of_scan(nested, folder + "cloud.ply") == one);
    CHECK(pose_of_scan(nested, folder + "s2/cloud.ply") == two);
  }
}

TEST_CASE("NoPoseIsTakenForTwoScans") {
  using Strings = std::vector<std::string>;
  const RigidMotion one = parse_pose("x 1 0 0 0 0 0 1").motion;
  const std::vector<ScanPose> by_path = {{"day1/s.ply", one}};
  CHECK_THROWS_WITH(require_own_poses(by_path, Strings{"day1/s.ply", "day2/s.ply"}),
                    Contains("day2/s.ply: two scans for one pose") &&
                        Contains("found the pose of day1/s.ply, which day1/s.ply has"));
  CHECK_THROWS_WITH(require_own_poses({{"s.ply", one}}, Strings{"day1/s.ply", "day2/s.ply"}),
                    Contains("Name both by their paths"));
  CHECK_NOTHROW(require_own_poses(by_path, Strings{"elsewhere/s.ply"}));
  CHECK_NOTHROW(require_own_poses(by_path, Strings{"day1/s.ply", "./day1/s.ply"}));
  CHECK_NOTHROW(require_own_poses({{"day1/s.ply", one}, {"day2/s.ply", one}},
                                  Strings{"day1/s.ply", "day2/s.ply"}));
  CHECK_NOTHROW(require_own_poses({}, Strings{"day1/s.ply", "day2/s.ply"}));
}

TEST_CASE("AViewKeepsItsDirection") {
  test::Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 d = random.direction();
    const ViewCode code = encode_view((0.001 + 1e6 * random.uniform()) * d);
    REQUIRE(code.known());
    CHECK(norm(decode_view(code) - d) < 1e-4);
  }
  for (const Vec3 axis : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}})
    CHECK(decode_view(encode_view(axis)) == axis);
  CHECK(!encode_view({}).known());
}
