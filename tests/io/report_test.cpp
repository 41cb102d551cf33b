#include "io/report/report.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "io/error.h"
#include "io/job/job_file.h"
#include "io/report/hole_summary.h"
#include "io/report/picture.h"
#include "io/report/reasons.h"
#include "io/report/report_fields.h"
#include "io/report/report_html.h"
#include "io/report/verdict.h"
#include "io/text/quantity.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;
using Catch::Contains;

HoleFacts filled_hole() {
  HoleFacts hole;
  hole.id = 1;
  hole.first_vertex = (std::uint64_t{1} << 53) + 1;
  hole.edges = 24;
  hole.perimeter = 2.0 / 3.0;
  hole.diameter = 0.2;
  hole.center = {1.0, -2.0, 448262.12345678901};
  hole.chunks = {3, 17};
  hole.filled = true;
  hole.method = "implicit";
  hole.reason = "the rim <overlaps> itself in its plane";
  hole.sites = 96;
  hole.points_added = 31;
  hole.confidence = 0.875;
  hole.triangles_added = 84;
  hole.residual = 1e-9;
  hole.condition = 1e6;
  hole.rim_dihedral_deg = 12.504;
  hole.seconds = 0.25;
  return hole;
}

HoleFacts open_loop() {
  HoleFacts hole;
  hole.id = 2;
  hole.edges = 400;
  hole.diameter = 7.0;
  hole.reason = "the outer border of an open sheet (fill.keep_outer_border)";
  hole.open = OpenReason::kOuterBorder;
  return hole;
}

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
  report.holes = {filled_hole(), open_loop()};
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

TEST_CASE("ThePageHasWhatWasPredictedBesideWhatWasMeasured") {
  RunReport report = example();
  report.predicted = {.peak_memory_bytes = 3 << 20, .disk_bytes = 5 << 20, .seconds = 125.0};
  report.measured = {.peak_memory_bytes = 2 << 20, .disk_bytes = 7 << 20, .seconds = 61.0};
  const std::string page = report_html(report);
  for (const std::uint64_t bytes : {3 << 20, 5 << 20, 7 << 20})
    CHECK_THAT(page, Contains(format_bytes(bytes)));
  for (const double seconds : {125.0, 61.0}) CHECK_THAT(page, Contains(format_duration(seconds)));
}

TEST_CASE("ThePageOpensWithWhatTheResultIsWorth") {
  RunReport report = example();
  report.holes = {filled_hole()};
  report.mesh.triangles = 900'000;
  report.mesh.patch_area = report.mesh.area / 8.0;
  report.mesh.crossing_pairs = 0;
  const std::string clean = report_html(report);
  CHECK_THAT(clean,
             Contains("</h1>\n<p class=\"verdict clean\">The surface is watertight. No patch "
                      "of 1 filled hole is doubtful; they are 12.5 % of the area. No "
                      "triangles cross. The run had no warning.</p>"));
  report.mesh.watertight = false;
  report.mesh.boundary_edges = 30;
  report.mesh.boundary_loops = 2;
  report.holes.front().confidence = 0.01;
  report.holes.front().area = report.mesh.area / 100.0;
  report.mesh.crossing_pairs = 4;
  report.warnings = {"the mesh is riddled with holes"};
  CHECK_THAT(report_html(report),
             Contains("<p class=\"verdict\">The surface is open: 2 boundary loops of 30 edges. 1 "
                      "patch of 1 is doubtful, 1 % of the area: look first near (1, -2, ") &&
                 Contains("4 pairs of triangles cross. The run had 1 warning, below"));
  report.holes.clear();
  report.mesh.crossing_pairs.reset();
  report.mesh.patch_crossing_pairs.reset();
  CHECK_THAT(report_html(report),
             Contains("No hole was filled. Crossings were not counted. The run had 1 warning"));
  CHECK(Json::parse(report_json(report))["verdict"] == verdict_of(report).text);
}

TEST_CASE("TheReportHasItsStableKeys") {
  const Json json = Json::parse(report_json(example()));
  CHECK(keys_of(json) == Keys{"version",
                              "command",
                              "verdict",
                              "options",
                              "input",
                              "coordinate_system",
                              "cleaning",
                              "normals",
                              "partition",
                              "radii",
                              "points_unused",
                              "pieces_removed",
                              "triangles_removed",
                              "conflicts_lost",
                              "voronoi",
                              "origin",
                              "mesh",
                              "holes",
                              "stages",
                              "traffic",
                              "peak_memory_bytes",
                              "predicted",
                              "measured",
                              "ranks",
                              "machine",
                              "notes",
                              "warnings"});
  CHECK(keys_of(json["cleaning"]) ==
        Keys{"thickness", "spacing", "outlier_sigma", "merge_tolerance", "smooth_radius",
             "smooth_passes", "thin_to_spacing", "reason", "cluster_points", "min_surfaceness",
             "least_radius", "most_radius", "untouched_share", "points_moved", "mean_move"});
  CHECK(keys_of(json["normals"]) == Keys{"source", "orientation", "neighbors", "max_radius",
                                         "patches", "components", "contested_patches",
                                         "contested_places", "votes_satisfied", "ground_patches",
                                         "ground_patches_down", "interior_components",
                                         "contested_area", "doubtful_area", "doubtful_parts"});
  CHECK(keys_of(json["input"]) == Keys{"files", "points_read", "points_dropped", "bounds", "extent",
                                       "extent_meters", "trusted"});
  CHECK(keys_of(json["partition"]) == Keys{"chunks", "halo_width", "largest_chunk_points"});
  CHECK(keys_of(json["radii"]) == Keys{"values", "reason"});
}

TEST_CASE("TheMeshTheHolesAndTheStagesOfTheReportHaveTheirStableKeys") {
  const Json json = Json::parse(report_json(example()));
  CHECK(keys_of(json["mesh"]) == Keys{"vertices",
                                      "triangles",
                                      "components",
                                      "boundary_edges",
                                      "boundary_loops",
                                      "nonmanifold_edges",
                                      "nonmanifold_vertices",
                                      "pinches",
                                      "mended_triangles",
                                      "inconsistent_edges",
                                      "degenerate_triangles",
                                      "duplicate_triangles",
                                      "unreferenced_vertices",
                                      "crossing_pairs",
                                      "patch_crossing_pairs",
                                      "euler_characteristic",
                                      "area",
                                      "patch_area",
                                      "watertight",
                                      "checksum",
                                      "bounds"});
  CHECK(keys_of(json["stages"][0]) == Keys{"name", "seconds", "cpu_seconds", "points",
                                           "points_per_second", "bytes_read", "bytes_written",
                                           "chunks", "chunks_reused", "peak_memory_bytes",
                                           "chunk_seconds", "chunk_cpu_seconds", "counter_calls"});
  CHECK(keys_of(json["traffic"]) ==
        Keys{"bytes_read", "bytes_written", "bytes_per_point", "counter_calls"});
  CHECK(keys_of(json["machine"]) == Keys{"cores", "cpu_model", "memory_bytes"});
  REQUIRE(json["holes"].is_array());
  for (const Json& hole : json["holes"])
    CHECK(keys_of(hole) ==
          Keys{"id",         "first_vertex", "edges",        "perimeter",        "diameter",
               "center",     "chunks",       "filled",       "method",           "reason",
               "joined_to",  "sites",        "points_added", "triangles_added",  "area",
               "open_edges", "residual",     "condition",    "rim_dihedral_deg", "rim_mean_deg",
               "confidence", "seconds"});
}

/// Names of all fields below an object, of what lists hold with "[]".
void add_fields(const Json& object, const std::string& prefix, std::set<std::string>& fields) {
  static const std::set<std::string> kFree = {"options", "input.points_dropped",
                                              "input.triangles_dropped"};
  for (const auto& [key, value] : object.items()) {
    const std::string name = prefix + key;
    fields.insert(name);
    if (value.is_object() && !kFree.contains(name)) add_fields(value, name + ".", fields);
    if (value.is_array())
      for (const Json& item : value)
        if (item.is_object()) add_fields(item, name + "[].", fields);
  }
}

TEST_CASE("TheFieldsOfNormalsNameTheWordsThatTheReportHas") {
  const auto names = [](std::string_view field, std::string_view word) {
    return meaning_of_field(field).find(word) != std::string_view::npos;
  };
  for (const auto source : {NormalSource::kFile, NormalSource::kEstimate, NormalSource::kPoles})
    CHECK(names("normals.source", text_of(source)));
  for (const auto side :
       {Orientation::kScanner, Orientation::kViewpoint, Orientation::kUp, Orientation::kPropagate,
        Orientation::kGround, Orientation::kInward, Orientation::kNone})
    CHECK(names("normals.orientation", text_of(side)));
}

TEST_CASE("EveryFieldOfAReportIsDescribedAndNoOtherIs") {
  RunReport report = example();
  report.trusted = {{"a.ply", 5, "now", 5}};
  report.normals.contested_places = {{{1, 2, 3}, 4}};
  report.normals.doubtful = {{{1, 2, 3}, 0.5, "thin"}};
  report.mesh.bounds = report.bounds;
  report.voronoi = VoronoiFacts{};
  std::set<std::string> fields;
  add_fields(Json::parse(report_json(report)), "", fields);
  std::set<std::string> described;
  for (const ReportField& field : run_report_fields()) {
    CHECK(described.insert(std::string(field.name)).second);
    CHECK(field.meaning.size() > 2);
  }
  CHECK(fields == described);

  FillReport fill;
  fill.holes = report.holes;
  fill.before.bounds = fill.after.bounds = report.bounds;
  std::set<std::string> of_fill;
  add_fields(Json::parse(fill_report_json(fill)), "", of_fill);
  for (const ReportField& field : fill_report_fields())
    CHECK(of_fill.contains(std::string(field.name)));
  for (std::string field : of_fill) {
    INFO(field);
    if (field.starts_with("mesh_before.")) field = "mesh." + field.substr(12);
    CHECK_FALSE(meaning_of_field(field).empty());
  }
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
  CHECK(options["fill"]["enabled"] == true);
  CHECK(options["fill"]["kernel"] == "biharmonic");
  CHECK(options["fill"]["max_diameter"] == "auto");
  CHECK(options["fill"]["max_perimeter"].is_null());  // no limit
  CHECK(options["output"]["patch_color"] == "#80a8e2");
}

TEST_CASE("ExtentIsInMetersOnlyWhereTheUnitIsKnown") {
  const auto input = [](const RunReport& report) {
    return Json::parse(report_json(report))["input"];
  };
  RunReport report = example();
  const Vec3 extent = report.bounds.extent();
  CHECK(input(report)["extent"] == Json{extent.x, extent.y, extent.z});
  CHECK(input(report)["extent_meters"].is_null());
  report.meters_per_unit = Vec3{0.3048, 0.3048, 1.0};  // of the coordinate system
  CHECK(input(report)["extent_meters"] == Json{extent.x * 0.3048, extent.y * 0.3048, extent.z});
  CHECK(input(report)["extent"] == Json{extent.x, extent.y, extent.z});
  report.options.input.units_per_meter = 1000.0;  // the user's word wins
  CHECK(input(report)["extent_meters"][1] == 0.004);
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

TEST_CASE("EveryHoleIsInTheReportWithItsExactNumbers") {
  const Json holes = Json::parse(report_json(example()))["holes"];
  REQUIRE(holes.size() == 2);
  const HoleFacts hole = filled_hole();
  CHECK(holes[0]["first_vertex"] == hole.first_vertex);
  CHECK(holes[0]["perimeter"] == hole.perimeter);
  CHECK(holes[0]["center"] == Json{hole.center.x, hole.center.y, hole.center.z});
  CHECK(holes[0]["chunks"] == Json{3, 17});
  CHECK(holes[0]["filled"] == true);
  CHECK(holes[0]["method"] == "implicit");
  CHECK(holes[0]["reason"] == hole.reason);
  CHECK(holes[0]["residual"] == 1e-9);
  CHECK(holes[1]["filled"] == false);
  CHECK(holes[1]["method"].is_null());
  CHECK(Json::parse(holes_json(example().holes)) == holes);
  CHECK(Json::parse(holes_json({})) == Json::array());
}

TEST_CASE("TheListOfHolesCannotBeForgedByAText") {
  RunReport report = example();
  report.files = {"\n  \"holes\": null"};
  report.notes = report.files;
  const Json json = Json::parse(report_json(report));
  CHECK(json["holes"].size() == 2);
  CHECK(json["notes"][0] == report.files[0]);
}

TEST_CASE("ThePageSumsTheHolesUpAndShowsThem") {
  const std::string page = report_html(example());
  CHECK_THAT(page, Contains("2 loops, 1 filled (1 implicit; 31 points and 84 triangles added), "
                            "1 left open (1 outer border of an open sheet "
                            "(fill.keep_outer_border))."));
  CHECK_THAT(page, Contains("the rim &lt;overlaps&gt; itself") && Contains(">12.5<"));
  RunReport closed = example();
  closed.holes.clear();
  CHECK_THAT(report_html(closed), !Contains("Holes"));
}

TEST_CASE("ThePageOfTenThousandHolesIsSmallAndTheReportHasAll", "[costly]") {
  RunReport report = example();
  report.holes.clear();
  for (std::int32_t i = 1; i <= 10'000; ++i) {
    HoleFacts hole = filled_hole();
    hole.id = i;
    hole.edges = 3;
    hole.diameter = 1.0 + 1e-4 * ((i * 7919) % 10'000);  // each diameter once
    if (i % 10 == 0) {
      hole.filled = false;
      hole.reason = std::to_string(i) + " edges are more than fill.max_edges = 2";
      hole.open = OpenReason::kMaxEdges;
    }
    report.holes.push_back(hole);
  }
  const std::string page = report_html(report);
  CHECK(page.size() < 512 * 1024);
  CHECK_THAT(page, Contains("10,000 loops, 9,000 filled (9,000 implicit;") &&
                       Contains("1,000 left open (1,000 more edges than fill.max_edges)") &&
                       Contains("The 1000 widest"));
  const auto widest = std::ranges::max_element(report.holes, {}, &HoleFacts::diameter);
  const auto narrowest = std::ranges::min_element(report.holes, {}, &HoleFacts::diameter);
  CHECK_THAT(page, Contains("<td>" + std::to_string(widest->id) + "</td>") &&
                       !Contains("<td>" + std::to_string(narrowest->id) + "</td>"));
  const std::string text = report_json(report);
  CHECK(Json::parse(text)["holes"].size() == 10'000);
  CHECK(text.size() < 10'000 * 512);
}

TEST_CASE("ReasonsThatDifferInNumbersOnlyAreOne") {
  std::vector<HoleFacts> holes(7, open_loop());
  holes[1].reason = "needs 3,000,000 points at a spacing of 1.5e-07";
  holes[2].reason = "needs 12 points at a spacing of 0.25";
  holes[3].reason = "needs 7 points at a spacing of 3";
  for (int i = 1; i <= 3; ++i) holes[static_cast<std::size_t>(i)].open = OpenReason::kTooManyPoints;
  holes[4].reason = "a diameter of 3.5 is more than fill.max_diameter = 2";
  holes[4].open = OpenReason::kMaxDiameter;
  for (const std::size_t i : {5U, 6U}) {
    holes[i].reason = "every patch crosses the patch of hole " + std::to_string(i);
    holes[i].open = OpenReason::kOther;
  }
  const HoleSummary summary = hole_summary(holes);
  CHECK(summary.open == 7);
  CHECK(summary.reasons == Counted{{"needs # points at a spacing of #", 3},
                                   {"every patch crosses the patch of another hole", 2},
                                   {"outer border of an open sheet (fill.keep_outer_border)", 1},
                                   {"wider than fill.max_diameter", 1}});
  CHECK(counted_list(summary.reasons, 1) == "3 needs # points at a spacing of #, 4 others");
  CHECK(counted_list({{"direct", 5}, {"plane", 1}}, 1) == "5 direct, 1 other");
}

TEST_CASE("DoubtfulPatchesAreCountedWithTheirAreaAndTheLargestIsNamed") {
  std::vector<HoleFacts> holes(5);
  for (HoleFacts& hole : holes) hole.filled = true;
  holes[0].confidence = 0.9;
  holes[0].area = 8.0;
  holes[1].confidence = 0.2;
  holes[1].area = 1.0;
  holes[2].confidence = 0.4;
  holes[2].area = 3.0;
  holes[2].center = {1.0, 2.0, 3.0};
  holes[3].confidence = 0.4;  // an island in the hole before: the same patch
  holes[3].joined_to = 3;
  holes[4] = open_loop();
  const HoleSummary summary = hole_summary(holes);
  CHECK(summary.doubtful == 2);
  CHECK(summary.doubtful_area == 4.0);
  CHECK(summary.most_doubtful == Vec3{1.0, 2.0, 3.0});
}

TEST_CASE("WidestHolesComeInOrderAndTiesById") {
  std::vector<HoleFacts> holes(4);
  for (std::size_t i = 0; i < 4; ++i) holes[i].id = static_cast<std::int32_t>(4 - i);
  holes[3].diameter = 2.0;
  std::vector<std::int32_t> ids;
  for (const HoleFacts* hole : widest_holes(holes, 3)) ids.push_back(hole->id);
  CHECK(ids == std::vector<std::int32_t>{1, 2, 3});
  CHECK(widest_holes(holes, 9).size() == 4);
}

TEST_CASE("TheReportOfAFillHasTheMeshBeforeAndAfter") {
  FillReport report;
  report.version = "0.1.0";
  report.command = {"orbweave", "fill"};
  report.file = "in.ply";
  report.triangles_dropped = {{"repeated", 2}};
  report.before.boundary_loops = 2;
  report.after.boundary_loops = 1;
  report.options.fill.max_edges = 7;
  report.holes = {filled_hole(), open_loop()};
  report.pieces_removed = 3;
  const test::ScratchDirectory scratch;
  write_fill_report(scratch / "fill.json", report);
  const Json json = Json::parse(text_of(scratch / "fill.json"));
  CHECK(keys_of(json) == Keys{"version", "command", "options", "input", "mesh_before", "origin",
                              "mesh", "pieces_removed", "triangles_removed", "holes", "seconds",
                              "peak_memory_bytes", "machine"});
  CHECK(keys_of(json["options"]) == Keys{"fill", "output", "run"});
  CHECK(json["options"]["fill"]["max_edges"] == 7);
  CHECK(json["input"]["triangles_dropped"]["repeated"] == 2);
  CHECK(json["mesh_before"]["boundary_loops"] == 2);
  CHECK(json["mesh"]["boundary_loops"] == 1);
  CHECK(json["holes"] == Json::parse(holes_json(report.holes)));
  CHECK(keys_of(json["mesh"]) == keys_of(json["mesh_before"]));
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

TEST_CASE("ThePageKeepsAViewerInItsFrame") {
  const std::string page = report_html(example(), "<p id=\"a\">&lt;</p><script>f('\"')</script>");
  CHECK_THAT(page,
             Contains("srcdoc=\"<p id=&quot;a&quot;>&amp;lt;</p><script>f('&quot;')</script>\""));
  CHECK_THAT(report_html(example()), !Contains("<iframe"));
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
    CHECK(error.kind() == ErrorKind::kResource);
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
