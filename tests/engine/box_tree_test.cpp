// Which boxes meet a box, and which triangles a walk has met.
#include "engine/holes/patch/box_tree.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include "engine/holes/problem/triangle_marks.h"

namespace orbweave {
namespace {

/// Places with coordinates of one decimal: many boxes only touch.
Vec3 place(std::mt19937_64& random) {
  const auto coordinate = [&] {
    return std::floor(std::uniform_real_distribution(0.0, 40.0)(random)) / 10.0;
  };
  return {coordinate(), coordinate(), coordinate()};
}

std::vector<std::uint32_t> by_hand(const std::vector<Box>& boxes, const Box& box) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < boxes.size(); ++i)
    if (boxes[i].intersects(box)) found.push_back(i);
  return found;
}

TEST_CASE("ATreeFindsTheBoxesThatMeetABox") {
  std::mt19937_64 random(5);
  for (const std::size_t count : {0, 1, 2, 7, 8, 9, 17, 100, 1000}) {
    std::vector<Box> boxes(count);
    for (Box& box : boxes)
      for (int i = 0; i < 2; ++i) box.extend(place(random));
    const BoxTree tree(boxes);
    for (int i = 0; i < 200; ++i) {
      Box box;
      box.extend(place(random));
      if (i % 2 == 0) box.extend(box.min + Vec3{0.3, 0.3, 0.3});
      const std::vector<std::uint32_t> expected = by_hand(boxes, box);
      CHECK(tree.near(box) == expected);
      CHECK(tree.meets(box) == !expected.empty());
    }
    CHECK(tree.near({}).empty());
  }
}

TEST_CASE("ATreeFollowsVerticesThatMove") {
  std::mt19937_64 random(6);
  std::vector<Vec3> positions(90);
  std::vector<Triangle> triangles;
  for (std::uint32_t v = 0; v + 2 < positions.size(); ++v) triangles.push_back({v, v + 1, v + 2});
  const auto move = [&] {
    for (Vec3& p : positions) p = place(random);
  };
  move();
  BoxTree sorted(positions, triangles), sheet = BoxTree::of_sheet(positions, triangles);
  for (int round = 0; round < 20; ++round) {
    std::vector<Box> boxes;
    for (const Triangle& t : triangles) boxes.push_back(box_of(positions, t));
    Box box;
    box.extend(place(random));
    const std::vector<std::uint32_t> expected = by_hand(boxes, box);
    CHECK(sorted.near(box) == expected);
    CHECK(sheet.near(box) == expected);
    move();
    sorted.refit(positions, triangles);
    sheet.refit(positions, triangles);
  }
}

TEST_CASE("ATriangleIsNewOnce") {
  std::mt19937_64 random(7);
  TriangleMarks marks;
  std::set<std::uint64_t> known;
  for (int i = 0; i < 50'000; ++i) {
    // Runs of numbers in many chunks, those at the ends of what is numbered among them.
    const std::uint64_t chunk = random() % 50 == 0 ? UINT32_MAX : random() % 40;
    const std::uint64_t triangle = random() % 20 == 0 ? UINT32_MAX : random() % 3000;
    const std::uint64_t number = (chunk << 32) | triangle;
    REQUIRE(marks.mark(number) == known.insert(number).second);
  }
  const Triangle64 corners = {1, 2, 3}, others = {1, 3, 2};
  CHECK(marks.mark(corners));
  CHECK(marks.mark(others));
  CHECK_FALSE(marks.mark(corners));
}

}  // namespace
}  // namespace orbweave
