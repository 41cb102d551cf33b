// Points of chunks: whole, and the part of them in a box.
#include "io/store/chunk_points.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/data.h"

namespace orbweave {
namespace {

PointCloud make_points(std::size_t count, bool normals, ScalarType normal_type, bool attributes) {
  std::mt19937_64 random(count);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  PointCloud cloud;
  cloud.schema.has_normals = normals;
  cloud.schema.normal_type = normal_type;
  if (attributes)
    cloud.schema.attributes = {{"red", ScalarType::kUint8}, {"time", ScalarType::kFloat64}};
  for (std::size_t i = 0; i < count; ++i) {
    // Blocks are slabs along x, so that boxes miss some of them.
    const double x = static_cast<double>(i) + 0.5 * unit();
    cloud.positions.push_back({x, unit(), -unit()});
    if (normals && normal_type == ScalarType::kFloat32)
      cloud.normals.push_back({static_cast<float>(unit()), static_cast<float>(unit()), -0.25});
    else if (normals)
      cloud.normals.push_back({unit(), unit(), unit()});
    for (std::size_t b = 0; b < cloud.schema.attribute_bytes(); ++b)
      cloud.attributes.push_back(static_cast<std::byte>(random()));
  }
  return cloud;
}

bool same(const PointCloud& a, const PointCloud& b) {
  return a.schema == b.schema && a.positions == b.positions && a.normals == b.normals &&
         a.attributes == b.attributes;
}

PointsInBox filtered(const PointCloud& cloud, const Box& box, PointParts parts) {
  PointsInBox result;
  result.points.schema = cloud.schema;
  result.points.schema.has_normals = cloud.schema.has_normals && parts.normals;
  if (!parts.attributes) result.points.schema.attributes.clear();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!box.contains(cloud.positions[i])) continue;
    result.rows.push_back(static_cast<std::uint32_t>(i));
    result.points.positions.push_back(cloud.positions[i]);
    if (result.points.schema.has_normals) result.points.normals.push_back(cloud.normals[i]);
    if (!parts.attributes) continue;
    const auto row = cloud.attribute_row(i);
    result.points.attributes.insert(result.points.attributes.end(), row.begin(), row.end());
  }
  return result;
}

}  // namespace

TEST_CASE("PointsComeBackExactly") {
  const test::ScratchDirectory scratch;
  const std::size_t count = GENERATE(0, 1, 1024, 5000);
  const bool normals = GENERATE(false, true);
  const ScalarType type = GENERATE(ScalarType::kFloat32, ScalarType::kFloat64);
  const bool attributes = GENERATE(false, true);
  const PointCloud cloud = make_points(count, normals, type, attributes);
  ChunkStore store(scratch / "work");
  commit_points(store, 3, cloud);
  CHECK(same(load_points(store, 3, cloud.schema), cloud));
}

TEST_CASE("SourceRowsComeBackWhereThereAreAny") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = make_points(3, false, ScalarType::kFloat32, false);
  const std::vector<std::uint32_t> rows = {1, 4, 5};
  ChunkStore store(scratch / "work");
  commit_points(store, 0, cloud, "raw_thinned", rows);
  commit_points(store, 1, cloud, "raw_thinned");
  CHECK(load_source_rows(store, 0, "raw_thinned") == rows);
  CHECK(load_source_rows(store, 1, "raw_thinned").empty());
  CHECK(same(load_points(store, 0, cloud.schema, "raw_thinned"), cloud));
}

TEST_CASE("PointsInABoxEqualAFilterOfAll") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = make_points(100'000, true, ScalarType::kFloat32, true);
  ChunkStore store(scratch / "work");
  commit_points(store, 0, cloud);
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    Box box;
    const double from = static_cast<double>(random() % 100'000);
    const double length = trial % 4 == 0 ? 1e5 : static_cast<double>(random() % 3000);
    box.extend(Vec3{from, 0.25, -0.75});
    box.extend(Vec3{from + length, trial % 2 == 0 ? 1.0 : 0.5, -0.1});
    const PointParts parts{trial % 3 != 0, trial % 5 == 0};
    const PointsInBox found = load_points_in_box(store, 0, cloud.schema, box, parts);
    const PointsInBox expected = filtered(cloud, box, parts);
    REQUIRE(found.rows == expected.rows);
    REQUIRE(same(found.points, expected.points));
  }
}

TEST_CASE("ABoxReadsOnlyTheBlocksItMeets") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = make_points(200'000, true, ScalarType::kFloat32, false);
  ChunkStore store(scratch / "work");
  commit_points(store, 0, cloud);
  const std::uint64_t before = store.bytes_read();
  const Box slab{{5000.0, -2.0, -2.0}, {6000.0, 2.0, 2.0}};
  const PointsInBox found = load_points_in_box(store, 0, cloud.schema, slab);
  CHECK(found.rows.size() >= 999);
  CHECK(store.bytes_read() - before < 200'000);
  // A point on the closed box's border belongs to it.
  const Vec3 corner = cloud.positions[777];
  CHECK(load_points_in_box(store, 0, cloud.schema, {corner, corner}).rows ==
        std::vector<std::uint32_t>{777});
}

}  // namespace orbweave
