// The points of the first pass come back as they were, or not at all.
#include "engine/pipeline/points/remembered_points.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/support/clouds.h"

namespace orbweave {
namespace {

/// Points with attributes of one byte.
PointCloud batch_of(std::size_t points, test::Random& random) {
  PointCloud batch;
  batch.schema.attributes.push_back({"class", ScalarType::kUint8});
  for (std::size_t i = 0; i < points; ++i) {
    batch.positions.push_back({random.uniform(), random.uniform(), random.uniform()});
    batch.attributes.push_back(static_cast<std::byte>(random.below(256)));
  }
  return batch;
}

TEST_CASE("RememberedPointsComeBackBatchByBatch") {
  test::Random random(3);
  std::vector<PointCloud> batches;
  for (const std::size_t points : {100, 0, 7}) batches.push_back(batch_of(points, random));
  RememberedPoints remembered(1 << 20);
  std::uint32_t taken = 0;
  for (PointCloud batch : batches) {
    remembered.take(batch, {taken++, 2});
    CHECK(batch.empty());
  }
  REQUIRE(remembered.are_all());
  const auto source = remembered.source(batches.front().schema);
  PointCloud found;
  std::uint32_t given = 0;
  for (const PointCloud& batch : batches) {
    REQUIRE(source->read(found, 1000));
    CHECK(source->scan() == ScanNumber{given++, 2});
    CHECK(found.positions == batch.positions);
    CHECK(found.attributes == batch.attributes);
  }
  CHECK_FALSE(source->read(found, 1000));
  CHECK(found.empty());
}

TEST_CASE("PointsThatDoNotFitAreNotRememberedInPart") {
  test::Random random(4);
  const std::size_t bytes_of_ten = 10 * (sizeof(Vec3) + 1);
  RememberedPoints remembered(2 * bytes_of_ten);
  PointCloud first = batch_of(10, random), second = batch_of(100, random), third = second;
  remembered.take(first);
  CHECK(remembered.are_all());
  remembered.take(second);
  CHECK_FALSE(remembered.are_all());
  CHECK(second.size() == 100);
  remembered.take(third);
  CHECK_FALSE(remembered.are_all());
  CHECK(third.size() == 100);
  CHECK_FALSE(RememberedPoints().are_all());
}

}  // namespace
}  // namespace orbweave
