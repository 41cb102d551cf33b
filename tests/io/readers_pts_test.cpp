#include <catch2/catch.hpp>

#include "io/clouds/open_point_source.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Catch::Contains;
using test::read_cloud;
using test::reading_error;
using test::ScratchDirectory;
using test::write_file;

using Fields = std::vector<AttributeField>;
const AttributeField kIntensity = {"intensity", ScalarType::kFloat32};
const Fields kColors = {
    {"red", ScalarType::kUint8}, {"green", ScalarType::kUint8}, {"blue", ScalarType::kUint8}};

Fields with_intensity(const Fields& fields) {
  Fields all = {kIntensity};
  all.insert(all.end(), fields.begin(), fields.end());
  return all;
}

PointCloud read_pts(const std::string& content) {
  const ScratchDirectory scratch;
  write_file(scratch / "a.pts", content);
  return read_cloud(scratch / "a.pts");
}

Error pts_error(const std::string& content) {
  const ScratchDirectory scratch;
  write_file(scratch / "a.pts", content);
  return reading_error(scratch / "a.pts");
}

}  // namespace

TEST_CASE("SamplePtsFilesHaveTheirPointsAndColumns") {
  struct Sample {
    const char* name;
    std::size_t points;
    Fields fields;
    Box bounds;
  };
  const std::vector<Sample> samples = {
      {"autzen.pts",
       10,
       with_intensity(kColors),
       {{636102.840012, 848968.800003, 427.919998}, {636126.400009, 849345.199997, 512.139999}}},
      {"bunny_8.pts", 9, {}, {{-0.068009, 0.112568, 0.001795}, {0.033213, 0.151244, 0.037195}}},
      {"ripple.pts", 10201, with_intensity(kColors), {{-5, -5, -0.6664}, {5, 5, 1.1}}},
      {"site_56_8.pts",
       8,
       with_intensity({}),
       {{6691.250667, 17.347517, -14.709473}, {6728.512429, 45.710979, 1203.033447}}},
      {"test.pts",
       19,
       with_intensity(kColors),
       {{-25.050461, -24.533554, -2.000961}, {3.980972, -2.006119, -0.010086}}}};
  for (const Sample& sample : samples) {
    const auto path = test::data_path(std::string("samples/ascii/") + sample.name);
    if (test::skipped_without(path)) return;
    const PointCloud cloud = read_cloud(path);
    INFO(sample.name);
    CHECK(cloud.size() == sample.points);
    CHECK(cloud.schema.attributes == sample.fields);
    CHECK(cloud.bounds() == sample.bounds);
  }
  const PointCloud site = read_cloud(test::data_path("samples/ascii/site_56_8.pts"));
  CHECK(attribute_value(site, 6, 0) == -1234.0);
}

TEST_CASE("PtsColumnsGoByTheirNumber") {
  CHECK(read_pts("1\n1 2 3\n").schema.attributes.empty());
  CHECK(read_pts("1\n1 2 3 -2048\n").schema.attributes == with_intensity({}));
  CHECK(read_pts("1\n1 2 3 10 20 30\n").schema.attributes == kColors);
  CHECK(read_pts("1\n1 2 3 10 20 30 40\n").schema.attributes == with_intensity(kColors));
  const PointCloud fractions = read_pts("2\n1 2 3 2047\n1 2 3 0.25\n");
  CHECK(attribute_value(fractions, 0, 0) == 2047.0);
  CHECK(attribute_value(fractions, 1, 0) == 0.25);
  CHECK(read_pts("1\n1 2 3 0.6 0 -0.8\n").schema.has_normals);
  const PointCloud normals = read_pts("1\n1 2 3 90 20 30 40 0.6 0 -0.8\n");
  CHECK(normals.schema.attributes == with_intensity(kColors));
  CHECK(normals.normals == std::vector<Vec3>{{0.6, 0, -0.8}});
}

TEST_CASE("EachScanOfAPtsFileMayHaveItsCount") {
  const ScratchDirectory scratch;
  write_file(scratch / "a.pts", "2\n1 2 3\n4 5 6\n1\n7 8 9\n  3 \n1 1 1\n2 2 2\n3 3 3\n4 4 4\n");
  const auto source = open_point_source(scratch / "a.pts");
  CHECK(source->declared_points() == 2U);
  const PointCloud cloud = read_all(*source);
  CHECK(cloud.size() == 7);
  CHECK(cloud.positions[2] == Vec3{7, 8, 9});
  CHECK(cloud.positions[6] == Vec3{4, 4, 4});
  CHECK(read_pts("1 2 3\n4 5 6\n1\n7 8 9\n").size() == 3);
  CHECK(read_pts("0\n1\n7 8 9 10\n").schema.attributes == with_intensity({}));
  // Beyond the lines that columns are told by.
  std::string many = "200\n";
  for (int i = 0; i < 200; ++i) many += "1 2 3 4 5 6 7\n";
  CHECK(read_pts(many + many + many).size() == 600);
}

TEST_CASE("AScanShorterThanItsCountIsNamed") {
  const Error first = pts_error("3\n1 2 3\n4 5 6\n1\n7 8 9\n");
  CHECK(first.kind() == ErrorKind::kBadInput);
  CHECK(first.parts().place == "line 4");
  CHECK(first.parts().found == "2 points");
  const Error second = pts_error("1\n1 2 3\n9\n7 8 9\n");
  CHECK_THAT(second.what(), Contains("scan 2 of the file has fewer points"));
  CHECK(second.parts().expected == "9");
  CHECK(pts_error("1\n1 2 3\n9223372036854775808\n7 8 9\n").kind() == ErrorKind::kBadInput);
  CHECK(pts_error("9223372036854775808\n7 8 9\n").parts().expected == "9223372036854775808");
  CHECK_THAT(pts_error("5\n").what(), Contains("no points"));
  CHECK_THAT(pts_error("2\n1 2 3 4\n5 6 7\n").what(), Contains("line 3") && Contains("3 columns"));
}

TEST_CASE("ACountIsAPointNowhereElse") {
  const ScratchDirectory scratch;
  write_file(scratch / "a.xyz", "1 2 3\n1\n4 5 6\n");
  CHECK_THAT(reading_error(scratch / "a.xyz").what(),
             Contains("line 2") && Contains("found 1 column, "));
}

TEST_CASE("CorruptPlySamplesAreToldApart") {
  const auto path = test::data_path("samples/corrupt/no_vertex.ply");
  if (test::skipped_without(path)) return;
  CHECK_THAT(reading_error(path).what(), Contains("no vertices"));
  for (const char* name : {"samples/ply/sized_dims.ply", "samples/ply/unsized_dims.ply"})
    CHECK_THAT(reading_error(test::data_path(name)).what(), Contains("no property z"));
  // Nothing is wrong with this one but the digits of its first coordinate.
  const PointCloud one = read_cloud(test::data_path("samples/corrupt/issue_2421.ply"));
  CHECK(one.positions == std::vector<Vec3>{{1.23457, 12345.6789, 1234567890.12345}});
  CHECK(attribute_value(one, 0, 0) == 1234567890.0);
}

}  // namespace orbweave
