// Real LAS files: counts, bounds and attributes as another program (numpy) finds them.
#include <catch2/catch.hpp>

#include "io/clouds/open_point_source.h"
#include "tests/io/las_files.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using test::data_path;
using test::read_cloud;
using test::reading_error;

struct Sample {
  const char* file;
  std::size_t points;  ///< that are not withheld
  std::uint64_t withheld;
  Vec3 min;
  Vec3 max;
  double intensities;  ///< their sum
};

// clang-format off
const Sample kSamples[] = {
    {"samples/las/1.0_1.las", 1, 0, {470692.44, 4602888.9, 16.0}, {470692.44, 4602888.9, 16.0}, 0},
    {"samples/las/1.1_0.las", 1, 0, {470692.44, 4602888.9, 16.0}, {470692.44, 4602888.9, 16.0}, 0},
    {"samples/las/1.2-with-color.las", 1065, 0, {635619.85, 848899.7000000001, 406.59000000000003}, {638982.55, 853535.43, 586.38}, 81361},
    {"samples/las/1.2_0.las", 1, 0, {470692.44, 4602888.9, 16.0}, {470692.44, 4602888.9, 16.0}, 0},
    {"samples/las/1.2_1.las", 1, 0, {470692.44, 4602888.9, 16.0}, {470692.44, 4602888.9, 16.0}, 0},
    {"samples/las/1.2_2.las", 1, 0, {470692.44, 4602888.9, 16.0}, {470692.44, 4602888.9, 16.0}, 0},
    {"samples/las/1.2_3.las", 1, 0, {470692.44, 4602888.9, 16.0}, {470692.44, 4602888.9, 16.0}, 0},
    {"samples/las/1_4_w_evlr.las", 1000, 0, {1694038.4456374517, 1816492.7062700584, 5592.7499174683535}, {1694539.677014474, 1816497.9762624602, 5599.069686751426}, 38007},
    {"samples/las/4_6_crop.las", 23875, 0, {1639600.0, 1454500.02, 7077.92}, {1639799.98, 1454700.0, 7139.7}, 439166},
    {"samples/las/autzen_trim_7.las", 110000, 0, {636001.76, 848935.2000000001, 406.26}, {637179.22, 849497.9, 520.51}, 11220547},
    {"samples/las/epsg_4326.las", 5380, 0, {-94.68346539999999, 31.0367341, 39.0810002}, {-94.66063109999999, 31.0473291, 78.1190002}, 352578300},
    {"samples/las/extrabytes.las", 1065, 0, {635619.85, 848899.7000000001, 406.59000000000003}, {638982.55, 853535.43, 586.38}, 81361},
    {"samples/las/lots_of_vlr.las", 1, 0, {715001.346, 839349.171, 17.275000000000002}, {715001.346, 839349.171, 17.275000000000002}, 105},
    {"samples/las/no-points.las", 0, 0, {}, {}, 0},
    {"samples/las/pdrf10-1.4.las", 541, 483, {-2141890547.0, -2147415624.0, -2147101580.0}, {2146619417.0, 2139249378.0, 2146599318.0}, 18004386},
    {"samples/las/pdrf4-1.3.las", 1024, 0, {-70.0, -22.53, -10.0}, {103.91, 90.0, 12.08}, 19379712},
    {"samples/las/pdrf6-1.4.las", 530, 494, {-2141972467.0, -2147415560.0, -2147167116.0}, {2129842201.0, 2139347682.0, 2146599318.0}, 17849568},
    {"samples/las/pdrf8-1.4.las", 541, 483, {-2141890547.0, -2147415624.0, -2147101580.0}, {2146619417.0, 2139249378.0, 2146599318.0}, 18004386},
    {"samples/las/sample_c.las", 14408, 0, {674521.9200134277, 1206740.0800170898, 627.530029296875}, {674605.3200134278, 1206814.9600170897, 656.230029296875}, 29823038},
    {"samples/las/simple1_1.las", 1065, 0, {635619.85, 848899.7000000001, 406.59000000000003}, {638982.55, 853535.43, 586.38}, 81361},
    {"samples/las/simple1_3.las", 999, 0, {-235434.519, 5800843.145, 265.094}, {-234935.84100000001, 5800946.249, 273.811}, 102386},
    {"samples/las/simple1_4.las", 22600, 0, {1.0, 1.0, 44.0}, {226.00000000000003, 100.00000000000003, 254.0}, 0},
    {"samples/las/test1_4.las", 1000, 0, {1694038.4456374517, 1816492.7062700584, 5592.7499174683535}, {1694539.677014474, 1816497.9762624602, 5599.069686751426}, 38007},
    {"samples/las/unregistered_extra_bytes.las", 4, 0, {1.0, 1.0, 1.0}, {4.0, 4.0, 4.0}, 0},
    {"samples/las/vegetation_1_3.las", 10683, 0, {-98451.205, -55975.417, -81460.091}, {-98447.447, -55969.405, -81455.203}, 87645995},
    {"samples/las/warsaw_small.las", 3000, 0, {639913.26, 485143.14, 84.7}, {639946.75, 485175.91, 104.55}, 7534588},
    {"samples/las/wontcompress3.las", 105, 895, {768321.06, 2028734.533, 104.98}, {768363.729, 2028740.312, 109.96000000000001}, 5565},
    {"lidar/autzen_stadium_tile_las12_pf2.las", 1050319, 0, {636300.02, 850450.03, 411.01}, {637499.99, 851699.99, 592.5500000000001}, 97686574},
    {"lidar/lone-star_las11_pf1.las", 518862, 0, {515368.60225, 4918340.364, 2322.89625}, {515401.043, 4918381.12375, 2338.5755}, 562919835},
    {"lidar/pine_plot_tls_las12_pf0.las", 114024, 0, {0.0001, 0.0001, 49.04179999999999}, {9.9998, 9.9998, 69.3673}, 0},
    {"photogrammetry/pueblito_las14_pf7.las", 307315, 0, {528008.54, 2650360.58, 1895.87}, {528139.029, 2650538.079, 1912.769}, 0},
    {"samples/corrupt/bad_vlr_count.las", 10, 0, {289814.15, 4320978.61, 170.58}, {289818.5, 4320980.59, 170.76}, 2660},
    {"samples/corrupt/spurious.las", 1065, 0, {-124.0687348, 44.0500086, 123.93}, {-123.0625001, 44.062497199999996, 178.73}, 81361},
};
// clang-format on

void check_sample(const Sample& sample) {
  CAPTURE(sample.file);
  if (test::skipped_without(data_path(sample.file))) return;
  const auto source = open_point_source(data_path(sample.file));
  const PointCloud cloud = read_all(*source);
  CHECK(cloud.size() == sample.points);
  CHECK(source->declared_points() == sample.points + sample.withheld);
  CHECK(source->left_out() ==
        (sample.withheld == 0 ? DroppedPoints{} : DroppedPoints{{"withheld", sample.withheld}}));
  CHECK(test::sum_of(cloud, "intensity") == sample.intensities);
  if (cloud.empty()) return;
  CHECK(cloud.bounds().min == sample.min);
  CHECK(cloud.bounds().max == sample.max);
}

// Two of samples/corrupt can be read in truth. bad_vlr_count.las: its header counts a variable
// length record too many, but the points begin where it says and fill the file to the last byte.
// spurious.las: one point lies a degree outside of the bounds in the header, but every record is
// whole, and what a point is worth is not for a reader to judge.
TEST_CASE("EverySampleHasTheCountAndBoundsThatAnotherProgramFinds") {
  for (const Sample& sample : kSamples) check_sample(sample);
}

TEST_CASE("CorruptSamplesAreRefusedByName") {
  const auto refused = [](const char* file, const std::vector<std::string>& words) {
    CAPTURE(file);
    if (test::skipped_without(data_path(file))) return;
    const Error error = reading_error(data_path(file));
    CHECK(error.kind() == ErrorKind::kBadInput);
    const std::string message = error.what();
    CAPTURE(message);
    for (const std::string& word : words) CHECK(message.find(word) != std::string::npos);
  };
  refused("samples/corrupt/1.2-no-points.las", {"too short", "room for 0", "1065 points"});
  refused("samples/corrupt/1.2-with-color-clipped.las", {"room for 1064 ", "1065 points"});
  // Its count of variable length records is garbage too; that alone would not keep the points.
  refused("samples/corrupt/garbage_nVariableLength.las", {"room for 718 ", "719 points"});
}

TEST_CASE("CoordinateSystemsOfTheSamplesAreFound") {
  const auto system_of = [](const char* file) {
    return open_point_source(data_path(file))->coordinate_system();
  };
  if (test::skipped_without(data_path("samples/las/1.0_1.las"))) return;
  CHECK(system_of("samples/las/1.0_1.las") == "EPSG:26915");
  CHECK(system_of("samples/las/4_6_crop.las") == "EPSG:2903+6360");
  CHECK(system_of("samples/las/epsg_4326.las") == "EPSG:4326");
  CHECK(system_of("samples/las/simple1_1.las").empty());
  CHECK(system_of("samples/las/warsaw_small.las").empty());  // its WKT is a pair of quotes
  CHECK(system_of("samples/las/wontcompress3.las").starts_with("PROJCS[\"NAD83 / UTM zone 19N\","));
  CHECK(system_of("samples/las/autzen_trim_7.las").ends_with("]]"));
}

TEST_CASE("ExtraBytesOfASampleRepeatItsFields") {
  const auto file = data_path("samples/las/extrabytes.las");
  if (test::skipped_without(file)) return;
  const PointCloud cloud = read_cloud(file);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    CHECK(test::value_of(cloud, i, "Colors_0") == test::value_of(cloud, i, "red"));
    CHECK(test::value_of(cloud, i, "Colors_1") == test::value_of(cloud, i, "green"));
    CHECK(test::value_of(cloud, i, "Colors_2") == test::value_of(cloud, i, "blue"));
    CHECK(test::value_of(cloud, i, "Flags_0") == test::value_of(cloud, i, "return_number"));
    CHECK(test::value_of(cloud, i, "Flags_1") == test::value_of(cloud, i, "number_of_returns"));
    CHECK(test::value_of(cloud, i, "Intensity") == test::value_of(cloud, i, "intensity"));
  }
}

}  // namespace
}  // namespace orbweave
