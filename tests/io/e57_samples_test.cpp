// E57 files of other programs. Counts and bounds were found by a decoder apart from this one.
#include <catch2/catch.hpp>
#include <cmath>

#include "io/clouds/open_point_source.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave::test {
namespace {

struct Sample {
  const char* file;
  std::size_t points;
  Vec3 low;
  Vec3 high;
};

std::filesystem::path sample_path(const std::string& name) {
  return data_path("samples/e57/" + name);
}

void check_sample(const Sample& sample) {
  const std::filesystem::path path = sample_path(sample.file);
  if (skipped_without(path)) return;
  INFO(sample.file);
  const PointCloud cloud = read_cloud(path);
  CHECK(cloud.size() == sample.points);
  if (sample.points == 0) return;
  // The expected bounds are given to 9 digits.
  const Box bounds = cloud.bounds();
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(bounds.min[axis] == Approx(sample.low[axis]).epsilon(1e-8));
    CHECK(bounds.max[axis] == Approx(sample.high[axis]).epsilon(1e-8));
  }
}

}  // namespace

TEST_CASE("E57SamplesHaveTheirCountsAndBounds") {
  const Vec3 half = {0.5, 0.5, 0.5};
  const Vec3 bunny_low = {-0.094689, 0.040011, -0.061873};
  const Vec3 bunny_high = {0.061009, 0.187321, 0.058799};
  check_sample({"A_B.e57",
                6,
                {-44.9522018, -1.34930003, -0.60769999},
                {-42.6394997, 2.05780005, 0.666700006}});
  check_sample({"A_moved_B.e57",
                6,
                {-44.1194382, 0.705302835, -0.60769999},
                {-42.6394997, 2.05780005, 0.666700006}});
  check_sample({"ColourRepresentation.e57", 153, -half, half});
  check_sample({"ColouredCubeDouble.e57", 7680, -half, half});
  check_sample({"ColouredCubeFloat.e57", 7680, -half, half});
  check_sample({"bunnyDouble.e57", 30571, bunny_low, bunny_high});
  check_sample({"bunnyInt32.e57", 30571, bunny_low, bunny_high});
  check_sample({"testWithNormals.e57", 2, {1, 0, 0}, {2, 0, 0}});
  check_sample({"translationWithoutRotation.e57", 4, {4, 5, 6}, {5, 6, 6}});
  check_sample({"PinholeImageWithDistortionParameters.e57", 0, {}, {}});
  check_sample({"ZeroPoints.e57", 0, {}, {}});
  check_sample({"empty.e57", 0, {}, {}});
}

TEST_CASE("E57BunnyOfIntegersIsTheBunnyOfDoublesToTheirScale") {
  if (skipped_without(sample_path("bunnyDouble.e57"))) return;
  const PointCloud doubles = read_cloud(sample_path("bunnyDouble.e57"));
  const PointCloud integers = read_cloud(sample_path("bunnyInt32.e57"));
  REQUIRE(doubles.size() == integers.size());
  const double scale = 1e-6;
  for (std::size_t i = 0; i < doubles.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const double apart = doubles.positions[i][axis] - integers.positions[i][axis];
      REQUIRE(std::abs(apart) <= 0.501 * scale);
    }
}

TEST_CASE("E57CubeOfFloatsIsTheCubeOfDoubles") {
  if (skipped_without(sample_path("ColouredCubeDouble.e57"))) return;
  const PointCloud doubles = read_cloud(sample_path("ColouredCubeDouble.e57"));
  const PointCloud floats = read_cloud(sample_path("ColouredCubeFloat.e57"));
  CHECK(doubles.schema.position_type == ScalarType::kFloat64);
  CHECK(floats.schema.position_type == ScalarType::kFloat32);
  CHECK(typed_names(floats.schema) ==
        std::vector<std::string>{"red uint8", "green uint8", "blue uint8"});
  CHECK(doubles.attributes == floats.attributes);
  REQUIRE(doubles.size() == floats.size());
  for (std::size_t i = 0; i < doubles.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      REQUIRE(floats.positions[i][axis] ==
              static_cast<double>(static_cast<float>(doubles.positions[i][axis])));
}

TEST_CASE("E57SampleOfLasToolsHasItsColoursAndReturns") {
  if (skipped_without(sample_path("ColourRepresentation.e57"))) return;
  const PointCloud cloud = read_cloud(sample_path("ColourRepresentation.e57"));
  CHECK(typed_names(cloud.schema) == std::vector<std::string>{"red uint16", "green uint16",
                                                              "blue uint16", "return_number uint8",
                                                              "number_of_returns uint8"});
  CHECK(sum_of(cloud, "red") == 3264000);
  CHECK(sum_of(cloud, "green") == 3394560);
  CHECK(sum_of(cloud, "blue") == 3329280);
  // Every return is the first of one.
  CHECK(sum_of(cloud, "return_number") == 153);
  CHECK(sum_of(cloud, "number_of_returns") == 153);
}

TEST_CASE("E57SampleWithNormalsHasThem") {
  if (skipped_without(sample_path("testWithNormals.e57"))) return;
  const PointCloud cloud = read_cloud(sample_path("testWithNormals.e57"));
  REQUIRE(cloud.normals.size() == 2);
  for (const Vec3 normal : cloud.normals) CHECK(norm(normal) == Approx(1.0).epsilon(1e-5));
  CHECK(cloud.normals[0].z == Approx(0.999999046));
  CHECK(cloud.normals[1].y == Approx(0.999999046));
}

TEST_CASE("E57SampleWithTranslationTellsItsScanner") {
  if (skipped_without(sample_path("translationWithoutRotation.e57"))) return;
  const auto source = open_point_source(sample_path("translationWithoutRotation.e57"));
  PointCloud batch;
  REQUIRE(source->read(batch, 100));
  CHECK(source->scanner() == ScannerPlace{.vector = {4, 5, 6}});
}

TEST_CASE("E57CorruptSamplesAreRefusedWithTheirDefect") {
  const auto check = [](const std::string& name, const std::string& defect) {
    const std::filesystem::path path = data_path("samples/corrupt/" + name);
    if (skipped_without(path)) return;
    const Error error = reading_error(path);
    CHECK(error.kind() == ErrorKind::kBadInput);
    CHECK_THAT(error.what(), Catch::Matchers::Contains(defect));
  };
  check("InvalidCVHeader.e57", "byte 48: the section of scan 1 holds no compressed points");
  check("ZeroPointsInvalid.e57", "the offset of the points of scan 1 points outside of the data");
  check("bad-crc.e57", "the checksum of page 0 (bytes 0 to 1023) is wrong");
}

}  // namespace orbweave::test
