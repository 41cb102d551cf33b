// Names that are bytes and no text: of attributes, coordinate systems and files. They are kept as
// they are, and shown so that no terminal, page or parser stumbles over them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/shown_text.h"
#include "tests/io/e57_files.h"
#include "tests/io/las_files.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

namespace {

using Catch::Matchers::Contains;
using nlohmann::json;
using orbweave::is_utf8;
using orbweave::shown;
using orbweave::Vec3;
using orbweave::test::file_text;
using orbweave::test::ProgramResult;
using orbweave::test::raw;
using orbweave::test::run_in;
using orbweave::test::run_program;
using orbweave::test::ScratchDirectory;
using orbweave::test::write_text;
using Arguments = std::vector<std::string>;

const std::string kLatin = "intensit\xe4t";                 // Latin-1
const std::string kTurkish = "\xc3\xb6l\xc3\xa7\xc3\xbcm";  // UTF-8
const std::string kEscape = "\x1b[31mred";                  // would colour a terminal
const std::string kSystem = "PROJCS[\"Gau\xdf-Kr\xfcger \x1b[2J\",UNIT[\"metre\",1]]";

/// A sphere's points; the normal of each is the point itself.
std::vector<Vec3> sphere() {
  constexpr int kPoints = 500;
  std::vector<Vec3> points;
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kPoints;
    const double radius = std::sqrt(1.0 - z * z), angle = 2.399963229728653 * i;
    points.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
  }
  return points;
}

std::string rows(const char* separator) {
  std::string text;
  for (const Vec3& p : sphere()) {
    std::string row;
    for (int twice = 0; twice < 2; ++twice)
      for (int axis = 0; axis < 3; ++axis) row += std::to_string(p[axis]) + separator;
    text += row + "7" + separator + "8" + separator + "9\n";
  }
  return text;
}

const Arguments kNames = {kLatin, kTurkish, kEscape};

std::string ascii_ply() {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 500\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    text += std::string("property double ") + name + "\n";
  for (const std::string& name : kNames) text += "property uchar " + name + "\n";
  return text + "end_header\n" + rows(" ");
}

std::string binary_ply() {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex 500\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    text += std::string("property double ") + name + "\n";
  for (const std::string& name : kNames) text += "property uchar " + name + "\n";
  text += "end_header\n";
  for (const Vec3& p : sphere()) {
    for (int twice = 0; twice < 2; ++twice)
      for (int axis = 0; axis < 3; ++axis) text += raw(p[axis]);
    text += "\7\10\11";
  }
  return text;
}

std::string csv() {
  return "x,y,z,nx,ny,nz," + kLatin + "," + kTurkish + "," + kEscape + "\n" + rows(",");
}

std::string text() {
  return "# x y z nx ny nz " + kLatin + " " + kTurkish + " " + kEscape + "\n" + rows(" ");
}

std::string pcd() {
  return "# .PCD v.7\nVERSION .7\nFIELDS x y z normal_x normal_y normal_z " + kLatin + " " +
         kTurkish + " " + kEscape +
         "\nSIZE 8 8 8 8 8 8 1 1 1\nTYPE F F F F F F U U U\nCOUNT 1 1 1 1 1 1 1 1 1\n"
         "WIDTH 500\nHEIGHT 1\nPOINTS 500\nDATA ascii\n" +
         rows(" ");
}

std::string extra_bytes(const std::string& name) {
  std::string padded = name;
  padded.resize(32);
  return std::string(2, 'r') + "\1" + std::string(1, '\0') + padded + std::string(4 + 72, 'u') +
         std::string(6 * 8, '\0') + std::string(32, 't');
}

std::string las() {
  orbweave::test::LasFile file;
  file.minor = 4;
  file.format = 6;
  file.global_encoding = 16;
  file.scale = {1e-6, 1e-6, 1e-6};
  std::string described;
  for (const std::string& name : kNames) described += extra_bytes(name);
  file.variable_records = {orbweave::test::variable_record("LASF_Projection", 2112, kSystem),
                           orbweave::test::variable_record("LASF_Spec", 4, described)};
  for (const Vec3& p : sphere()) {
    orbweave::test::LasPoint point;
    for (int axis = 0; axis < 3; ++axis)
      point.xyz[static_cast<std::size_t>(axis)] =
          static_cast<std::int32_t>(std::lround(1e6 * p[axis]));
    point.extra = "\7\10\11";
    file.add(point);
  }
  return file.bytes();
}

bool has_control(const std::string& text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < ' ' && c != '\n') return true;
  return false;
}

/// All that people and programs are shown.
void check_shown(const ProgramResult& result) {
  INFO(shown(result.err));
  CHECK(result.status == 0);
  for (const std::string& text : {result.out, result.err}) {
    CHECK(is_utf8(text));
    CHECK_FALSE(has_control(text));
  }
}

std::vector<std::string> attribute_names(const json& facts) {
  std::vector<std::string> names;
  for (const json& attribute : facts.at("attributes")) names.push_back(attribute.at("name"));
  return names;
}

/// The header of a PLY file up to its end.
std::string header_of(const std::string& ply) { return ply.substr(0, ply.find("end_header\n")); }

void check_header(const std::string& ply, const Arguments& names) {
  const std::string header = header_of(ply);
  for (const std::string& name : names) {
    INFO(shown(name));
    CHECK(header.find(" " + name + "\n") != std::string::npos);
  }
}

struct Format {
  std::string name;
  std::string content;
  bool has_normals = true;
  std::string system = {};
  std::string third = kEscape;  ///< of kNames, as the reader gives it
};

void check_report(const ScratchDirectory& in, const Format& format) {
  const std::string text = file_text(in / "report.json");
  REQUIRE(is_utf8(text));
  const json report = json::parse(text);
  if (format.system.empty())
    CHECK(report["coordinate_system"].is_null());
  else
    CHECK(report["coordinate_system"].get<std::string>() == orbweave::as_utf8(format.system));
  CHECK(is_utf8(file_text(in / "report.html")));
  CHECK_FALSE(has_control(file_text(in / "report.html")));
}

}  // namespace

TEST_CASE("NamesOfAttributesAreKeptByteForByteAndShownSafely", "[slow]") {
  const ScratchDirectory in;
  const Format format =
      GENERATE(Format{"a.ply", ascii_ply()}, Format{"b.ply", binary_ply()}, Format{"c.csv", csv()},
               Format{"d.txt", text()}, Format{"d.pcd", pcd()},
               Format{"e.las", las(), false, kSystem, "_[31mred"});
  INFO(format.name);
  write_text(in / format.name, format.content);
  check_shown(run_in(in, {"inspect", format.name}));
  const ProgramResult inspected = run_in(in, {"inspect", format.name, "--json"});
  check_shown(inspected);
  const std::vector<std::string> names = attribute_names(json::parse(inspected.out));
  for (const std::string& name : {std::string("intensit\\xe4t"), kTurkish, format.third}) {
    INFO(shown(name));
    CHECK(std::find(names.begin(), names.end(), name) != names.end());
  }

  check_shown(run_in(in, {"convert", format.name, "copy.ply"}));
  const Arguments kept_names = {kLatin, kTurkish, format.third};
  check_header(file_text(in / "copy.ply"), kept_names);
  check_shown(run_in(in, {"convert", format.name, "copy.csv"}));
  const std::string csv = file_text(in / "copy.csv");
  CHECK(csv.substr(0, csv.find('\n')).find(kLatin + "," + kTurkish + ",_[31mred") !=
        std::string::npos);

  Arguments job = {"reconstruct", format.name, "-o",          "mesh.ply",       "--radii",
                   "0.15,0.3",    "--report",  "report.json", "--chunk-points", "100"};
  if (!format.has_normals) job.insert(job.end(), {"--normals", "estimate"});
  Arguments kept = job;
  kept.insert(kept.end(), {"--work-dir", "work", "--keep-work-dir"});
  check_shown(run_in(in, kept));
  check_header(file_text(in / "mesh.ply"), kept_names);
  check_report(in, format);
  if (!format.system.empty()) CHECK(file_text(in / "mesh.prj").starts_with(format.system));
  check_shown(run_in(in, {"status", "work"}));
  check_shown(run_in(in, {"status", "work", "--json"}));
  CHECK(is_utf8(file_text(in / "work/orbweave.log")));
  CHECK_FALSE(has_control(file_text(in / "work/orbweave.log")));
  CHECK(is_utf8(file_text(in / "work/points/partition.json")));

  // What lies there is used again, and names come back as they were.
  const std::string mesh = file_text(in / "mesh.ply");
  std::filesystem::remove(in / "mesh.ply");
  const ProgramResult again = run_in(in, kept);
  check_shown(again);
  CHECK_THAT(again.err, Contains("the points are partitioned already"));
  CHECK((file_text(in / "mesh.ply") == mesh));
}

TEST_CASE("TheCoordinateSystemOfAnE57FileIsKeptByteForByteAndShownSafely") {
  const ScratchDirectory in;
  const std::string system = "PROJCS[\"Gau\xdf-Kr\xfcger\"]";
  std::vector<orbweave::test::E57Column> columns = orbweave::test::cartesian(sphere());
  columns.push_back(orbweave::test::doubles(kLatin, std::vector<double>(sphere().size(), 7.0)));
  const std::string bytes =
      orbweave::test::make_e57({.scans = {{.columns = columns}},
                                .xml = "<coordinateMetadata type=\"String\"><![CDATA[" + system +
                                       "]]></coordinateMetadata>"});
  write_text(in / "scan.e57", bytes);
  check_shown(run_in(in, {"inspect", "scan.e57", "--json"}));  // unknown fields are left out
  check_shown(run_in(in, {"convert", "scan.e57", "copy.ply"}));
  check_shown(run_in(in, {"reconstruct", "scan.e57", "-o", "mesh.ply", "--report", "report.json"}));
  check_report(in, {.name = {}, .content = {}, .system = system});
  CHECK(file_text(in / "mesh.prj").starts_with(system));
}

TEST_CASE("ANameThatAPlyHeaderCannotHoldGetsUnderlinesAndNoTwoAreAlike") {
  const ScratchDirectory in;
  write_text(in / "a.csv", "x,y,z,a b,a_b,a\tb\n0,0,0,1,2,3\n1,0,0,5,6,7\n");
  check_shown(run_in(in, {"convert", "a.csv", "a.ply"}));
  const std::string ply = header_of(file_text(in / "a.ply"));
  INFO(ply);
  CHECK(ply.find(" a_b_2\n") != std::string::npos);
  CHECK(ply.find(" a_b\n") != std::string::npos);
  CHECK(ply.find(" a_b_3\n") != std::string::npos);
  CHECK(run_in(in, {"inspect", "a.ply"}).status == 0);
  check_shown(run_in(in, {"convert", "a.csv", "b.csv"}));
  CHECK(file_text(in / "b.csv").starts_with("x,y,z,a b,a_b,a_b_2\n"));
}

TEST_CASE("FilesMayHaveAnyName", "[costly]") {
  const ScratchDirectory in;
  const std::string scan = "sc\xe4n \x1b[31m.ply";
  write_text(in / scan, binary_ply());
  write_text(in / "j\xf6"
                  "b.toml",
             "[input]\nfiles = [\"sc*.ply\"]\n[reconstruct]\nball_radii = [0.15, 0.3]\n");
  const Arguments outputs = {
      "-o",        "m\xe4sh\n.ply", "--report", "r\xe4port.json", "--picture",
      "p\xe4.png", "--work-dir",    "w\xe4rk",  "--keep-work-dir"};
  const bool from_job_file = GENERATE(true, false);
  Arguments command = {"reconstruct", scan, "--radii", "0.15,0.3"};
  if (from_job_file)
    command = {"run",
               "j\xf6"
               "b.toml",
               "--set",
               "output.mesh=m\xe4sh\n.ply",
               "--set",
               "output.report=r\xe4port.json",
               "--set",
               "run.work_dir=w\xe4rk",
               "--set",
               "run.keep_work_dir=true"};
  else
    command.insert(command.end(), outputs.begin(), outputs.end());
  const ProgramResult made = run_in(in, command);
  check_shown(made);
  CHECK_THAT(made.out, Contains("m\\xe4sh\\x0a.ply") && Contains("r\\xe4port.json"));
  check_header(file_text(in / "m\xe4sh\n.ply"), kNames);
  const std::string text = file_text(in / "r\xe4port.json");
  REQUIRE(is_utf8(text));
  const json report = json::parse(text);
  CHECK(report["input"]["files"][0].get<std::string>().ends_with("sc\\xe4n \x1b[31m.ply"));
  CHECK(is_utf8(file_text(in / "r\xe4port.html")));
  CHECK_FALSE(has_control(file_text(in / "r\xe4port.html")));
  CHECK(is_utf8(file_text(in / "w\xe4rk/orbweave.log")));
  check_shown(run_in(in, {"status", "w\xe4rk", "--json"}));
  check_shown(run_in(in, {"inspect", "m\xe4sh\n.ply", "--json", "--against", scan}));

  // A change is named by the file's name.
  std::filesystem::last_write_time(in / scan, std::filesystem::file_time_type::clock::now());
  const ProgramResult again = run_in(in, command);
  check_shown(again);
  CHECK_THAT(again.err, Contains("sc\\xe4n \\x1b[31m.ply changed from"));
}

TEST_CASE("AMessageAboutAFileOfAnyNameIsOneSafeLine") {
  const ScratchDirectory in;
  const ProgramResult result = run_in(in, {"inspect", "no\xff\n\x1b[2Jsuch.ply"});
  CHECK(result.status != 0);
  CHECK(result.status != 1);
  CHECK(is_utf8(result.err));
  CHECK_THAT(result.err, Contains("no\\xff\\x0a\\x1b[2Jsuch.ply"));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
}

TEST_CASE("AJobFileThatIsNoUtf8SaysHowToNameItsScans") {
  const ScratchDirectory in;
  write_text(in / "job.toml", "[input]\nfiles = [\"sc\xe4n.ply\"]\n");
  const ProgramResult result = run_in(in, {"run", "job.toml"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains("job.toml: line 2: not valid TOML: a byte that is no UTF-8 text; "
                                  "found byte 228. Name files whose names are no UTF-8 by a "
                                  "pattern, or on the command line"));
}

TEST_CASE("AnAttributeWithTheNameOfANormalLeavesAMeshThatReads") {
  const ScratchDirectory in;
  std::string cloud = "x,y,z,nx\n";
  for (const Vec3& p : sphere()) {
    for (int axis = 0; axis < 3; ++axis) cloud += std::to_string(p[axis]) + ",";
    cloud += "7\n";
  }
  write_text(in / "scan.csv", cloud);
  REQUIRE(run_in(in, {"reconstruct", "scan.csv", "-o", "mesh.ply"}).status == 0);
  const ProgramResult facts = run_in(in, {"inspect", "mesh.ply"});
  CHECK(facts.status == 0);
  CHECK_THAT(file_text(in / "mesh.ply").substr(0, 1000), Contains(" nx_2\n"));
}
