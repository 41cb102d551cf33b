// LAZ files give the points of their LAS twins.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

#include "io/clouds/open_point_source.h"
#include "tests/io/las_files.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using test::data_path;
using test::read_cloud;
using test::same_bits;

bool are_absent(const char* a, const char* b) {
  return test::skipped_without(data_path(a)) || test::skipped_without(data_path(b));
}

TEST_CASE("CompressedFilesHoldTheVeryPointsOfTheirTwins") {
  const std::pair<const char*, const char*> twins[] = {
      {"samples/laz/lone-star.laz", "lidar/lone-star_las11_pf1.las"},
      {"samples/laz/pine_plot.laz", "lidar/pine_plot_tls_las12_pf0.las"},
      {"samples/laz/1_4_w_evlr.laz", "samples/las/1_4_w_evlr.las"},
      {"samples/laz/extra.laz", "samples/las/extrabytes.las"},
      {"samples/laz/simple.laz", "samples/las/1.2-with-color.las"},
  };
  for (const auto& [compressed, plain] : twins) {
    CAPTURE(compressed);
    if (are_absent(compressed, plain)) continue;
    const PointCloud cloud = read_cloud(data_path(compressed));
    CHECK_FALSE(cloud.empty());
    CHECK(same_bits(cloud, read_cloud(data_path(plain))));
  }
}

/// Every attribute of `names` has the same values in both.
void check_shared(const PointCloud& a, const PointCloud& b, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    CAPTURE(name);
    const std::size_t field_a = test::field_of(a.schema, name);
    const std::size_t field_b = test::field_of(b.schema, name);
    REQUIRE(field_a < a.schema.attributes.size());
    REQUIRE(field_b < b.schema.attributes.size());
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (attribute_value(a, i, field_a) != attribute_value(b, i, field_b)) ++different;
    CHECK(different == 0);
  }
}

const std::vector<std::string> kShared = {"intensity",
                                          "return_number",
                                          "number_of_returns",
                                          "classification",
                                          "user_data",
                                          "point_source_id",
                                          "gps_time",
                                          "red",
                                          "green",
                                          "blue"};

TEST_CASE("APointFormatOfBeforeHoldsWhatItsSuccessorHolds") {
  const char* compressed = "samples/laz/autzen_trim.laz";  // format 3
  const char* plain = "samples/las/autzen_trim_7.las";     // format 7
  if (are_absent(compressed, plain)) return;
  const PointCloud a = read_cloud(data_path(compressed));
  const PointCloud b = read_cloud(data_path(plain));
  CHECK(a.size() == 110000);
  REQUIRE(a.size() == b.size());
  CHECK(a.positions == b.positions);
  check_shared(a, b, kShared);
}

TEST_CASE("ACopcFileHoldsThePointsOfItsOriginalInAnotherOrder") {
  const char* compressed = "samples/laz/simple.copc.laz";
  const char* plain = "samples/las/1.2-with-color.las";
  if (are_absent(compressed, plain)) return;
  const PointCloud a = read_cloud(data_path(compressed));
  const PointCloud b = read_cloud(data_path(plain));
  REQUIRE(a.size() == b.size());
  // In whole units of their scale, because its offset is another one and so is the last bit.
  const auto units = [](const PointCloud& cloud) {
    std::vector<std::array<long long, 3>> rows;
    for (const Vec3& p : cloud.positions)
      rows.push_back({std::llround(p.x * 100), std::llround(p.y * 100), std::llround(p.z * 100)});
    std::sort(rows.begin(), rows.end());
    return rows;
  };
  CHECK(units(a) == units(b));
}

TEST_CASE("TwoThreadsReadTheSameCompressedFileAtOnce") {
  const auto file = data_path("samples/laz/pine_plot.laz");
  if (test::skipped_without(file)) return;
  const PointCloud alone = read_cloud(file);
  std::array<PointCloud, 2> clouds;
  std::thread first([&] { clouds[0] = read_cloud(file); });
  std::thread second([&] { clouds[1] = read_cloud(file); });
  first.join();
  second.join();
  CHECK(same_bits(clouds[0], alone));
  CHECK(same_bits(clouds[1], alone));
}

TEST_CASE("BatchesOfACompressedFileMakeTheSameCloud") {
  const auto file = data_path("samples/laz/simple.laz");
  if (test::skipped_without(file)) return;
  const PointCloud whole = read_cloud(file);
  for (const std::size_t capacity : {1, 7, 1065, 5000}) {
    const auto source = open_point_source(file);
    PointCloud cloud, batch;
    cloud.schema = source->schema();
    while (source->read(batch, capacity)) {
      CHECK(batch.size() <= capacity);
      CHECK(source->bytes_read() <= source->bytes_total());
      cloud.append(batch);
    }
    CHECK(same_bits(cloud, whole));
  }
}

TEST_CASE("CompressedPointsWithoutTheirDescriptionAreRefused") {
  test::LasFile file;
  file.add({});
  file.stored_format = 128;
  const Error error = test::las_error(file.bytes());
  CHECK(error.kind() == ErrorKind::kBadInput);
  CHECK(std::string(error.what()).find("\"laszip encoded\"") != std::string::npos);
}

TEST_CASE("CompressedFilesThatEndEarlyOrLieAboutTheirCountAreRefused") {
  const auto file = data_path("samples/laz/simple.laz");
  if (test::skipped_without(file)) return;
  const std::string bytes = test::read_file(file);
  REQUIRE(test::read_las(bytes).size() == 1065);
  for (std::size_t length = 0; length < bytes.size(); length += 97) {
    CAPTURE(length);
    CHECK(test::las_error(bytes.substr(0, length)).kind() == ErrorKind::kBadInput);
  }
  std::string more = bytes;
  for (const std::uint32_t count : {1066u, 0xffffffffu}) {
    more.replace(107, 4, test::raw(count));
    CHECK(test::las_error(more).kind() == ErrorKind::kBadInput);
  }
}

TEST_CASE("ACountThatNoCompressedFileHoldsIsRefused") {
  const auto file = data_path("samples/laz/1_4_w_evlr.laz");
  if (test::skipped_without(file)) return;
  std::string bytes = test::read_file(file);
  bytes.replace(247, 8, test::raw(std::uint64_t{1} << 63));
  const Error error = test::las_error(bytes);
  CHECK(error.kind() == ErrorKind::kBadInput);
  CHECK(std::string(error.what()).find("9223372036854775808") != std::string::npos);
}

TEST_CASE("CorruptCompressedSamplesAreRefusedByName") {
  const std::pair<const char*, const char*> files[] = {
      {"samples/corrupt/broken_coder.laz", "coder 15"},
      {"samples/corrupt/broken_size.laz", "POINT10"},
      {"samples/corrupt/broken_version.laz", "POINT10 of version 6"},
  };
  for (const auto& [name, word] : files) {
    CAPTURE(name);
    if (test::skipped_without(data_path(name))) continue;
    const Error error = test::reading_error(data_path(name));
    CHECK(error.kind() == ErrorKind::kBadInput);
    CHECK(std::string(error.what()).find(word) != std::string::npos);
  }
}

}  // namespace
}  // namespace orbweave
