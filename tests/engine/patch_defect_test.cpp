#include <catch2/catch.hpp>
#include <cmath>

#include "engine/holes/fill_hole.h"
#include "engine/holes/patch/patch_defect.h"

using orbweave::FillMethod;
using orbweave::HolePatch;
using orbweave::HoleProblem;
using orbweave::patch_defect;
using orbweave::Vec3;

namespace {

/// A square rim 0..3 in a sheet of eight triangles around it, filled about a new vertex 8.
struct Filled {
  HoleProblem problem;
  HolePatch patch;
};

Filled filled_square() {
  Filled filled;
  HoleProblem& problem = filled.problem;
  problem.positions = {{0, 0, 0},   {1, 0, 0},  {1, 1, 0}, {0, 1, 0},
                       {-1, -1, 0}, {2, -1, 0}, {2, 2, 0}, {-1, 2, 0}};
  problem.normals.assign(8, {0, 0, 1});
  problem.loop = {0, 1, 2, 3};
  problem.sheet = {{1, 0, 4}, {4, 5, 1}, {2, 1, 5}, {5, 6, 2},
                   {3, 2, 6}, {6, 7, 3}, {0, 3, 7}, {7, 4, 0}};
  HolePatch& patch = filled.patch;
  patch.method = FillMethod::kDirect;
  patch.positions = {{0.5, 0.5, 0}};
  patch.normals = {{0, 0, 1}};
  patch.triangles = {{0, 1, 8}, {1, 2, 8}, {2, 3, 8}, {3, 0, 8}};
  return filled;
}

std::string defect(const Filled& filled) { return patch_defect(filled.problem, filled.patch); }

}  // namespace

TEST_CASE("SoundPatchHasNoDefect") {
  Filled filled = filled_square();
  CHECK(defect(filled) == "");
  filled.patch.positions.clear();
  filled.patch.normals.clear();
  filled.patch.triangles = {{0, 1, 2}, {0, 2, 3}};
  CHECK(defect(filled) == "");
}

TEST_CASE("HoleThatStaysOpenHasNoPatch") {
  Filled filled = filled_square();
  filled.patch.method = FillMethod::kNone;
  CHECK(defect(filled) == "triangles of a hole that stays open");
  CHECK(patch_defect(filled.problem, HolePatch{}) == "");
}

TEST_CASE("DefectsOfTheRimAreSeen") {
  Filled filled = filled_square();
  SECTION("a missing triangle") {
    filled.patch.triangles.pop_back();
    CHECK(defect(filled) == "edge 3-8 is a boundary that is not the loop's");
  }
  SECTION("the wrong side out") {
    for (auto& t : filled.patch.triangles) std::swap(t[0], t[1]);
    CHECK(defect(filled) == "edge 0-3 runs against the loop");
  }
  SECTION("an open rim edge, the edge cut short") {
    filled.problem.loop = {0, 1, 2, 7, 3};
    CHECK(defect(filled) == "edge 2-3 is a boundary that is not the loop's");
  }
  SECTION("a rim edge used from both sides") {
    filled.patch.positions.push_back({0.5, -1, 0});
    filled.patch.normals.push_back({0, 0, 1});
    filled.patch.triangles.push_back({1, 0, 9});
    CHECK(defect(filled) == "edge 0-9 is a boundary that is not the loop's");
  }
  SECTION("nothing there") {
    filled.patch = {};
    filled.patch.method = FillMethod::kPlane;
    CHECK(defect(filled) == "rim edge 0-1 stays open");
  }
}

TEST_CASE("ForbiddenAndRepeatedEdgesAreSeen") {
  Filled filled = filled_square();
  filled.patch.positions.clear();
  filled.patch.normals.clear();
  filled.patch.triangles = {{0, 1, 2}, {0, 2, 3}};
  SECTION("a forbidden chord") {
    filled.problem.forbidden = {{0, 2}};
    CHECK(defect(filled) == "edge 0-2 is forbidden");
    filled.problem.forbidden = {{0, 1}, {1, 3}};  // rim edges may be used as such
    CHECK(defect(filled) == "");
  }
  SECTION("a chord of vertices that another hole has as well") {
    filled.problem.apart = {{0, 1}, {0, 4}, {1, 1}, {2, 3}, {2, 4}};
    CHECK(defect(filled) == "edge 0-2 is forbidden");
    filled.problem.apart = {{0, 1}, {1, 1}, {1, 4}, {2, 3}, {2, 4}};
    CHECK(defect(filled) == "");
  }
  SECTION("a chord that the sheet has") {
    filled.problem.sheet.push_back({2, 0, 6});
    CHECK(defect(filled) == "edge 0-2 is in the sheet already");
  }
  SECTION("a triangle twice") {
    filled.patch.triangles.push_back({0, 1, 2});
    CHECK(defect(filled) == "edge 0-1 is used twice in one direction");
  }
}

TEST_CASE("DefectsOfVerticesAreSeen") {
  Filled filled = filled_square();
  SECTION("a triangle with equal corners") {
    filled.patch.triangles.push_back({0, 8, 8});
    CHECK(defect(filled) == "a triangle with equal corners");
  }
  SECTION("a vertex that does not exist") {
    filled.patch.triangles.push_back({0, 1, 9});
    CHECK(defect(filled) == "vertex 9 does not exist");
  }
  SECTION("a given vertex that is not on the rim") {
    for (auto& t : filled.patch.triangles) t[2] = 6;
    CHECK(defect(filled) == "vertex 6 is not on the rim");
  }
  SECTION("a new vertex that is not used") {
    filled.patch.positions.push_back({0.5, 0.5, 1});
    filled.patch.normals.push_back({0, 0, 1});
    CHECK(defect(filled) == "new vertex 1 is not used");
  }
  SECTION("positions, normals and values") {
    filled.patch.normals.clear();
    CHECK(defect(filled) == "not one normal per new vertex");
    filled.patch.normals = {{0, 0, INFINITY}};
    CHECK(defect(filled) == "a normal that is not finite");
    filled.patch.normals = {{0, 0, 1}};
    filled.patch.positions[0].y = NAN;
    CHECK(defect(filled) == "a position that is not finite");
    filled.patch.positions[0].y = 0.5;
    filled.problem.channels = 2;
    CHECK(defect(filled) == "not all values per new vertex");
    filled.patch.values = {1.0, NAN};
    CHECK(defect(filled) == "a value that is not finite");
    filled.patch.values = {1.0, 2.0};
    CHECK(defect(filled) == "");
  }
}

TEST_CASE("PinchedVerticesAndLoosePiecesAreSeen") {
  Filled filled = filled_square();
  const auto add_vertices = [&](int count) {
    for (int i = 0; i < count; ++i) {
      filled.patch.positions.push_back({0.1 * i, 0.5, 1});
      filled.patch.normals.push_back({0, 0, 1});
    }
  };
  SECTION("a closed surface of its own") {
    add_vertices(4);
    for (const orbweave::Triangle& t :
         {orbweave::Triangle{9, 10, 11}, {9, 12, 10}, {10, 12, 11}, {11, 12, 9}}) {
      filled.patch.triangles.push_back(t);
    }
    CHECK(defect(filled) == "a piece that does not touch the rim");
  }
  SECTION("a closed surface that hangs on a new vertex") {
    add_vertices(3);
    for (const orbweave::Triangle& t :
         {orbweave::Triangle{8, 9, 10}, {8, 11, 9}, {9, 11, 10}, {10, 11, 8}}) {
      filled.patch.triangles.push_back(t);
    }
    CHECK(defect(filled) == "vertex 8 has several fans");
  }
  SECTION("a closed surface that hangs on the rim") {
    add_vertices(3);
    for (const orbweave::Triangle& t :
         {orbweave::Triangle{1, 9, 10}, {1, 11, 9}, {9, 11, 10}, {10, 11, 1}}) {
      filled.patch.triangles.push_back(t);
    }
    CHECK(defect(filled) == "vertex 1 has several fans");
  }
}

TEST_CASE("BridgeEdgesAreInside") {
  // A square 0..3 around a triangle 4 5 6 (an island, its loop the other way around); 2-4 is the
  // bridge between them.
  HoleProblem problem;
  problem.positions = {{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}, {6, 6, 0}, {6, 3, 0}, {3, 5, 0}};
  problem.loop = {0, 1, 2, 4, 5, 6, 4, 2, 3};
  problem.sheet = {{5, 4, 6}};
  problem.forbidden = {{2, 4}};
  HolePatch patch;
  patch.method = FillMethod::kPlane;
  patch.triangles = {{0, 1, 5}, {1, 2, 5}, {2, 4, 5}, {0, 5, 6}, {0, 6, 3}, {6, 4, 3}, {4, 2, 3}};
  CHECK(patch_defect(problem, patch) == "");
  // The bridge closed from one side only.
  patch.triangles.pop_back();
  CHECK(patch_defect(problem, patch) != "");
}

TEST_CASE("EndOfASlitHasAClosedFan") {
  HoleProblem problem;
  problem.positions = {{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}, {5, 5, 0}};
  problem.loop = {0, 1, 2, 4, 2, 3};
  HolePatch patch;
  patch.method = FillMethod::kPlane;
  patch.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  CHECK(patch_defect(problem, patch) == "");
}

TEST_CASE("LoopThatVisitsAVertexTwiceHasTwoOpenFansThere") {
  // Two triangles that share vertex 0.
  HoleProblem problem;
  problem.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  problem.loop = {0, 1, 2, 0, 3, 4};
  HolePatch patch;
  patch.method = FillMethod::kDirect;
  patch.triangles = {{0, 1, 2}, {0, 3, 4}};
  CHECK(patch_defect(problem, patch) == "");
}
