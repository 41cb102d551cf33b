// Extra bytes of LAS points: which become attributes, and under which names.
#include <catch2/catch.hpp>
#include <limits>

#include "tests/io/las_files.h"

namespace orbweave {
namespace {

using test::LasFile;
using test::LasPoint;
using test::raw;
using test::read_las;
using test::value_of;

constexpr unsigned kScaled = 8;
constexpr unsigned kMoved = 16;

/// One entry of the extra bytes record.
struct Described {
  unsigned type;
  std::string name;
  unsigned options = 0;
  std::array<double, 3> scale{};
  std::array<double, 3> offset{};
};

std::string descriptor(const Described& d) {
  std::string name = d.name;
  name.resize(32);
  std::string bytes = std::string(2, 'r') + test::byte(d.type) + test::byte(d.options) + name;
  bytes += std::string(4 + 72, 'u');
  for (const double v : d.scale) bytes += raw(v);
  for (const double v : d.offset) bytes += raw(v);
  return bytes + std::string(32, 't');
}

/// Two points of format 0, each with these extra bytes.
LasFile file_with(const std::vector<Described>& described, const std::string& first,
                  const std::string& second) {
  std::string payload;
  for (const Described& d : described) payload += descriptor(d);
  LasFile file;
  file.minor = 4;
  file.variable_records = {test::variable_record("LASF_Spec", 4, payload)};
  for (const std::string& extra : {first, second}) {
    LasPoint point;
    point.extra = extra;
    file.add(point);
  }
  return file;
}

/// Names and types of the attributes behind those of format 0.
std::vector<std::string> extra_names(const PointCloud& cloud) {
  std::vector<std::string> names = test::typed_names(cloud.schema);
  names.erase(names.begin(), names.begin() + 7);
  return names;
}
using Names = std::vector<std::string>;

TEST_CASE("EveryTypeOfExtraBytesKeepsItsWidthAndValue") {
  const auto row = [](auto sign) {
    return raw(std::uint8_t{200}) + raw(std::int8_t{-100}) + raw(std::uint16_t{60000}) +
           raw(std::int16_t{-30000}) + raw(std::uint32_t{4000000000u}) +
           raw(std::int32_t{-2000000000}) + raw(std::uint64_t{1} << 60) +
           raw(-(std::int64_t{1} << 60)) + raw(1.5f * sign) + raw(-1e300 * sign);
  };
  const PointCloud cloud = read_las(file_with({{1, "a"},
                                               {2, "b"},
                                               {3, "c"},
                                               {4, "d"},
                                               {5, "e"},
                                               {6, "f"},
                                               {7, "g"},
                                               {8, "h"},
                                               {9, "i"},
                                               {10, "j"}},
                                              row(1.0f), row(-1.0f))
                                        .bytes());
  CHECK(extra_names(cloud) == Names{"a uint8", "b int8", "c uint16", "d int16", "e uint32",
                                    "f int32", "g uint64", "h int64", "i float32", "j float64"});
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(value_of(cloud, i, "a") == 200);
    CHECK(value_of(cloud, i, "b") == -100);
    CHECK(value_of(cloud, i, "c") == 60000);
    CHECK(value_of(cloud, i, "d") == -30000);
    CHECK(value_of(cloud, i, "e") == 4e9);
    CHECK(value_of(cloud, i, "f") == -2e9);
    CHECK(value_of(cloud, i, "g") == 0x1p60);
    CHECK(value_of(cloud, i, "h") == -0x1p60);
    CHECK(value_of(cloud, i, "i") == (i == 0 ? 1.5 : -1.5));
    CHECK(value_of(cloud, i, "j") == (i == 0 ? -1e300 : 1e300));
  }
}

TEST_CASE("ScaledExtraBytesBecomeDoubles") {
  const PointCloud cloud =
      read_las(file_with({{3, "height", kScaled, {0.01}},
                          {4, "both", kScaled | kMoved, {0.5}, {1000.0}},
                          {1, "moved", kMoved, {77.0}, {-1.0}},  // its scale is not said to hold
                          {2, "off", kScaled, {0.0}},
                          {2, "bad", kScaled, {std::numeric_limits<double>::infinity()}}},
                         raw(std::uint16_t{1234}) + raw(std::int16_t{-3}) + "\x05\x06\x07",
                         raw(std::uint16_t{0}) + raw(std::int16_t{0}) + std::string(3, '\0'))
                   .bytes());
  CHECK(extra_names(cloud) ==
        Names{"height float64", "both float64", "moved float64", "off int8", "bad int8"});
  CHECK(value_of(cloud, 0, "height") == 1234 * 0.01);
  CHECK(value_of(cloud, 0, "both") == 998.5);
  CHECK(value_of(cloud, 0, "moved") == 4.0);
  CHECK(value_of(cloud, 0, "off") == 6.0);
  CHECK(value_of(cloud, 0, "bad") == 7.0);
  CHECK(value_of(cloud, 1, "both") == 1000.0);
}

TEST_CASE("ArraysOfExtraBytesBecomeNumberedAttributes") {
  const std::string bytes = raw(std::uint16_t{1}) + raw(std::uint16_t{2}) + raw(std::uint16_t{3}) +
                            raw(std::int8_t{-4}) + raw(std::int8_t{-5});
  const PointCloud cloud =
      read_las(file_with({{23, "c"}, {12, "p", kScaled, {0.5, 2.0}}}, bytes, bytes).bytes());
  CHECK(extra_names(cloud) ==
        Names{"c_0 uint16", "c_1 uint16", "c_2 uint16", "p_0 float64", "p_1 float64"});
  CHECK(value_of(cloud, 1, "c_0") == 1);
  CHECK(value_of(cloud, 1, "c_2") == 3);
  CHECK(value_of(cloud, 1, "p_0") == -2.0);
  CHECK(value_of(cloud, 1, "p_1") == -10.0);
}

TEST_CASE("UndocumentedExtraBytesArePassedOver") {
  const PointCloud cloud =
      read_las(file_with({{0, "reserved", 7}, {1, "a"}}, "1234567A", "1234567B").bytes());
  CHECK(extra_names(cloud) == Names{"a uint8"});
  CHECK(value_of(cloud, 0, "a") == 'A');
  CHECK(value_of(cloud, 1, "a") == 'B');
}

TEST_CASE("DescriptionsThatDoNotFitTheRecordEndTheList") {
  CHECK(extra_names(read_las(file_with({{1, "a"}, {10, "b"}, {1, "c"}}, "1234", "5678").bytes())) ==
        Names{"a uint8"});
  CHECK(extra_names(read_las(file_with({{1, "a"}, {31, "b"}, {1, "c"}}, "1234", "5678").bytes())) ==
        Names{"a uint8"});
  CHECK(extra_names(read_las(file_with({{0, "a", 5}, {1, "b"}}, "1234", "5678").bytes())).empty());
  LasFile cut = file_with({{1, "a"}, {1, "b"}}, "12", "34");
  cut.variable_records = {
      test::variable_record("LASF_Spec", 4, descriptor({1, "a"}) + std::string(191, 'x'))};
  CHECK(extra_names(read_las(cut.bytes())) == Names{"a uint8"});
}

TEST_CASE("NoTwoAttributesShareAName") {
  const PointCloud cloud = read_las(file_with({{1, "intensity"},
                                               {1, "x"},
                                               {1, "a"},
                                               {1, "a"},
                                               {1, "a_2"},
                                               {1, ""},
                                               {1, "Pulse width\t"},
                                               {1, "nx"}},
                                              "12345678", "abcdefgh")
                                        .bytes());
  CHECK(extra_names(cloud) == Names{"intensity_2 uint8", "x_2 uint8", "a uint8", "a_2 uint8",
                                    "a_2_2 uint8", "extra uint8", "Pulse_width_ uint8",
                                    "nx_2 uint8"});
  CHECK(value_of(cloud, 0, "intensity") == 0);
  CHECK(value_of(cloud, 0, "intensity_2") == '1');
}

TEST_CASE("NormalsAmongTheExtraBytesAreNormals") {
  const std::string bytes = raw(0.25f) + raw(std::uint8_t{9}) + raw(-0.5f) + raw(1.0f);
  const PointCloud cloud = read_las(
      file_with({{9, "NormalX"}, {1, "a"}, {9, "NormalY"}, {9, "NormalZ"}}, bytes, bytes).bytes());
  CHECK(cloud.schema.has_normals);
  CHECK(cloud.schema.normal_type == ScalarType::kFloat32);
  CHECK(extra_names(cloud) == Names{"a uint8"});
  CHECK(cloud.normals == std::vector<Vec3>(2, {0.25, -0.5, 1.0}));
  CHECK(value_of(cloud, 1, "a") == 9);

  const std::string scaled = raw(std::int16_t{100}) + raw(std::int16_t{-50}) + raw(2.0f);
  const PointCloud wide = read_las(
      file_with({{4, "nx", kScaled, {0.01}}, {4, "ny", kScaled, {0.01}}, {9, "nz"}}, scaled, scaled)
          .bytes());
  CHECK(wide.schema.normal_type == ScalarType::kFloat64);
  CHECK(wide.normals == std::vector<Vec3>(2, {1.0, -0.5, 2.0}));

  const std::string three = raw(0.0f) + raw(0.6f) + raw(0.8f);
  const PointCloud named = read_las(
      file_with({{9, "normal_x"}, {9, "normal_y"}, {9, "normal_z"}}, three, three).bytes());
  CHECK(named.schema.has_normals);

  const PointCloud two = read_las(
      file_with({{9, "NormalX"}, {9, "NormalY"}}, raw(1.0f) + raw(2.0f), raw(3.0f) + raw(4.0f))
          .bytes());
  CHECK_FALSE(two.schema.has_normals);
  CHECK(value_of(two, 1, "NormalY") == 4.0);
}

}  // namespace
}  // namespace orbweave
