// Selection on the command line: what is kept, what is said of the rest, and what inspect tells.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using nlohmann::json;
using orbweave::test::data_path;
using orbweave::test::file_text;
using orbweave::test::run_in;
using orbweave::test::run_program;
using orbweave::test::ScratchDirectory;
using orbweave::test::skipped_without;
using orbweave::test::source_path;
using orbweave::test::write_text;

namespace {

/// A plane of 40 x 40 points with the classes 2, and 7 or 18 for a few; as text in a given order.
std::string classified_plane(bool reversed) {
  std::vector<std::string> lines;
  for (int i = 0; i < 1600; ++i) {
    const int point_class = i % 100 == 3 ? 7 : i % 400 == 5 ? 18 : 2;
    const double height = point_class == 2 ? 0.01 * (i % 7) : 90.0;
    std::ostringstream line;
    line << i % 40 + 0.1 * (i % 3) << ' ' << i / 40 << ' ' << height << " 0 0 1 " << point_class;
    lines.push_back(line.str());
  }
  if (reversed) std::reverse(lines.begin(), lines.end());
  std::string text = "x y z nx ny nz classification\n";
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

json json_of(const orbweave::test::ProgramResult& result) {
  CHECK(result.status == 0);
  return json::parse(result.out);
}

std::vector<std::string> names_of(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

}  // namespace

TEST_CASE("NoiseClassesAreLeftOutByDefaultAndSaidSo") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  const auto result = run_in(
      in, {"reconstruct", "a.xyz", "-o", "m.ply", "--report", "r.json", "--progress", "plain"});
  REQUIRE(result.status == 0);
  CHECK_THAT(result.err, Contains("points of dropped classes are left out (16 of class 7 (low "
                                  "point), 4 of class 18 (high noise)); --drop-classes none "
                                  "keeps them"));
  const json input = json::parse(file_text(in / "r.json"))["input"];
  CHECK(input["points_read"] == 1600);
  CHECK(input["points_dropped"]["class 7 (low point) left out"] == 16);
  CHECK(input["points_dropped"]["class 18 (high noise) left out"] == 4);
  const json all = json_of(run_in(in, {"plan", "a.xyz", "--drop-classes", "none", "--json",
                                       "--keep-strays", "--progress", "none"}));
  CHECK(all["input"]["points"] == 1600);
  const json plan = json_of(run_in(in, {"plan", "a.xyz", "--json", "--progress", "none"}));
  CHECK(plan["input"]["points"] == 1580);
  CHECK(plan["input"]["points_read"] == 1600);
  CHECK(plan["input"]["points_dropped"]["class 7 (low point) left out"] == 16);
}

TEST_CASE("ASelectionGivesTheSameMeshForAnyOrderChunksAndThreads", "[costly]") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  write_text(in / "b.xyz", classified_plane(true));
  write_text(in / "area.geojson",
             R"({"type": "Polygon", "coordinates": [[[0, 0], [39, 0], [39, 39], [12, 30]],
                 [[10, 5], [14, 5], [14, 9], [10, 9]]]})");
  const auto mesh = [&](const std::string& scan, const std::string& out,
                        const std::vector<std::string>& more) {
    std::vector<std::string> words = {"reconstruct", scan,        "-o",           out,
                                      "--crop",      "1,1,38,38", "--crop-area",  "area.geojson",
                                      "--every",     "2",         "--ball-radii", "3"};
    words.insert(words.end(), more.begin(), more.end());
    const auto result = run_in(in, words);
    REQUIRE(result.status == 0);
    return file_text(in / out);
  };
  const std::string usual = mesh("a.xyz", "m1.ply", {});
  CHECK(usual.size() > 2000);
  CHECK(mesh("b.xyz", "m2.ply", {"--chunk-points", "60", "--threads", "3"}) == usual);
  CHECK(mesh("b.xyz", "m3.ply", {"--threads", "1"}) == usual);
}

TEST_CASE("ACropWithoutPointsSaysWhereThePointsAre") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  const auto box = run_in(in, {"reconstruct", "a.xyz", "-o", "m.ply", "--crop", "100,100,200,200"});
  CHECK(box.status == 3);
  CHECK_THAT(box.err, Contains("no usable point") && Contains("1600 dropped: outside the crop") &&
                          Contains("the points lie in x 0 to 39.2, y 0 to 39, z 0 to 90") &&
                          Contains("the crop is x 100 to 200, y 100 to 200") &&
                          Contains("1,580 of class 2 (ground)") &&
                          Contains("16 of class 7 (low point)"));
  const auto classes = run_in(in, {"reconstruct", "a.xyz", "-o", "m.ply", "--las-classes", "6"});
  CHECK(classes.status == 3);
  CHECK_THAT(classes.err,
             Contains("1580 dropped: class 2 (ground) not selected") && Contains("--las-classes"));
  // GeoJSON in degrees beside coordinates that are none.
  write_text(in / "utm.xyz", "500000 5000000 1\n500001 5000000 1\n500000 5000001 1\n");
  write_text(in / "deg.geojson",
             R"({"type": "Polygon", "coordinates": [[[9, 45], [9.1, 45], [9, 45.1]]]})");
  const auto degrees =
      run_in(in, {"reconstruct", "utm.xyz", "-o", "m.ply", "--crop-area", "deg.geojson"});
  CHECK(degrees.status == 3);
  CHECK_THAT(degrees.err, Contains("The area is in degrees") && Contains("ogr2ogr -t_srs"));
}

TEST_CASE("WrongSelectionsAreRefusedBeforeTheWork") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  write_text(in / "bad.wkt", "POLYGON ((0 0, 1 0))");
  const auto refused = [&](const std::string& option, const std::string& value) {
    const auto result = run_in(in, {"reconstruct", "a.xyz", "-o", "m.ply", option, value});
    CHECK_FALSE(std::filesystem::exists(in / "m.work"));
    CHECK_FALSE(std::filesystem::exists(in / "m.ply"));
    return std::pair(result.status, result.err);
  };
  CHECK(refused("--crop", "1,2,3").first == 2);
  CHECK(refused("--crop", "5,0,4,1").first == 2);
  CHECK_THAT(refused("--crop", "5,0,4,1").second, Contains("above the largest"));
  CHECK(refused("--every", "0").first == 2);
  CHECK(refused("--drop-classes", "256").first == 2);
  const auto text = refused("--crop-area", "POLYGON ((0 0, 1 0, x))");
  CHECK(text.first == 2);
  CHECK_THAT(text.second, Contains("column 21") && Contains("no corner"));
  const auto file = refused("--crop-area", "bad.wkt");
  CHECK(file.first == 3);
  CHECK_THAT(file.second, Contains("bad.wkt: line 1") && Contains("too few corners"));
  const auto absent = refused("--crop-area", "none.wkt");
  CHECK(absent.first == 3);
  CHECK_THAT(absent.second, Contains("none.wkt"));
}

TEST_CASE("AJobWhoseAreaChangesIsNotResumedWithTheOldOne") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  write_text(in / "area.wkt", "POLYGON ((-1 -1, 50 -1, 50 50, -1 50))");
  const std::vector<std::string> job = {
      "reconstruct", "a.xyz", "-o", "m.ply", "--crop-area", "area.wkt", "--keep-work-dir"};
  REQUIRE(run_in(in, job).status == 0);
  const std::string whole = file_text(in / "m.ply");
  write_text(in / "area.wkt", "POLYGON ((-1 -1, 20 -1, 20 50, -1 50))");
  REQUIRE(run_in(in, job).status == 0);
  CHECK(file_text(in / "m.ply").size() < whole.size() * 3 / 4);
}

TEST_CASE("ConvertSelectsPointsAndDropsNoClassUnasked") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  const auto all = run_in(in, {"convert", "a.xyz", "all.ply"});
  CHECK_THAT(all.out, Contains("1,600 points") && !Contains("dropped"));
  const auto some =
      run_in(in, {"convert", "a.xyz", "some.ply", "--drop-classes", "7", "--crop", "0,0,9,39"});
  CHECK(some.status == 0);
  CHECK_THAT(some.out, Contains("dropped: outside the crop") &&
                           Contains("dropped: class 7 (low point) left out"));
  const json facts = json_of(run_in(in, {"inspect", "some.ply", "--json"}));
  const json same = json_of(
      run_in(in, {"inspect", "a.xyz", "--json", "--drop-classes", "7", "--crop", "0,0,9,39"}));
  CHECK(facts["points"] == same["points"]);
  CHECK(facts["bounds"] == same["bounds"]);
  CHECK(facts["classes"] == same["classes"]);
  REQUIRE(run_in(in, {"reconstruct", "a.xyz", "-o", "m.ply"}).status == 0);
  CHECK(run_in(in, {"convert", "m.ply", "n.ply", "--every", "2"}).status == 2);
}

TEST_CASE("TheSummaryNamesWhatIsThereAndWarnsOfWhatIsOlder") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  write_text(in / "m.prj", "somebody's\n");
  const std::vector<std::string> job = {"reconstruct", "a.xyz",  "-o",        "m.ply",
                                        "--report",    "r.json", "--picture", "p.png"};
  const auto result = run_in(in, job);
  REQUIRE(result.status == 0);
  for (const char* file : {"m.ply", "r.json", "r.html", "p.png"}) {
    CHECK_THAT(result.out, Contains(file));
    CHECK(std::filesystem::exists(in / file));
  }
  CHECK_THAT(result.out, Contains("m.prj is not of this run"));
  CHECK_THAT(result.err, Contains("m.prj was there before and is not of this run"));
  CHECK(file_text(in / "m.prj") == "somebody's\n");
}

TEST_CASE("AnOlderMeshThatTheRecordKnowsIsRemoved") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  const std::vector<std::string> job = {"reconstruct", "a.xyz", "-o", "m.ply", "--keep-work-dir"};
  REQUIRE(run_in(in, job).status == 0);
  std::vector<std::string> tiles = job;
  tiles.emplace_back("--tiles");
  const auto result = run_in(in, tiles);
  REQUIRE(result.status == 0);
  CHECK(std::filesystem::exists(in / "m.tiles" / "tiles.json"));
  CHECK_FALSE(std::filesystem::exists(in / "m.ply"));
  CHECK_THAT(result.err, Contains("m.ply of an earlier run is removed"));
}

TEST_CASE("OlderTilesAreRemovedWhereTheyAreAsTheRecordKnowsThem") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", classified_plane(false));
  const std::vector<std::string> job = {"reconstruct", "a.xyz", "-o", "m.ply", "--keep-work-dir"};
  std::vector<std::string> tiles = job;
  tiles.emplace_back("--tiles");
  REQUIRE(run_in(in, tiles).status == 0);
  // A second time: the directory that replaces the first is known as well.
  tiles.insert(tiles.end(), {"--chunk-points", "100"});
  if (GENERATE(false, true)) REQUIRE(run_in(in, tiles).status == 0);
  const std::string change = GENERATE("none", "a file more", "another tile", "copied");
  CAPTURE(change);
  const std::filesystem::path folder = in / "m.tiles";
  if (change == "a file more") write_text(folder / "notes.txt", "mine");
  if (change == "another tile") write_text(folder / "000000.ply", "mine");
  if (change == "copied") {
    std::filesystem::copy(folder, in / "copy");
    std::filesystem::remove_all(folder);
    std::filesystem::rename(in / "copy", folder);
  }
  const auto before = names_of(folder);
  const auto result = run_in(in, job);
  REQUIRE(result.status == 0);
  CHECK(std::filesystem::exists(in / "m.ply"));
  CHECK(std::filesystem::exists(folder) == (change != "none"));
  if (change == "none") {
    CHECK_THAT(result.err, Contains("m.tiles of an earlier run is removed"));
    CHECK_THAT(result.out, !Contains("m.tiles"));
  } else {
    CHECK(names_of(folder) == before);
    CHECK_THAT(result.err, Contains("m.tiles was there before and is not of this run"));
    CHECK_THAT(result.out, Contains("m.tiles is not of this run"));
  }
}

TEST_CASE("InspectOfAFolderIsATableOfItsFiles") {
  const ScratchDirectory in;
  std::filesystem::create_directory(in / "scans");
  write_text(in / "scans/b.xyz", classified_plane(false));
  write_text(in / "scans/a.csv", "x,y,z\n0,0,0\n1,0,0\n0,2,0\n");
  write_text(in / "scans/notes.md", "no scan");
  const auto text = run_in(in, {"inspect", "scans"});
  CHECK(text.status == 0);
  CHECK(text.out ==
        "file         format          size   spacing          extent   system\n"
        "scans/a.csv    text      3 points         1       1 x 2 x 0  unknown\n"
        "scans/b.xyz    text  1,600 points  0.800062  39.2 x 39 x 90  unknown\n");
  const json list = json_of(run_in(in, {"inspect", "scans", "--json"}));
  REQUIRE(list.size() == 2);
  CHECK(list[0]["file"] == "scans/a.csv");
  CHECK(list[1]["classes"][0] == json({{"class", 2}, {"name", "ground"}, {"points", 1580}}));
  CHECK(list[1]["attributes"][0] ==
        json({{"name", "classification"}, {"type", "float64"}, {"min", 2.0}, {"max", 18.0}}));
  write_text(in / "scans/broken.ply", "ply\n");
  const auto partly = run_in(in, {"inspect", "scans", "--json"});
  CHECK(partly.status == 3);
  CHECK(json::parse(partly.out).size() == 3);
  CHECK_THAT(json::parse(partly.out)[2]["error"].get<std::string>(), Contains("broken.ply"));
  CHECK_THAT(run_in(in, {"inspect", "scans"}).err, Contains("broken.ply"));
}

TEST_CASE("PointsThatWereNeverClassifiedAreToldWithTheToolForIt") {
  const ScratchDirectory in;
  write_text(in / "a.csv", "x,y,z,classification\n0,0,0,1\n1,0,0,0\n0,1,0,1\n");
  const auto result = run_in(in, {"reconstruct", "a.csv", "-o", "m.ply", "--las-classes", "2"});
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("not classified") && Contains("pdal translate"));
}

// The counts are those of bench/quality/count_selection.py, which reads and decides apart from this
// program.
TEST_CASE("CropsOfRealTilesHoldAsManyPointsAsAScriptCounts", "[costly]") {
  struct Selected {
    const char* file;
    std::vector<std::string> options;
    int points;
  };
  const std::string tile = "lidar/autzen_stadium_tile_las12_pf2.las";
  for (const Selected& selected :
       {Selected{tile.c_str(), {"--crop", "636700,850700,637100,851100"}, 103075},
        Selected{tile.c_str(),
                 {"--crop-area",
                  "POLYGON ((636400.13 850500.77, 637300.5 850700.01, 637100 "
                  "851600.3, 636700.7 851000.2, 636350 851500))"},
                 435801},
        // The limits of the box as polygon: edges that points lie on.
        Selected{tile.c_str(),
                 {"--crop-area",
                  "POLYGON ((636700 850700, 637100 850700, 637100 851100, 636700 "
                  "851100))"},
                 103075},
        Selected{"samples/las/autzen_trim_7.las",
                 {"--crop", "636300,849000,636900,849400", "--drop-classes", "1"},
                 13405},
        Selected{"samples/las/sample_c.las",
                 {"--drop-classes", "6,31", "--crop-area",
                  "POLYGON ((674530.25 1206750, 674600 1206741.5, 674580 1206810))"},
                 34}}) {
    const auto path = data_path(selected.file);
    if (skipped_without(path)) return;
    CAPTURE(selected.file);
    std::vector<std::string> words = {"inspect", path.string(), "--json"};
    words.insert(words.end(), selected.options.begin(), selected.options.end());
    CHECK(json_of(run_program(words))["points"] == selected.points);
  }
}

TEST_CASE("InspectShowsWhatSamplesHold") {
  struct Sample {
    const char* file;
    const char* snapshot;
  };
  for (const Sample& sample :
       {Sample{"las/sample_c.las", "las.txt"}, Sample{"las/extrabytes.las", "las14.txt"},
        Sample{"laz/simple.laz", "laz.txt"},
        Sample{"e57/translationWithoutRotation.e57", "e57.txt"},
        Sample{"ascii/multiple-and-transform.ptx", "ptx.txt"},
        Sample{"ply/text_extradim.ply", "ply.txt"}, Sample{"pcd/autzen-utm.pcd", "pcd.txt"}}) {
    const auto path = data_path(std::string("samples/") + sample.file);
    if (skipped_without(path)) return;
    CAPTURE(sample.file);
    const auto result = run_program({"inspect", path.string()});
    CHECK(result.status == 0);
    CHECK(result.out ==
          file_text(source_path(std::string("tests/cli/inspect/") + sample.snapshot)));
  }
}
