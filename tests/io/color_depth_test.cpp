// Colours at the width that other programs show, and attributes that not all files have.
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>

#include "io/clouds/open_point_source.h"
#include "io/clouds/point_source_list.h"
#include "io/clouds/scan_source.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "io/points/color_depth.h"
#include "io/stop_token.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;

namespace orbweave {
namespace {

template <class T>
void add(PointCloud& cloud, T value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  cloud.attributes.insert(cloud.attributes.end(), bytes, bytes + sizeof value);
}

/// Intensity, colours between others, and a time; point i has the colour `first + i`.
PointCloud colored(std::uint16_t first, std::uint16_t step, std::size_t points) {
  PointCloud cloud;
  cloud.schema.attributes = {{"intensity", ScalarType::kUint16}, {"red", ScalarType::kUint16},
                             {"green", ScalarType::kUint16},     {"blue", ScalarType::kUint16},
                             {"gps_time", ScalarType::kFloat64}, {"class", ScalarType::kUint8}};
  for (std::size_t i = 0; i < points; ++i) {
    cloud.positions.push_back({static_cast<double>(i), 0, 0});
    const auto value = static_cast<std::uint16_t>(first + i * step);
    add(cloud, static_cast<std::uint16_t>(1000 + i));
    for (const int channel : {0, 1, 2})
      add(cloud, static_cast<std::uint16_t>(value / (channel + 1)));
    add(cloud, 0.25 + static_cast<double>(i));
    add(cloud, static_cast<std::uint8_t>(i));
  }
  return cloud;
}

}  // namespace

TEST_CASE("SixteenBitColorsAreScaledAndAllElseStays") {
  PointCloud cloud = colored(0, 257, 256);
  const PointCloud before = cloud;
  const ColorDepth depth(cloud.schema, 8, true);
  depth.apply(cloud);
  REQUIRE(cloud.schema == depth.written());
  CHECK(cloud.schema.attributes[1] == AttributeField{"red", ScalarType::kUint8});
  CHECK(cloud.attributes.size() == cloud.size() * cloud.schema.attribute_bytes());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    CHECK(attribute_value(cloud, i, 1) == static_cast<double>(i));
    for (const std::size_t field : {0u, 4u, 5u})
      CHECK(attribute_value(cloud, i, field) == attribute_value(before, i, field));
  }
}

TEST_CASE("ColorsOf8BitsIn16BitFieldsStayAsTheyAre") {
  PointCloud cloud = colored(0, 1, 256);
  const WideColors colors = wide_colors(cloud.schema).value();
  CHECK_FALSE(exceed_8_bits(cloud, colors));
  ColorDepth(cloud.schema, 8, false).apply(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    CHECK(attribute_value(cloud, i, 1) == static_cast<double>(i));
  CHECK(exceed_8_bits(colored(0, 1, 257), colors));
}

TEST_CASE("ColorsStayWideWhereThatIsAskedForOrTheyAreNone") {
  PointCloud cloud = colored(0, 257, 10);
  const PointCloud before = cloud;
  const ColorDepth wide(cloud.schema, 16, true);
  wide.apply(cloud);
  CHECK_FALSE(wide.changes());
  CHECK(cloud.attributes == before.attributes);
  cloud.schema.attributes[3].name = "nir";
  CHECK_FALSE(ColorDepth(cloud.schema, 8, true).changes());
  cloud.schema.attributes[3] = {"Blue", ScalarType::kUint16};
  CHECK(ColorDepth(cloud.schema, 8, true).written().attributes[3].name == "blue");
}

TEST_CASE("IntensityBesideColorsIsAScalarFieldOfPlyAndReadAsIntensity") {
  const test::ScratchDirectory scratch;
  PointCloud cloud = colored(0, 1, 4);
  write_cloud(scratch / "wide.ply", cloud);
  CHECK_THAT(test::file_text(scratch / "wide.ply"),
             Contains("property ushort scalar_intensity\nproperty ushort red\n"));
  CHECK(read_all(*open_point_source(scratch / "wide.ply")).schema.attributes ==
        cloud.schema.attributes);
  cloud.schema.attributes[1].name = "other";
  write_cloud(scratch / "grey.ply", cloud);
  CHECK_THAT(test::file_text(scratch / "grey.ply"), Contains("property ushort intensity\n"));
}

TEST_CASE("ObjHoldsColorsThatAreReadBack") {
  const test::ScratchDirectory scratch;
  TriangleMesh mesh;
  mesh.vertices = colored(0, 1, 256);
  ColorDepth(mesh.vertices.schema, 8, false).apply(mesh.vertices);
  mesh.triangles = {{0, 1, 2}};
  write_mesh(scratch / "m.obj", mesh);
  CHECK_THAT(test::file_text(scratch / "m.obj"), Contains("\nv 255 0 0 1 0.4981 0.3334\n"));
  const TriangleMesh read = read_mesh(scratch / "m.obj");
  REQUIRE(read.vertices.schema.attributes.size() == 3);
  for (std::size_t i = 0; i < 256; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      CHECK(attribute_value(read.vertices, i, c) == attribute_value(mesh.vertices, i, c + 1));
  test::write_text(scratch / "bytes.obj", "v 0 0 0 255 0 7\nv 1 0 0 1 2 3\nv 0 1 0 0 0 0\n");
  CHECK(attribute_value(read_mesh(scratch / "bytes.obj").vertices, 0, 2) == 7.0);
  // Fractions that were computed exceed 1 a little; what is no colour is told.
  test::write_text(scratch / "over.obj",
                   "v 0 0 0 1.0000001 0.5 0\nv 1 0 0 0 1 -0\nv 0 1 0 1 1 1\n");
  const PointCloud over = read_mesh(scratch / "over.obj").vertices;
  CHECK(attribute_value(over, 0, 0) == 255.0);
  CHECK(attribute_value(over, 0, 1) == 128.0);
  test::write_text(scratch / "weight.obj", "v 0 0 0 300\nv 1 0 0 -1\nv 0 1 0 1\nf 1 2 3\n");
  CHECK(read_mesh(scratch / "weight.obj").vertices.schema.attributes.empty());
  for (const char* const value : {"65535", "-0.7", "nan"}) {
    test::write_text(scratch / "wrong.obj",
                     std::string("v 1 0 0 0 0 0\nv 0 0 0 0 0 ") + value + "\nv 0 1 0 0 0 0\n");
    CHECK_THROWS_WITH(read_mesh(scratch / "wrong.obj"),
                      Contains("wrong.obj: line 2: three values behind the coordinates are no "
                               "colour; found " +
                               std::string(value)));
  }
  test::write_text(scratch / "some.obj", "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 1 1 1\n");
  CHECK(read_mesh(scratch / "some.obj").vertices.schema.attributes.empty());
}

TEST_CASE("TheSearchForWideColorsLooksAtTheStopBetweenBatches") {
  const test::ScratchDirectory scratch;
  const std::string front =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
      "property double z\n";
  const auto colors = [](const std::string& type) {
    return "property " + type + " red\nproperty " + type + " green\nproperty " + type +
           " blue\nend_header\n0 0 0 1 2 3\n1 0 0 4 5 6\n";
  };
  test::write_text(scratch / "a.ply", front + colors("uchar"));
  test::write_text(scratch / "b.ply", front + colors("ushort"));
  StopToken stop;
  const auto list = open_point_sources(
      {scratch / "a.ply", scratch / "b.ply"}, [&](const std::filesystem::path& path) {
        return open_scan_source(open_point_source(path), {.stop = &stop}, path.string());
      });
  PointCloud batch;
  REQUIRE(list->read(batch, 1));
  // One look before the batch; the search has read the 16-bit file to its end before.
  CHECK(stop.checks() == 3);
  stop.request();
  CHECK_THROWS_WITH(list->read(batch, 1), Contains(kInterruptedText));
}

TEST_CASE("EveryAttributeOfEveryFileIsKeptWhateverTheirOrder") {
  const test::ScratchDirectory scratch;
  test::write_text(scratch / "a.ply",
                   "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n"
                   "property double z\nproperty ushort intensity\nproperty uchar code\n"
                   "property double time\nend_header\n0 0 0 500 200 0.5\n");
  test::write_text(scratch / "b.ply",
                   "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n"
                   "property double z\nproperty char code\nproperty uchar zone\nend_header\n"
                   "1 0 0 -7 9\n");
  const auto read = [&](const std::string& first, const std::string& second,
                        std::vector<std::string>* notes) {
    return read_all(*open_point_sources({scratch / first, scratch / second}, {}, notes));
  };
  std::vector<std::string> notes;
  const PointCloud ab = read("a.ply", "b.ply", &notes);
  const std::vector<AttributeField> expected = {{"intensity", ScalarType::kUint16},
                                                {"code", ScalarType::kInt16},
                                                {"time", ScalarType::kFloat64},
                                                {"zone", ScalarType::kUint8}};
  CHECK(ab.schema.attributes == expected);
  const auto row = [](const PointCloud& cloud, std::size_t i) {
    std::vector<double> values;
    for (std::size_t f = 0; f < 4; ++f) values.push_back(attribute_value(cloud, i, f));
    return values;
  };
  CHECK(row(ab, 0) == std::vector<double>{500, 200, 0.5, 0});
  CHECK(row(ab, 1) == std::vector<double>{0, -7, 0, 9});
  REQUIRE(notes.size() == 3);
  CHECK_THAT(notes[0], Contains("attribute intensity (uint16) is 0 at points of") &&
                           Contains("b.ply, which lacks it"));
  const PointCloud ba = read("b.ply", "a.ply", nullptr);
  CHECK(ba.schema.attributes == expected);
  CHECK(row(ba, 0) == row(ab, 1));
}

TEST_CASE("ColorsOf8BitsBesideColorsOf16BitsKeepTheirShades") {
  const test::ScratchDirectory scratch;
  const auto write = [&](const std::string& name, const std::string& type,
                         const std::string& colors) {
    test::write_text(
        scratch / name,
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n"
        "property double z\nproperty " +
            type + " red\nproperty " + type + " green\nproperty " + type +
            " blue\nend_header\n0 0 0 " + colors + "\n");
  };
  write("narrow.ply", "uchar", "200 255 0");
  write("wide.ply", "ushort", "65535 300 7");
  write("dim.ply", "ushort", "255 30 7");
  write("fraction.ply", "float", "1 0.5 0.25");
  const auto reds_and_greens = [&](const std::vector<std::string>& names) {
    std::vector<std::filesystem::path> paths;
    for (const std::string& name : names) paths.push_back(scratch / name);
    const PointCloud cloud = read_all(*open_point_sources(paths));
    std::vector<double> values;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      for (const std::size_t field : {0, 1}) values.push_back(attribute_value(cloud, i, field));
    return values;
  };
  using Values = std::vector<double>;
  CHECK(reds_and_greens({"narrow.ply", "wide.ply"}) == Values{200 * 257, 65'535, 65'535, 300});
  CHECK(reds_and_greens({"wide.ply", "narrow.ply"}) == Values{65'535, 300, 200 * 257, 65'535});
  CHECK(reds_and_greens({"narrow.ply", "dim.ply"}) == Values{200, 255, 255, 30});
  std::vector<std::string> notes;
  open_point_sources({scratch / "narrow.ply", scratch / "fraction.ply"}, {}, &notes);
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("colours are float32 in") && Contains("fraction.ply and uint8 in"));
}

}  // namespace orbweave
