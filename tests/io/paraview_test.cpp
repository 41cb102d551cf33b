// VTP and XDMF: what ParaView finds in them, by parsers that know nothing of the writers.
#include <hdf5.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "io/error.h"
#include "io/meshes/heavy_data.h"
#include "io/meshes/mesh_writer.h"
#include "io/system/hdf5_calls.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using test::read_file;
using test::ScratchDirectory;

constexpr double kEast = 4'176'000.123456789;

/// A torus far from the origin with normals, colours, a time and faces of holes.
TriangleMesh dressed_torus() {
  TriangleMesh mesh = test::moved(test::torus_mesh(70'000), [](Vec3 p) {
    return p + Vec3{kEast, -0.1, 1.0 / 3.0};
  });
  PointCloud& points = mesh.vertices;
  points.schema.has_normals = true;
  points.schema.normal_type = ScalarType::kFloat32;
  points.schema.attributes = {{"green", ScalarType::kUint8},
                              {"gps time <1>", ScalarType::kFloat64},
                              {"red", ScalarType::kUint8},
                              {"blue", ScalarType::kUint8},
                              {"class", ScalarType::kUint16}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    points.normals.push_back(normalized(points.positions[i] - Vec3{kEast, 0, 0}));
    const double time = 1e9 + 0.1 * static_cast<double>(i);
    const auto number = static_cast<std::uint16_t>(i);
    const auto add = [&](const void* value, std::size_t bytes) {
      const auto* from = static_cast<const std::byte*>(value);
      points.attributes.insert(points.attributes.end(), from, from + bytes);
    };
    const std::uint8_t green = 2, red = 1, blue = static_cast<std::uint8_t>(i);
    add(&green, 1);
    add(&time, 8);
    add(&red, 1);
    add(&blue, 1);
    add(&number, 2);
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    mesh.hole.push_back(static_cast<std::int32_t>(i % 3));
  return mesh;
}

double time_of(const TriangleMesh& mesh, std::size_t i) {
  return attribute_value(mesh.vertices, i, 1);
}

template <class T>
std::vector<T> values_in(const std::string& bytes, std::size_t at, std::size_t count) {
  std::vector<T> values(count);
  REQUIRE(at + count * sizeof(T) <= bytes.size());
  std::memcpy(values.data(), bytes.data() + at, count * sizeof(T));
  return values;
}

/// A file of VTK's XML format with raw data behind the document.
class VtpFile {
 public:
  explicit VtpFile(const fs::path& file) : bytes_(read_file(file)) {
    const std::size_t end = bytes_.find("<AppendedData");
    REQUIRE(end != std::string::npos);
    data_ = bytes_.find('_', end) + 1;
    const std::string text = bytes_.substr(0, end) + "</VTKFile>";
    REQUIRE(document_.load_buffer(text.data(), text.size()));
    CHECK(bytes_.ends_with("</AppendedData>\n</VTKFile>\n"));
  }
  pugi::xml_node root() const { return document_.child("VTKFile"); }
  pugi::xml_node piece() const { return root().child("PolyData").child("Piece"); }
  pugi::xml_node array(const char* parent, const char* name) const {
    return piece().child(parent).find_child_by_attribute("DataArray", "Name", name);
  }
  template <class T>
  std::vector<T> values(const char* parent, const char* name, const char* type) const {
    const pugi::xml_node node = array(parent, name);
    INFO(parent << " " << name);
    REQUIRE(node);
    CHECK(node.attribute("type").value() == std::string(type));
    CHECK(node.attribute("format").value() == std::string("appended"));
    const std::size_t at = data_ + node.attribute("offset").as_ullong();
    const auto bytes = values_in<std::uint64_t>(bytes_, at, 1)[0];
    return values_in<T>(bytes_, at + 8, bytes / sizeof(T));
  }

 private:
  std::string bytes_;
  std::size_t data_ = 0;
  pugi::xml_document document_;
};

/// Everything of an array of an HDF5 file, and its shape.
template <class T>
std::vector<T> h5_values(const fs::path& path, const std::string& name, hid_t type,
                         const std::vector<hsize_t>& shape) {
  INFO(name);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  REQUIRE(file >= 0);
  const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  REQUIRE(dataset >= 0);
  const hid_t space = H5Dget_space(dataset);
  std::vector<hsize_t> found(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, found.data(), nullptr);
  CHECK(found == shape);
  const hid_t stored = H5Dget_type(dataset);
  CHECK(H5Tequal(stored, type) > 0);
  std::size_t count = 1;
  for (const hsize_t extent : found) count *= extent;
  std::vector<T> values(count);
  CHECK(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
  H5Tclose(stored);
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  return values;
}

void check_points(const std::vector<double>& points, const TriangleMesh& mesh, Vec3 origin = {}) {
  REQUIRE(points.size() == 3 * mesh.vertices.size());
  bool same = true;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      same = same && points[3 * i + static_cast<std::size_t>(axis)] ==
                         (mesh.vertices.positions[i] - origin)[axis];
  CHECK(same);
}

void check_corners(const std::vector<std::int64_t>& corners, const TriangleMesh& mesh) {
  REQUIRE(corners.size() == 3 * mesh.triangles.size());
  bool same = true;
  for (std::size_t i = 0; i < corners.size(); ++i)
    same = same && corners[i] == std::int64_t{mesh.triangles[i / 3][i % 3]};
  CHECK(same);
}

void check_colors(const std::vector<std::uint8_t>& colors) {
  bool same = true;
  for (std::size_t i = 0; i < colors.size() / 3; ++i)
    same = same && colors[3 * i] == 1 && colors[3 * i + 1] == 2 &&
           colors[3 * i + 2] == static_cast<std::uint8_t>(i);
  CHECK(same);
}

}  // namespace

TEST_CASE("VtpHoldsTheMeshWithDoublesAndAttributes") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = dressed_torus();
  write_mesh(scratch / "mesh.vtp", mesh);
  const VtpFile file(scratch / "mesh.vtp");
  CHECK(file.root().attribute("type").value() == std::string("PolyData"));
  CHECK(file.root().attribute("byte_order").value() == std::string("LittleEndian"));
  CHECK(file.root().attribute("header_type").value() == std::string("UInt64"));
  CHECK(file.piece().attribute("NumberOfPoints").as_ullong() == mesh.vertices.size());
  CHECK(file.piece().attribute("NumberOfPolys").as_ullong() == mesh.triangles.size());
  check_points(file.values<double>("Points", "Points", "Float64"), mesh);
  check_corners(file.values<std::int64_t>("Polys", "connectivity", "Int64"), mesh);
  for (const char* list : {"connectivity", "offsets"})  // VTK reads no lists of several components
    CHECK(file.array("Polys", list).attribute("NumberOfComponents").as_int() == 1);
  const auto ends = file.values<std::int64_t>("Polys", "offsets", "Int64");
  REQUIRE(ends.size() == mesh.triangles.size());
  bool counts = true;
  for (std::size_t i = 0; i < ends.size(); ++i)
    counts = counts && ends[i] == static_cast<std::int64_t>(3 * (i + 1));
  CHECK(counts);
  CHECK(file.values<std::int32_t>("CellData", "hole", "Int32") == mesh.hole);
  CHECK(file.array("PointData", "RGB").attribute("NumberOfComponents").as_int() == 3);
  check_colors(file.values<std::uint8_t>("PointData", "RGB", "UInt8"));
  const auto times = file.values<double>("PointData", "gps_time__1_", "Float64");
  CHECK(times[1234] == time_of(mesh, 1234));
  CHECK(file.values<std::uint16_t>("PointData", "class", "UInt16")[300] == 300);
  const auto normals = file.values<float>("PointData", "Normals", "Float32");
  CHECK(normals[3] == static_cast<float>(mesh.vertices.normals[1].x));
  CHECK_FALSE(file.array("PointData", "red"));
}

TEST_CASE("XdmfNamesTheArraysThatTheHdf5FileHolds") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = dressed_torus();
  write_mesh(scratch / "mesh.xdmf", mesh);
  pugi::xml_document document;
  REQUIRE(document.load_file((scratch / "mesh.xdmf").c_str()));
  const pugi::xml_node grid = document.child("Xdmf").child("Domain").child("Grid");
  const auto item = [](const pugi::xml_node& node) {
    const pugi::xml_node data = node.child("DataItem");
    CHECK(data.attribute("Format").value() == std::string("HDF"));
    const std::string text = data.text().get();
    CHECK(text.starts_with("mesh.h5:/"));
    return text.substr(text.find(':') + 1);
  };
  const auto attribute = [&](const char* name) {
    return grid.find_child_by_attribute("Attribute", "Name", name);
  };
  const fs::path numbers = scratch / "mesh.h5";
  REQUIRE(heavy_data_file(scratch / "mesh.xdmf") == numbers);
  const hsize_t vertices = mesh.vertices.size(), triangles = mesh.triangles.size();
  CHECK(grid.child("Topology").attribute("TopologyType").value() == std::string("Triangle"));
  CHECK(grid.child("Topology").attribute("NumberOfElements").as_ullong() == triangles);
  check_points(
      h5_values<double>(numbers, item(grid.child("Geometry")), H5T_NATIVE_DOUBLE, {vertices, 3}),
      mesh);
  check_corners(h5_values<std::int64_t>(numbers, item(grid.child("Topology")), H5T_NATIVE_INT64,
                                        {triangles, 3}),
                mesh);
  CHECK(h5_values<std::int32_t>(numbers, item(attribute("hole")), H5T_NATIVE_INT32, {triangles}) ==
        mesh.hole);
  CHECK(attribute("hole").attribute("Center").value() == std::string("Cell"));
  check_colors(
      h5_values<std::uint8_t>(numbers, item(attribute("RGB")), H5T_NATIVE_UINT8, {vertices, 3}));
  CHECK(h5_values<double>(numbers, item(attribute("gps_time__1_")), H5T_NATIVE_DOUBLE,
                          {vertices})[1234] == time_of(mesh, 1234));
  CHECK(attribute("Normals").attribute("AttributeType").value() == std::string("Vector"));
}

TEST_CASE("IntegersOfEightBytesAreSignedOnesInXdmf") {
  const ScratchDirectory scratch;
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.vertices.schema.attributes = {{"nanoseconds", ScalarType::kUint64}};
  const std::uint64_t time = 1'700'000'000'123'456'789;
  for (std::uint64_t i = 0; i < 3; ++i)
    for (const char c : test::raw(time + i))
      mesh.vertices.attributes.push_back(static_cast<std::byte>(c));
  mesh.triangles = {{0, 1, 2}};
  write_mesh(scratch / "mesh.xdmf", mesh);
  // Readers of XDMF take unsigned ones for those of four bytes, and clip what is larger.
  CHECK_THAT(read_file(scratch / "mesh.xdmf"),
             Contains("<DataItem Dimensions=\"3\" NumberType=\"Int\" Precision=\"8\" "
                      "Format=\"HDF\">mesh.h5:/nanoseconds<"));
  CHECK(h5_values<std::uint64_t>(scratch / "mesh.h5", "nanoseconds", H5T_NATIVE_UINT64, {3})[2] ==
        time + 2);
}

TEST_CASE("NumbersOfAnXdmfReplaceThoseOfAMeshAlone") {
  const ScratchDirectory scratch;
  const fs::path mesh = scratch / "mesh.xdmf", numbers = scratch / "mesh.h5";
  CHECK_NOTHROW(check_heavy_data(mesh));
  const std::string measured = "what somebody measured";
  std::ofstream(numbers) << measured;
  CHECK_THROWS_AS(check_heavy_data(mesh), Error);
  CHECK(read_file(numbers) == measured);
  const std::vector<Hdf5Array> other = {{"Points", ScalarType::kFloat64, {3, 3}}};
  make_hdf5_file(numbers, numbers, other);
  CHECK_THROWS_AS(check_heavy_data(mesh), Error);
  const std::vector<Hdf5Array> earlier = {{"Points", ScalarType::kFloat64, {3, 3}},
                                          {"connectivity", ScalarType::kInt64, {1, 3}}};
  make_hdf5_file(numbers, numbers, earlier);
  CHECK_NOTHROW(check_heavy_data(mesh));
  fs::remove(numbers);
  fs::create_directory(numbers);
  CHECK_THROWS_AS(check_heavy_data(mesh), Error);
  CHECK_NOTHROW(check_heavy_data(scratch / "mesh.ply"));
}

TEST_CASE("AnXdmfWhoseXmlCannotHoldTheNameOfItsNumbersIsRefused") {
  const ScratchDirectory scratch;
  for (const char* name : {"m\xE4sh.xdmf", "a\x1B.xdmf", "a\nb.xdmf"}) {
    CHECK_THROWS_WITH(write_mesh(scratch / name, dressed_torus()),
                      Contains("cannot name the file"));
    CHECK(fs::is_empty(scratch.path()));
  }
  write_mesh(scratch / "mäsh & <b>.xdmf", dressed_torus());
  pugi::xml_document document;
  CHECK(document.load_file((scratch / "mäsh & <b>.xdmf").c_str()));
}

TEST_CASE("FilesForParaViewHaveTheSameBytesEachTime") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = dressed_torus();
  for (const char* name : {"a", "b"}) {
    fs::create_directory(scratch / name);
    write_mesh(scratch / name / "mesh.vtp", mesh);
    write_mesh(scratch / name / "mesh.xdmf", mesh);
  }
  for (const char* file : {"mesh.vtp", "mesh.xdmf", "mesh.h5"})
    CHECK((read_file(scratch / "a" / file) == read_file(scratch / "b" / file)));
}

TEST_CASE("CoordinatesForParaViewAreFloatsFromAnOriginWhereThatIsAskedFor") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = dressed_torus();
  MeshWriterOptions options;
  options.origin = {kEast, 0, 0};
  write_mesh(scratch / "far.vtp", mesh, options);
  check_points(VtpFile(scratch / "far.vtp").values<double>("Points", "Points", "Float64"), mesh,
               options.origin);
  options.float_positions = true;
  CHECK(has_float_coordinates(scratch / "near.vtp", options));
  CHECK(has_float_coordinates(scratch / "near.xdmf", options));
  write_mesh(scratch / "near.vtp", mesh, options);
  const auto floats = VtpFile(scratch / "near.vtp").values<float>("Points", "Points", "Float32");
  CHECK(floats[4] == static_cast<float>(mesh.vertices.positions[1].y));
}

TEST_CASE("AMeshWithoutTrianglesIsAFileForParaView") {
  const ScratchDirectory scratch;
  TriangleMesh mesh;
  mesh.vertices.positions = {{1, 2, 3}};
  write_mesh(scratch / "one.vtp", mesh);
  CHECK(VtpFile(scratch / "one.vtp").values<std::int64_t>("Polys", "offsets", "Int64").empty());
  write_mesh(scratch / "one.xdmf", mesh);
  CHECK(h5_values<double>(scratch / "one.h5", "Points", H5T_NATIVE_DOUBLE, {1, 3}) ==
        std::vector<double>{1, 2, 3});
}

TEST_CASE("FilesForParaViewAppearWholeOrNotAtAll") {
  const ScratchDirectory scratch;
  MeshHeader header;
  header.vertices = 3;
  header.triangles = 1;
  for (const char* name : {"mesh.vtp", "mesh.xdmf"}) {
    const auto writer = open_mesh_writer(scratch / name, header);
    PointCloud points;
    points.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    writer->write_vertices(points);
  }
  CHECK(fs::is_empty(scratch.path()));
  CHECK_THROWS_WITH(open_mesh_writer("/dev/null.vtp/x.vtp", header), Contains("x.vtp"));
}

}  // namespace orbweave
