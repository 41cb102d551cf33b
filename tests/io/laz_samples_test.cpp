// LAZ files of other writers, by the LAS files they were made from.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "io/clouds/laz/laz_reader.h"
#include "io/error.h"
#include "io/text/little_endian.h"
#include "tests/support/data.h"

namespace orbweave::test {
namespace {

/// What a LAS header says of the points, at the places the LAS 1.4 specification gives.
struct Header {
  explicit Header(const std::filesystem::path& path) : file(open_random_access(path)) {
    bytes.resize(std::min<std::uint64_t>(375, file->size()));
    file->read(0, bytes);
    point_data = load_little<std::uint32_t>(&bytes[96]);
    point_format = load_little<std::uint8_t>(&bytes[104]) & 63;
    record_bytes = load_little<std::uint16_t>(&bytes[105]);
    const bool large_counts = load_little<std::uint8_t>(&bytes[25]) >= 4;
    points = large_counts ? load_little<std::uint64_t>(&bytes[247])
                          : load_little<std::uint32_t>(&bytes[107]);
    find_laszip_record();
  }

  std::unique_ptr<RandomAccess> file;
  std::vector<std::byte> bytes;
  std::uint64_t point_data = 0, points = 0;
  std::uint8_t point_format = 0;
  std::uint16_t record_bytes = 0;
  std::vector<std::byte> laszip_record;

 private:
  void find_laszip_record() {
    std::uint64_t at = load_little<std::uint16_t>(&bytes[94]);
    for (auto records = load_little<std::uint32_t>(&bytes[100]); records > 0; --records) {
      std::array<std::byte, 54> head;
      file->read(at, head);
      const auto size = load_little<std::uint16_t>(&head[20]);
      at += head.size();
      if (load_little<std::uint16_t>(&head[18]) == 22204) {
        laszip_record.resize(size);
        file->read(at, laszip_record);
      }
      at += size;
    }
  }
};

std::vector<std::byte> uncompressed_records(const Header& header) {
  std::vector<std::byte> records(header.points * header.record_bytes);
  header.file->read(header.point_data, records);
  return records;
}

std::vector<std::byte> records_of(const Header& header) {
  LazReader reader(*header.file, header.laszip_record, header.point_data, header.points,
                   header.point_format, header.record_bytes);
  std::vector<std::byte> records;
  std::vector<std::byte> some(std::size_t{10007} * header.record_bytes);
  while (const std::size_t read = reader.read(some))
    records.insert(records.end(), some.begin(),
                   some.begin() + static_cast<long>(read * header.record_bytes));
  return records;
}

void check_twins(const std::string& laz, const std::string& las) {
  const auto laz_path = data_path("samples/laz/" + laz);
  const auto las_path = data_path(las);
  if (skipped_without(laz_path) || skipped_without(las_path)) return;
  const Header header(laz_path);
  const bool equal = records_of(header) == uncompressed_records(Header(las_path));
  CHECK(equal);
}

TEST_CASE("LonestarEqualsItsLasFile") {
  check_twins("lone-star.laz", "lidar/lone-star_las11_pf1.las");
}
TEST_CASE("PinePlotEqualsItsLasFile") {
  check_twins("pine_plot.laz", "lidar/pine_plot_tls_las12_pf0.las");
}
TEST_CASE("ColoursEqualTheirLasFile") {
  check_twins("simple.laz", "samples/las/1.2-with-color.las");
}
TEST_CASE("ExtraBytesEqualTheirLasFile") { check_twins("extra.laz", "samples/las/extrabytes.las"); }
TEST_CASE("LayersEqualTheirLasFile") {
  check_twins("1_4_w_evlr.laz", "samples/las/1_4_w_evlr.las");
}

/// The bounds of the points are those of the header, to half a step of the coordinates.
void check_bounds(const std::string& laz) {
  const auto path = data_path("samples/laz/" + laz);
  if (skipped_without(path)) return;
  const Header header(path);
  const auto records = records_of(header);
  REQUIRE(records.size() == header.points * header.record_bytes);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto scale = load_little<double>(&header.bytes[131 + 8 * axis]);
    const auto offset = load_little<double>(&header.bytes[155 + 8 * axis]);
    std::int32_t low = load_little<std::int32_t>(&records[4 * axis]);
    std::int32_t high = low;
    for (std::size_t at = 4 * axis; at < records.size(); at += header.record_bytes) {
      low = std::min(low, load_little<std::int32_t>(&records[at]));
      high = std::max(high, load_little<std::int32_t>(&records[at]));
    }
    CHECK(std::abs(high * scale + offset - load_little<double>(&header.bytes[179 + 16 * axis])) <=
          scale / 2);
    CHECK(std::abs(low * scale + offset - load_little<double>(&header.bytes[187 + 16 * axis])) <=
          scale / 2);
  }
}

TEST_CASE("AutzenHasTheBoundsOfItsHeader") { check_bounds("autzen_trim.laz"); }
TEST_CASE("LayersOfVersion4HaveTheBoundsOfTheirHeader") { check_bounds("pdrf7-v4-1.4.laz"); }
TEST_CASE("CopcHasTheBoundsOfItsHeader") { check_bounds("simple.copc.laz"); }

using PointValues = std::array<std::int64_t, 9>;

/// What a point of format 3 or 7 has in common with the other: coordinates in steps of the scale
/// from 0, intensity, colour, GPS time, source.
PointValues values_of(const Header& header, const std::byte* point) {
  const bool layered = header.point_format == 7;
  PointValues values{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto scale = load_little<double>(&header.bytes[131 + 8 * axis]);
    const auto offset = load_little<double>(&header.bytes[155 + 8 * axis]);
    values[axis] = load_little<std::int32_t>(point + 4 * axis) + std::llround(offset / scale);
    values[3 + axis] = load_little<std::uint16_t>(point + (layered ? 30 : 28) + 2 * axis);
  }
  values[6] = load_little<std::uint16_t>(point + 12);
  values[7] = load_little<std::int64_t>(point + (layered ? 22 : 20));
  values[8] = load_little<std::uint16_t>(point + (layered ? 20 : 18));
  return values;
}

std::vector<PointValues> sorted_points(const Header& header) {
  const auto records = records_of(header);
  std::vector<PointValues> points;
  for (std::size_t at = 0; at < records.size(); at += header.record_bytes)
    points.push_back(values_of(header, &records[at]));
  std::sort(points.begin(), points.end());
  return points;
}

TEST_CASE("CopcHoldsThePointsOfTheFileItWasMadeFrom") {
  const auto copc = data_path("samples/laz/simple.copc.laz");
  const auto plain = data_path("samples/laz/simple.laz");
  if (skipped_without(copc) || skipped_without(plain)) return;
  const bool equal = sorted_points(Header(copc)) == sorted_points(Header(plain));
  CHECK(equal);
}

void check_refused(const std::string& laz, const std::string& named) {
  const auto path = data_path("samples/corrupt/" + laz);
  if (skipped_without(path)) return;
  const Header header(path);
  CHECK_THROWS_WITH(records_of(header), Catch::Contains(named) && Catch::Contains(laz));
}

TEST_CASE("BrokenFilesAreRefusedByTheirDefect") {
  check_refused("broken_coder.laz", "found coder 15");
  check_refused("broken_size.laz", "found item POINT10 of version 6");
  check_refused("broken_version.laz", "found item POINT10 of version 6");
}

}  // namespace
}  // namespace orbweave::test
