#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "io/clouds/open_point_source.h"
#include "io/clouds/point_source_list.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using test::raw;
using test::read_cloud;
using test::reading_error;
using test::same_bits;
using test::ScratchDirectory;
using test::write_file;

std::string header(const std::string& format, const std::string& rest) {
  return "ply\nformat " + format + " 1.0\n" + rest + "end_header\n";
}

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";

/// Three vertices with every scalar type as an attribute, and the same in the three formats.
struct AllTypes {
  PointCloud cloud;
  std::string ascii;
  std::string little;
  std::string big;
};

template <class T>
void add_value(AllTypes& all, T value, const std::string& text) {
  all.ascii += text + " ";
  all.little += raw(value);
  all.big += raw(value, true);
  const std::string bytes = raw(value);
  for (const char c : bytes) all.cloud.attributes.push_back(static_cast<std::byte>(c));
}

AllTypes make_all_types() {
  AllTypes all;
  const std::string elements =
      "element vertex 3\nproperty char a\nproperty double x\nproperty uint8 b\nproperty int16 c\n"
      "property float y\nproperty ushort d\nproperty int32 e\nproperty uint f\n"
      "property short z\nproperty int64 g\nproperty uint64 h\nproperty float32 i\n"
      "property float64 j\n";
  all.ascii = header("ascii", elements);
  all.little = header("binary_little_endian", elements);
  all.big = header("binary_big_endian", elements);
  using S = ScalarType;
  all.cloud.schema.attributes = {{"a", S::kInt8},   {"b", S::kUint8},  {"c", S::kInt16},
                                 {"d", S::kUint16}, {"e", S::kInt32},  {"f", S::kUint32},
                                 {"g", S::kInt64},  {"h", S::kUint64}, {"i", S::kFloat32},
                                 {"j", S::kFloat64}};
  const auto add_position = [&](auto value, const std::string& text) {
    all.ascii += text + " ";
    all.little += raw(value);
    all.big += raw(value, true);
  };
  for (int row = 0; row < 3; ++row) {
    add_value(all, std::int8_t{-128}, "-128");
    add_position(0.1 + row, row == 0 ? "0.1" : row == 1 ? "1.1" : "2.1");
    add_value(all, std::uint8_t{255}, "255");
    add_value(all, std::int16_t{-32768}, "-32768");
    add_position(0.1f, "0.1");
    add_value(all, std::uint16_t{65535}, "65535");
    add_value(all, std::numeric_limits<std::int32_t>::min(), "-2147483648");
    add_value(all, std::numeric_limits<std::uint32_t>::max(), "4294967295");
    add_position(std::int16_t{-7}, "-7");
    add_value(all, std::numeric_limits<std::int64_t>::min(), "-9223372036854775808");
    add_value(all, std::numeric_limits<std::uint64_t>::max(), "18446744073709551615");
    add_value(all, 16777217.5f, "16777217.5");
    add_value(all, 1e300, "1e300");
    all.ascii += "\n";
    all.cloud.positions.push_back({0.1 + row, static_cast<double>(0.1f), -7.0});
  }
  return all;
}

}  // namespace

TEST_CASE("EveryTypeAndByteOrderGivesTheSameCloud") {
  const ScratchDirectory scratch;
  const AllTypes all = make_all_types();
  write_file(scratch / "ascii.ply", all.ascii);
  write_file(scratch / "little.ply", all.little);
  write_file(scratch / "big.ply", all.big);
  for (const char* name : {"ascii.ply", "little.ply", "big.ply"}) {
    INFO(name);
    CHECK(same_bits(read_cloud(scratch / name), all.cloud));
  }
}

TEST_CASE("WrittenCloudsReadBackBitForBit") {
  const ScratchDirectory scratch;
  PointCloud cloud = make_all_types().cloud;
  cloud.schema.has_normals = true;
  cloud.schema.normal_type = ScalarType::kFloat32;
  cloud.normals = {{0, 0, 1}, {static_cast<double>(0.6f), 0, 0}, {-1, 0, 0}};
  MeshWriterOptions text;
  text.binary = false;
  write_cloud(scratch / "binary.ply", cloud);
  write_cloud(scratch / "text.ply", cloud, text);
  write_cloud(scratch / "binary.ply.gz", cloud);
  CHECK(same_bits(read_cloud(scratch / "binary.ply"), cloud));
  CHECK(same_bits(read_cloud(scratch / "text.ply"), cloud));
  CHECK(same_bits(read_cloud(scratch / "binary.ply.gz"), cloud));
}

TEST_CASE("BatchesOfAnyCapacityGiveTheSameCloud") {
  const ScratchDirectory scratch;
  PointCloud cloud;
  cloud.schema.attributes = {{"id", ScalarType::kUint32}};
  for (std::uint32_t i = 0; i < 30000; ++i) {
    cloud.positions.push_back({0.5 * i, 1.0 / (i + 1.0), -1.0 * i});
    for (const char c : raw(i)) cloud.attributes.push_back(static_cast<std::byte>(c));
  }
  MeshWriterOptions text;
  text.binary = false;
  write_cloud(scratch / "binary.ply", cloud);
  write_cloud(scratch / "text.ply", cloud, text);
  write_cloud(scratch / "cloud.csv", cloud);
  for (const char* name : {"binary.ply", "text.ply", "cloud.csv"}) {
    const PointCloud whole = read_cloud(scratch / name);
    REQUIRE(whole.positions == cloud.positions);
    for (const std::size_t capacity : {1U, 7U, 1000U, 29999U, 30000U, 1000000U}) {
      INFO(name << " in batches of " << capacity);
      const auto source = open_point_source(scratch / name);
      PointCloud joined;
      joined.schema = source->schema();
      PointCloud batch;
      bool within = true;
      while (source->read(batch, capacity)) {
        within = within && batch.size() <= capacity;
        joined.append(batch);
      }
      CHECK(within);
      CHECK(batch.empty());
      CHECK(same_bits(joined, whole));
      CHECK_FALSE(source->read(batch, capacity));
      CHECK(source->bytes_read() == source->bytes_total());
    }
  }
}

PointCloud thousand_points() {
  PointCloud cloud;
  cloud.schema.has_normals = true;
  for (int i = 0; i < 1000; ++i) {
    cloud.positions.push_back({0.5 * i, 1.0 / (i + 1), -1.0 * i});
    cloud.normals.push_back({0.0, 0.0, i % 2 == 0 ? 1.0 : -1.0});
  }
  return cloud;
}

/// What `shares` readers get together, one after the other.
PointCloud read_in_shares(const std::vector<std::filesystem::path>& paths, std::uint64_t shares) {
  PointCloud together;
  for (std::uint64_t share = 0; share < shares; ++share) {
    const auto source = open_point_sources(paths);
    const std::uint64_t points = source->declared_points().value();
    const std::uint64_t first = points * share / shares;
    REQUIRE(source->restrict_rows(first, points * (share + 1) / shares - first));
    const PointCloud part = read_all(*source);
    if (together.empty())
      together = part;
    else
      together.append(part);
  }
  return together;
}

TEST_CASE("SharesOfFilesAreTheWholeFiles") {
  const ScratchDirectory scratch;
  const PointCloud cloud = thousand_points();
  MeshWriterOptions text;
  text.binary = false;
  write_cloud(scratch / "a.ply", cloud);
  write_cloud(scratch / "b.ply", cloud, text);  // no row has a fixed place
  write_cloud(scratch / "c.ply.gz", cloud);     // nor here
  const std::vector<std::filesystem::path> alone = {scratch / "a.ply"};
  const std::vector<std::filesystem::path> all = {scratch / "b.ply", scratch / "a.ply",
                                                  scratch / "c.ply.gz"};
  for (const std::uint64_t shares : {1, 2, 3, 7, 1001}) {
    CHECK(same_bits(read_in_shares(alone, shares), cloud));
    PointCloud thrice = cloud;
    thrice.append(cloud);
    thrice.append(cloud);
    CHECK(same_bits(read_in_shares(all, shares), thrice));
  }
}

TEST_CASE("RowsWithoutAFixedPlaceAreNotRestricted") {
  const ScratchDirectory scratch;
  MeshWriterOptions text;
  text.binary = false;
  write_cloud(scratch / "text.ply", thousand_points(), text);
  const auto source = open_point_source(scratch / "text.ply");
  CHECK_FALSE(source->restrict_rows(10, 10));
  CHECK(read_all(*source).size() == 1000);
}

TEST_CASE("ListsAndOtherElementsAroundTheVerticesAreParsedAndDropped") {
  const ScratchDirectory scratch;
  const std::string elements =
      "comment a comment\nobj_info an info\nelement camera 2\nproperty list uchar float view\n"
      "property int id\nelement vertex 2\nproperty list ushort double weights\nproperty float x\n"
      "property float y\nproperty list char uchar tags\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_index\n";
  write_file(
      scratch / "ascii.ply",
      header("ascii", elements) + "2 0.5 0.25 1\n0 2\n\n1 9.5 1 2 2 7 8 3\n0 4 5 0 6\n2 0 1\n");
  for (const bool big : {false, true}) {
    std::string body;
    body += raw(std::uint8_t{2}) + raw(0.5f, big) + raw(0.25f, big) + raw(std::int32_t{1}, big);
    body += raw(std::uint8_t{0}) + raw(std::int32_t{2}, big);
    body += raw(std::uint16_t{1}, big) + raw(9.5, big) + raw(1.f, big) + raw(2.f, big) +
            raw(std::uint8_t{2}) + "ab" + raw(3.f, big);
    body += raw(std::uint16_t{0}, big) + raw(4.f, big) + raw(5.f, big) + raw(std::uint8_t{0}) +
            raw(6.f, big);
    body += raw(std::uint8_t{2}) + raw(std::int32_t{0}, big) + raw(std::int32_t{1}, big);
    write_file(scratch / (big ? "big.ply" : "little.ply"),
               header(big ? "binary_big_endian" : "binary_little_endian", elements) + body);
  }
  for (const char* name : {"ascii.ply", "little.ply", "big.ply"}) {
    INFO(name);
    const PointCloud cloud = read_cloud(scratch / name);
    CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}});
    CHECK(cloud.schema.attributes.empty());
  }
}

TEST_CASE("CarriageReturnsDoNotMatter") {
  const ScratchDirectory scratch;
  write_file(
      scratch / "text.ply",
      "ply\r\nformat ascii 1.0\r\nelement vertex 2\r\nproperty float x\r\nproperty float y\r\n"
      "property uchar z\r\nend_header\r\n1 2 3\r\n4 5 6\r\n");
  write_file(scratch / "binary.ply",
             "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 2\r\nproperty uchar x\r\n"
             "property uchar y\r\nproperty uchar z\r\nend_header\r\n\x01\x02\x03\x04\x05\x06");
  for (const char* name : {"text.ply", "binary.ply"})
    CHECK(read_cloud(scratch / name).positions == std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}});
}

TEST_CASE("NanAndInfinityPassThroughReaders") {
  const ScratchDirectory scratch;
  write_file(scratch / "a.ply",
             header("ascii", "element vertex 2\n" + kXyz) + "nan 0 inf\n-inf 1 2\n");
  write_file(scratch / "a.xyz", "nan 0 inf\n-inf 1 2\n");
  for (const char* name : {"a.ply", "a.xyz"}) {
    const PointCloud cloud = read_cloud(scratch / name);
    REQUIRE(cloud.size() == 2);
    CHECK(std::isnan(cloud.positions[0].x));
    CHECK(cloud.positions[0].z == std::numeric_limits<double>::infinity());
    CHECK(cloud.positions[1].x == -std::numeric_limits<double>::infinity());
  }
}

TEST_CASE("NormalsNeedAllThreeComponents") {
  const ScratchDirectory scratch;
  write_file(scratch / "two.ply", header("ascii", "element vertex 1\n" + kXyz +
                                                      "property float nx\nproperty float ny\n") +
                                      "0 0 0 1 2\n");
  const PointSchema two = read_cloud(scratch / "two.ply").schema;
  CHECK_FALSE(two.has_normals);
  CHECK(two.attributes.size() == 2);
  write_file(scratch / "three.ply",
             header("ascii", "element vertex 1\nproperty double nz\n" + kXyz +
                                 "property float nx\nproperty float ny\n") +
                 "3 0 0 0 1 2\n");
  const PointCloud three = read_cloud(scratch / "three.ply");
  CHECK(three.schema.has_normals);
  CHECK(three.schema.normal_type == ScalarType::kFloat64);
  CHECK(three.schema.position_type == ScalarType::kFloat32);
  CHECK(three.normals == std::vector<Vec3>{{1, 2, 3}});
}

/// A PLY file of one vertex whose properties are 1, 2, 3, ...
std::string ply_of(const std::vector<std::string>& names) {
  std::string properties, values;
  for (std::size_t i = 0; i < names.size(); ++i) {
    properties += "property float " + names[i] + "\n";
    values += std::to_string(i + 1) + " ";
  }
  return header("ascii", "element vertex 1\n" + properties) + values + "\n";
}

TEST_CASE("NormalsAndColorsAreKnownByTheNamesThatOtherProgramsGiveThem") {
  using Strings = std::vector<std::string>;
  const ScratchDirectory scratch;
  const auto read = [&](const Strings& names) {
    write_file(scratch / "a.ply", ply_of(names));
    return read_cloud(scratch / "a.ply");
  };
  for (const Strings& normal :
       {Strings{"normal_x", "normal_y", "normal_z"}, Strings{"normalx", "normaly", "normalz"},
        Strings{"NormalX", "NormalY", "NormalZ"}, Strings{"scalar_Nx", "scalar_Ny", "scalar_Nz"}}) {
    CAPTURE(normal[0]);
    const PointCloud cloud = read({"x", "y", "z", normal[0], normal[1], normal[2]});
    CHECK(cloud.normals == std::vector<Vec3>{{4, 5, 6}});
    CHECK(cloud.schema.attributes.empty());
  }
  for (const Strings& color : {Strings{"diffuse_red", "diffuse_green", "diffuse_blue"},
                               Strings{"r", "g", "b"}, Strings{"Red", "Green", "Blue"}}) {
    CAPTURE(color[0]);
    const PointCloud cloud = read({"X", "Y", "Z", color[2], color[1], color[0], "Quality"});
    CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}});
    CHECK(test::attribute_names(cloud.schema) == Strings{"blue", "green", "red", "Quality"});
  }
}

TEST_CASE("NamesOfOtherProgramsAreLeftWhereARoleIsTakenOrNotWhole") {
  using Strings = std::vector<std::string>;
  const ScratchDirectory scratch;
  const auto names = [&](const Strings& properties) {
    write_file(scratch / "a.ply", ply_of(properties));
    return test::attribute_names(read_cloud(scratch / "a.ply").schema);
  };
  const Strings both = {"red", "green", "blue", "r", "g", "b", "Normal_x", "Normal_y", "Normal_z"};
  CHECK(names({"x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "r", "g", "b", "Normal_x",
               "Normal_y", "Normal_z"}) == both);
  CHECK(names({"x", "y", "z", "r", "g", "normal_x", "normal_y"}) ==
        Strings{"r", "g", "normal_x", "normal_y"});
}

TEST_CASE("SamplePlyFilesHaveTheirPoints") {
  const auto sample = [](const std::string& name) {
    return test::data_path("samples/ply/" + name);
  };
  if (test::skipped_without(sample("ripple_bin.ply"))) return;
  CHECK(read_cloud(sample("simple_binary.ply")).size() == 3);
  CHECK(read_cloud(sample("mesh.ply")).positions ==
        std::vector<Vec3>{{1, 1, 0}, {2, 1, 0}, {1, 2, 0}, {2, 2, 2}});
  const PointCloud cube = read_cloud(sample("cube_att.ply"));
  CHECK(cube.size() == 24);
  CHECK(cube.bounds() == Box{{0, 0, 0}, {1, 1, 1}});
  const PointCloud extra = read_cloud(sample("text_extradim.ply"));
  REQUIRE(extra.size() == 1);
  CHECK(extra.schema.attributes.size() == 5);
  CHECK(attribute_value(extra, 0, 4) == 1234.0);
  CHECK(attribute_value(extra, 0, 2) == 64.0);
}

TEST_CASE("OneCloudInThreeFormatsIsOneCloud") {
  const auto binary = test::data_path("samples/ply/ripple_bin.ply");
  const auto ascii = test::data_path("samples/ply/ripple_ascii.ply");
  const auto text = test::data_path("samples/ascii/ripple.txt");
  if (test::skipped_without(binary) || test::skipped_without(text)) return;
  const PointCloud a = read_cloud(binary);
  const PointCloud b = read_cloud(ascii);
  const PointCloud c = read_cloud(text);
  REQUIRE(a.size() == 10201);
  REQUIRE(b.size() == 10201);
  REQUIRE(c.size() == 10201);
  CHECK(a.attributes == b.attributes);
  CHECK(a.attributes == c.attributes);
  double between_formats = 0.0;
  double to_text = 0.0;
  double normal_flip = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    between_formats = std::max(between_formats, norm(a.positions[i] - b.positions[i]));
    to_text = std::max(to_text, norm(a.positions[i] - c.positions[i]));
    normal_flip = std::max(normal_flip, norm(a.normals[i] + c.normals[i]));
  }
  CHECK(between_formats < 1e-5);  // five decimals
  CHECK(to_text < 1e-4);          // four decimals
  CHECK(normal_flip < 0.03);      // estimated anew, and they point the other way
}

TEST_CASE("PlyWithoutAPositionIsRefusedByName") {
  for (const char* name : {"sized_dims.ply", "unsized_dims.ply"}) {
    const auto path = test::data_path(std::string("samples/ply/") + name);
    if (test::skipped_without(path)) return;
    const Error error = reading_error(path);
    CHECK(error.kind() == ErrorKind::kBadInput);
    CHECK_THAT(error.what(), Catch::Contains("no property z"));
  }
  const auto none = test::data_path("samples/corrupt/no_vertex.ply");
  CHECK(reading_error(none).kind() == ErrorKind::kBadInput);
  CHECK_THAT(reading_error(none).what(), Catch::Contains("no vertices"));
}

TEST_CASE("AnAttributeMayHoldWhatItsTypeHolds") {
  // Filed among corrupt samples for a program that squeezes "i" into 16 bits; it is valid PLY.
  const auto path = test::data_path("samples/corrupt/issue_2421.ply");
  if (test::skipped_without(path)) return;
  const PointCloud cloud = read_cloud(path);
  REQUIRE(cloud.size() == 1);
  CHECK(cloud.positions[0] == Vec3{1.23457, 12345.67890, 1234567890.12345});
  CHECK(attribute_value(cloud, 0, 0) == 1234567890.0);
}

TEST_CASE("MeshesKeepFacesAndHoles") {
  const ScratchDirectory scratch;
  write_file(scratch / "a.ply",
             header("ascii",
                    "element face 3\nproperty int hole\nproperty list uchar uint vertex_indices\n"
                    "property list uchar float texcoord\nelement vertex 4\n" +
                        kXyz) +
                 "0 3 0 1 2 1 0.5\n7 4 0 1 2 3 0\n1 3 3 2 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n");
  const TriangleMesh mesh = read_mesh(scratch / "a.ply");
  CHECK(mesh.vertices.size() == 4);
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {3, 2, 1}});
  CHECK(mesh.hole == std::vector<std::int32_t>{0, 7, 7, 1});
  CHECK(holds_faces(scratch / "a.ply"));
  CHECK(read_cloud(scratch / "a.ply").size() == 4);
  write_file(scratch / "b.ply", header("ascii", "element vertex 1\n" + kXyz +
                                                    "element face 0\nproperty list uchar int "
                                                    "vertex_indices\n") +
                                    "0 0 0\n");
  CHECK_FALSE(holds_faces(scratch / "b.ply"));
}

TEST_CASE("SampleMeshesHaveTheirTriangles") {
  const auto cube = test::data_path("samples/ply/cube_att.ply");
  if (test::skipped_without(cube)) return;
  CHECK(read_mesh(cube).triangles.size() == 12);
  CHECK(read_mesh(test::data_path("samples/ply/mesh.ply")).triangles ==
        std::vector<Triangle>{{0, 1, 2}, {1, 2, 3}});
}

}  // namespace orbweave
