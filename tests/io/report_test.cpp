#include "io/report.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/error.h"
#include "io/job_file.h"
#include "io/picture.h"
#include "io/report_html.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;
using Catch::Contains;

RunReport example() {
  RunReport report;
  report.version = "0.1.0";
  report.command = {"orbweave", "run", "a <b> & \"c\".toml"};
  report.options.input.files = {"scans/*.ply"};
  report.options.output.mesh = "mesh.ply";
  report.options.reconstruct.ball_radii = {0.1, 1.0 / 3.0};
  report.files = {"scans/1.ply", "scans/2.ply"};
  report.points_read = (std::uint64_t{1} << 53) + 1;
  report.points_dropped = {{"not finite", 3}, {"duplicate", 7}};
  report.points_unused = 5;
  report.bounds = {{0.1, -2.0, 448262.12345678901}, {1.0, 2.0, 5e5}};
  report.chunks = 64;
  report.halo_width = 0.7;
  report.largest_chunk_points = 12345;
  report.radii = {0.1, 1.0 / 3.0};
  report.radii_reason = "given";
  report.mesh.vertices = 437645;
  report.mesh.euler_characteristic = -46;
  report.mesh.area = 2.0 / 3.0;
  report.mesh.watertight = true;
  report.mesh.checksum = "0123456789abcdef";
  report.stages = {{"bin", 2.0, 3.5, 1'000'000, 100, 200, 64, 3}};
  report.peak_memory_bytes = 1 << 30;
  report.notes = {"<script>alert('x')</script>"};
  return report;
}

std::vector<std::string> keys_of(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  return keys;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

using Keys = std::vector<std::string>;

TEST_CASE("TheReportHasItsStableKeys") {
  const Json json = Json::parse(report_json(example()));
  CHECK(keys_of(json) == Keys{"version", "command", "options", "input", "partition", "radii",
                              "points_unused", "conflicts_lost", "mesh", "holes", "stages",
                              "peak_memory_bytes", "machine", "notes"});
  CHECK(keys_of(json["input"]) == Keys{"files", "points_read", "points_dropped", "bounds"});
  CHECK(keys_of(json["partition"]) == Keys{"chunks", "halo_width", "largest_chunk_points"});
  CHECK(keys_of(json["radii"]) == Keys{"values", "reason"});
  CHECK(keys_of(json["mesh"]) ==
        Keys{"vertices", "triangles", "components", "boundary_edges", "boundary_loops",
             "nonmanifold_edges", "nonmanifold_vertices", "inconsistent_edges",
             "degenerate_triangles", "duplicate_triangles", "unreferenced_vertices",
             "euler_characteristic", "area", "watertight", "checksum", "bounds"});
  CHECK(keys_of(json["stages"][0]) == Keys{"name", "seconds", "cpu_seconds", "points",
                                           "points_per_second", "bytes_read", "bytes_written",
                                           "chunks", "chunks_reused"});
  CHECK(keys_of(json["machine"]) == Keys{"cores", "cpu_model", "memory_bytes"});
  CHECK(json["holes"].is_array());
}

TEST_CASE("TheReportsOptionsAreTheJobFilesKeysBySection") {
  const Json options = Json::parse(report_json(example()))["options"];
  for (const JobKey& key : job_keys()) {
    CAPTURE(key.name());
    REQUIRE(options.contains(key.section));
    CHECK(options[key.section].contains(key.key));
  }
  CHECK(options["input"]["files"] == Json{"scans/*.ply"});
  CHECK(options["partition"]["memory"] == std::uint64_t{4} << 30);
  CHECK(options["partition"]["chunk_points"] == "auto");
  CHECK(options["reconstruct"]["ball_radii"][1] == 1.0 / 3.0);
  CHECK(options["fill"]["enabled"] == false);
}

TEST_CASE("NumbersOfTheReportAreExact") {
  const RunReport report = example();
  const Json json = Json::parse(report_json(report));
  CHECK(json["input"]["points_read"] == report.points_read);
  CHECK(json["input"]["bounds"]["min"][2] == report.bounds.min.z);
  CHECK(json["input"]["points_dropped"] == Json{{"duplicate", 7}, {"not finite", 3}});
  CHECK(json["mesh"]["area"] == report.mesh.area);
  CHECK(json["mesh"]["euler_characteristic"] == -46);
  CHECK(json["mesh"]["bounds"].is_null());
  CHECK(json["stages"][0]["points_per_second"] == 500000.0);
}

TEST_CASE("TheReportIsJsonWhateverItIsGiven") {
  RunReport report = example();
  report.files = {"bad \xff utf-8"};
  report.halo_width = std::numeric_limits<double>::infinity();
  report.mesh.area = std::numeric_limits<double>::quiet_NaN();
  const Json json = Json::parse(report_json(report));
  CHECK(json["partition"]["halo_width"].is_null());
  CHECK(json["input"]["files"].size() == 1);
}

TEST_CASE("TheFactsOfAMeshAreThoseOfTheReportWithItsKind") {
  const Json facts = Json::parse(mesh_facts_json(example().mesh));
  Json expected = Json::parse(report_json(example()))["mesh"];
  CHECK(facts["kind"] == "mesh");
  for (const auto& item : expected.items()) CHECK(facts[item.key()] == item.value());
  CHECK(facts.size() == expected.size() + 1);
}

TEST_CASE("TheReportIsWrittenWithAPageBesideIt") {
  const test::ScratchDirectory scratch;
  write_report(scratch / "mesh.report.json", example());
  CHECK(text_of(scratch / "mesh.report.json") == report_json(example()));
  const std::string page = text_of(scratch / "mesh.report.html");
  CHECK_THAT(page, Catch::StartsWith("<!DOCTYPE html>") && Catch::EndsWith("</html>\n"));
  CHECK_THAT(page, Contains("<td>437,645</td>") && Contains("0123456789abcdef") &&
                       Contains("partition.memory") && Contains("&quot;4GiB&quot;") &&
                       Contains("500k"));
  // Self-contained and safe.
  CHECK_THAT(page, !Contains("<script") && !Contains("http") && !Contains("<b>"));
  CHECK_THAT(page, Contains("a &lt;b&gt; &amp; &quot;c&quot;.toml"));
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(scratch.path()))
    ++files;
  CHECK(files == 2);
}

TEST_CASE("ThePageCarriesThePictureWhereThereIsOne") {
  const test::ScratchDirectory scratch;
  RunReport report = example();
  report.options.output.picture = (scratch / "mesh.png").string();
  CHECK_THAT(report_html(report), !Contains("<img"));
  MeshPicture(Box{}, {.width = 2, .height = 2}).write_png(scratch / "mesh.png");
  // The signature of every PNG file in base 64.
  CHECK_THAT(report_html(report), Contains("src=\"data:image/png;base64,iVBORw0KGgo"));
}

TEST_CASE("Base64OfThePictureIsPaddedAsItShould") {
  const test::ScratchDirectory scratch;
  RunReport report = example();
  report.options.output.picture = (scratch / "p").string();
  const std::pair<const char*, const char*> cases[] = {{"f", "base64,Zg==\""},
                                                       {"fo", "base64,Zm8=\""},
                                                       {"foo", "base64,Zm9v\""},
                                                       {"foob", "base64,Zm9vYg==\""}};
  for (const auto& [bytes, expected] : cases) {
    std::ofstream(scratch / "p") << bytes;
    CHECK_THAT(report_html(report), Contains(expected));
  }
}

TEST_CASE("AReportThatCannotBeWrittenIsAResourceError") {
  const test::ScratchDirectory scratch;
  try {
    write_report(scratch / "no/such/folder.json", example());
    FAIL("written");
  } catch (const Error& error) {
    CHECK(error.status() == ExitStatus::kResource);
  }
}

TEST_CASE("MemoryIsMeasuredInBytes") {
  const std::uint64_t before = current_memory_bytes();
  constexpr std::size_t kBytes = std::size_t{64} << 20;
  {
    const std::vector<char> block(kBytes, 1);
    CHECK(current_memory_bytes() + (8 << 20) > before + kBytes);
    CHECK(block[kBytes / 2] == 1);
  }
  CHECK(peak_memory_bytes() + (8 << 20) > before + kBytes);
  CHECK(peak_memory_bytes() < std::uint64_t{64} << 30);
}

}  // namespace
}  // namespace orbweave
