// fill: the hole pass on meshes from elsewhere, as a user runs it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "io/meshes/mesh_stream.h"
#include "tests/cli/holed_meshes.h"
#include "tests/support/meshes.h"

using Catch::Matchers::Contains;
using nlohmann::json;
using namespace orbweave;
using namespace orbweave::test;

namespace {

json facts_of(const ScratchDirectory& in, const std::string& mesh) {
  const ProgramResult inspected = run_in(in, {"inspect", mesh, "--json"});
  REQUIRE(inspected.status == 0);
  return json::parse(inspected.out);
}

json report_in(const ScratchDirectory& in, const std::string& name) {
  return json::parse(file_text(in / name));
}

/// With single blanks: the width of a table's columns is nobody's concern.
std::string squeezed(const std::string& text) {
  std::string single;
  for (const char c : text)
    if (c != ' ' || !single.ends_with(' ')) single += c;
  return single;
}

/// A sphere with a wide hole at the top and a triangle missing at the bottom.
TriangleMesh holed_sphere(const ScratchDirectory& in) {
  TriangleMesh mesh = with_hole(shape_mesh(in, "sphere"), {0.0, 0.0, 1.0}, 0.3);
  const auto lowest = std::ranges::min_element(mesh.triangles, {}, [&](const Triangle& t) {
    return mesh.vertices.positions[t[0]].z + mesh.vertices.positions[t[1]].z +
           mesh.vertices.positions[t[2]].z;
  });
  mesh.triangles.erase(lowest);
  return mesh;
}

/// A unit square sheet with a round hole.
TriangleMesh holed_sheet(const ScratchDirectory& in) {
  return with_hole(shape_mesh(in, "plane"), {0.5, 0.4, 0.0}, 0.1);
}

}  // namespace

TEST_CASE("FillClosesTheHolesAndKeepsWhatWasThere", "[costly]") {
  const ScratchDirectory in;
  const TriangleMesh given = holed_sphere(in);
  write_mesh(in / "in.ply", given);
  const auto run = run_in(in, {"fill", "in.ply", "-o", "out.ply", "--report", "r.json", "--picture",
                               "out.png", "--progress", "none"});
  CHECK(run.status == 0);
  CHECK(run.err.empty());
  CHECK_THAT(squeezed(run.out), Contains("out.ply") && Contains("closed") &&
                                    Contains("loops 2\n") && Contains("filled 2 (1 direct, 1 ") &&
                                    !Contains("left open"));
  CHECK(names_in(in) == std::vector<std::string>{"in.ply", "out.ply", "out.png", "r.json"});

  const TriangleMesh filled = read_mesh(in / "out.ply");
  REQUIRE(filled.vertices.size() > given.vertices.size());
  REQUIRE(filled.triangles.size() > given.triangles.size());
  CHECK(std::equal(given.triangles.begin(), given.triangles.end(), filled.triangles.begin()));
  CHECK(std::equal(given.vertices.positions.begin(), given.vertices.positions.end(),
                   filled.vertices.positions.begin()));
  const auto first_patch =
      filled.hole.begin() + static_cast<std::ptrdiff_t>(given.triangles.size());
  CHECK(std::all_of(filled.hole.begin(), first_patch, [](int id) { return id == 0; }));
  CHECK(std::all_of(first_patch, filled.hole.end(), [](int id) { return id > 0; }));
  for (std::size_t v = given.vertices.size(); v < filled.vertices.size(); ++v)
    CHECK(std::abs(norm(filled.vertices.positions[v]) - 1.0) < 0.02);
  CHECK(facts_of(in, "out.ply")["watertight"] == true);
}

TEST_CASE("FillShowsItsStepsOnStandardErrorAsAJobDoes", "[costly]") {
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sphere(in));
  const auto fill = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"fill", "in.ply", "-o", "-", "--picture", "p.png"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run_in(in, arguments);
  };
  const ProgramResult plain = fill({"--progress", "plain"}), none = fill({"--progress", "none"});
  REQUIRE(plain.status == 0);
  for (const char* line : {"read: begins\n", "read: done in ", "holes: begins, 2 holes\n",
                           "holes: done in ", "picture: done in ", "export: done in "})
    CHECK_THAT(plain.err, Contains(line));
  CHECK(none.status == 0);
  CHECK(none.err.empty());
  // The mesh alone goes to standard output, whatever is shown.
  CHECK(plain.out == none.out);
  CHECK(plain.out.starts_with("ply\n"));
  // Not on a terminal, auto is plain.
  CHECK_THAT(fill({}).err, Contains("holes: begins, 2 holes\n"));
  CHECK(fill({"--progress", "loud"}).status == 2);
}

TEST_CASE("ReportOfAFillHasTheMeshBeforeAndAfterAndEveryHole") {
  const ScratchDirectory in;
  const TriangleMesh given = holed_sphere(in);
  write_mesh(in / "in.ply", given);
  REQUIRE(run_in(in, {"fill", "in.ply", "-o", "out.ply", "--report", "r.json", "--threads", "2"})
              .status == 0);
  const json report = report_in(in, "r.json");
  json before = facts_of(in, "in.ply"), after = facts_of(in, "out.ply");
  for (json* facts : {&before, &after}) {
    facts->erase("kind");
    facts->erase("holes");
  }
  CHECK(report["mesh_before"] == before);
  CHECK(report["mesh"]["pinches"] == 0);
  after["pinches"] = 0;  // a mesh in a file does not say which of its vertices were one before
  CHECK(report["mesh"] == after);
  CHECK(report["options"]["run"]["threads"] == 2);
  CHECK(report["input"]["file"] == "in.ply");
  REQUIRE(report["holes"].size() == 2);
  std::uint64_t points = 0, triangles = 0, edges = 0;
  for (const json& hole : report["holes"]) {
    CHECK(hole["filled"] == true);
    points += hole["points_added"].get<std::uint64_t>();
    triangles += hole["triangles_added"].get<std::uint64_t>();
    edges += hole["edges"].get<std::uint64_t>();
  }
  CHECK(edges == before["boundary_edges"]);
  CHECK(given.vertices.size() + points == after["vertices"]);
  CHECK(given.triangles.size() + triangles == after["triangles"]);
}

TEST_CASE("FillReadsAndWritesPlyObjAndStl", "[costly]") {
  const ScratchDirectory in;
  const std::string from = GENERATE("in.ply", "in.ply.gz", "in.obj", "in.stl");
  const std::string to = GENERATE("out.ply", "out.obj", "out.stl");
  CAPTURE(from, to);
  write_mesh(in / "in.ply", holed_sphere(in));
  if (from == "in.ply.gz") std::filesystem::rename(in / "in.ply", in / "plain.ply");
  if (from != "in.ply")
    REQUIRE(run_in(in, {"convert", from == "in.ply.gz" ? "plain.ply" : "in.ply", from}).status ==
            0);
  const auto run = run_in(in, {"fill", from, "-o", to, "--progress", "none"});
  CHECK(run.status == 0);
  CHECK(run.err.empty());
  CHECK(facts_of(in, to)["watertight"] == true);
}

TEST_CASE("FillStreamsFromStandardInputToStandardOutput") {
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sphere(in));
  REQUIRE(run_in(in, {"fill", "in.ply", "-o", "out.ply"}).status == 0);
  const auto streamed = run_in(in, {"fill", "in.ply", "-o", "-"});
  CHECK(streamed.status == 0);
  CHECK(streamed.out == file_text(in / "out.ply"));
}

TEST_CASE("FilledMeshIsTheSameForAnyNumberOfThreads") {
  const ScratchDirectory in;
  TriangleMesh mesh = shape_mesh(in, "sphere");
  for (const Vec3 center : {Vec3{0.0, 0.0, 1.0}, Vec3{1.0, 0.0, 0.0}, Vec3{0.0, -1.0, 0.0},
                            Vec3{-0.6, 0.8, 0.0}, Vec3{0.0, 0.0, -1.0}})
    mesh = with_hole(mesh, center, 0.2);
  write_mesh(in / "in.ply", mesh);
  for (const char* threads : {"1", "2", "5"}) {
    REQUIRE(
        run_in(in, {"fill", "in.ply", "-o", std::string(threads) + ".ply", "--threads", threads})
            .status == 0);
    CHECK(file_text(in / (std::string(threads) + ".ply")) == file_text(in / "1.ply"));
  }
  CHECK(facts_of(in, "1.ply")["watertight"] == true);
}

TEST_CASE("OuterBorderOfASheetStaysOpenAndTheReasonIsPrinted") {
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sheet(in));
  const auto run = run_in(in, {"fill", "in.ply", "-o", "out.ply"});
  CHECK(run.status == 0);
  CHECK_THAT(squeezed(run.out), Contains("loops 2\n") && Contains("filled 1 (") &&
                                    Contains("left open 1: outer border of an open sheet"));
  const json facts = facts_of(in, "out.ply");
  CHECK(facts["boundary_loops"] == 1);
  CHECK(facts["bounds"]["max"][0] == 1.0);
}

TEST_CASE("LimitsOfTheCommandLineLeaveLargerHolesOpenAndSayWhy") {
  struct Limit {
    const char* option;
    const char* value;
    const char* reason;
  };
  const Limit limit =
      GENERATE(values<Limit>({{"--max-edges", "10", "more edges than --max-edges"},
                              {"--max-diameter", "0.5", "wider than --max-diameter"},
                              {"--max-perimeter", "1.5", "longer than --max-perimeter"}}));
  CAPTURE(limit.option);
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sphere(in));
  const auto run = run_in(
      in, {"fill", "in.ply", "-o", "out.ply", "--report", "r.json", limit.option, limit.value});
  CHECK(run.status == 0);
  CHECK_THAT(squeezed(run.out), Contains("filled 1 (1 direct)") &&
                                    Contains(std::string("left open 1: ")) &&
                                    Contains(limit.reason));
  const json report = report_in(in, "r.json");
  CHECK(report["mesh"]["boundary_loops"] == 1);
  const json& holes = report["holes"];
  const auto open = std::find_if(holes.begin(), holes.end(),
                                 [](const json& hole) { return !hole["filled"].get<bool>(); });
  REQUIRE(open != holes.end());
  CHECK_THAT((*open)["reason"].get<std::string>(), Contains("fill.max_"));
  CHECK((*open)["method"].is_null());
}

TEST_CASE("EveryKeyOfTheFillSectionIsAnOption", "[costly]") {
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sphere(in));
  REQUIRE(run_in(in, {"fill",
                      "in.ply",
                      "-o",
                      "out.ply",
                      "--report",
                      "r.json",
                      "--kernel",
                      "triharmonic",
                      "--neighborhood",
                      "3.5",
                      "--max-diameter",
                      "1.25",
                      "--max-perimeter",
                      "inf",
                      "--max-edges",
                      "400",
                      "--close-outer-border",
                      "--no-intersections",
                      "--uniform-patches",
                      "--min-triangles",
                      "5",
                      "--format",
                      "text",
                      "--precision",
                      "float",
                      "--picture",
                      "p.png",
                      "--picture-up",
                      "z",
                      "--patch-color",
                      "#ff0000"})
              .status == 0);
  CHECK(report_in(in, "r.json")["options"]["fill"] == json({{"enabled", true},
                                                            {"kernel", "triharmonic"},
                                                            {"neighborhood", 3.5},
                                                            {"max_diameter", 1.25},
                                                            {"max_perimeter", nullptr},
                                                            {"max_edges", 400},
                                                            {"keep_outer_border", false},
                                                            {"allow_intersections", false},
                                                            {"graded", false},
                                                            {"min_triangles", 5}}));
  CHECK_THAT(file_text(in / "out.ply"), Contains("format ascii") && Contains("property float x"));
}

TEST_CASE("PatchesHaveTheColourThatWasAskedForInThePicture", "[slow]") {
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sphere(in));
  const std::vector<std::string> command = GENERATE(values<std::vector<std::string>>(
      {{"fill", "in.ply", "-o", "out.ply", "--picture"},
       {"reconstruct", "scan.ply", "-o", "out.ply", "--radii", "0.12", "--picture"}}));
  REQUIRE(run_in(in, {"convert", "--normals-from-faces", "in.ply", "scan.ply"}).status == 0);
  const auto draw = [&](const std::string& picture, const std::string& color) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {picture, "--patch-color", color});
    REQUIRE(run_in(in, arguments).status == 0);
    return file_text(in / picture);
  };
  const std::string blue = draw("a.png", "#4477cc");
  CHECK(draw("b.png", "#4477CC") == blue);
  CHECK(draw("c.png", "#cc7744") != blue);
}

TEST_CASE("PicturesOfEveryCommandHaveTheAxisUprightThatWasAskedFor", "[slow]") {
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sphere(in));
  REQUIRE(run_in(in, {"convert", "--normals-from-faces", "in.ply", "scan.ply"}).status == 0);
  const std::vector<std::string> command = GENERATE(values<std::vector<std::string>>(
      {{"fill", "in.ply", "-o", "out.ply"},
       {"inspect", "in.ply"},
       {"inspect", "scan.ply"},
       {"reconstruct", "scan.ply", "-o", "out.ply", "--radii", "0.12", "--no-fill"}}));
  CAPTURE(command[0], command[1]);
  const auto draw = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"--picture", "picture.png"});
    arguments.insert(arguments.end(), options.begin(), options.end());
    REQUIRE(run_in(in, arguments).status == 0);
    return file_text(in / "picture.png");
  };
  const std::string usual = draw({}), z = draw({"--picture-up", "z"});
  CHECK(draw({"--picture-up", "y"}) == usual);
  CHECK(z != usual);
  CHECK(draw({"--picture-up", "x"}) != z);
  if (command[0] == "reconstruct") CHECK(draw({"--up", "0,0,1"}) == z);
}

TEST_CASE("SmallPiecesAreRemovedWhenAskedFor") {
  const ScratchDirectory in;
  TriangleMesh mesh = holed_sphere(in);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int corner = 0; corner < 3; ++corner) {
    mesh.vertices.append(mesh.vertices, 0);
    mesh.vertices.positions.back() = {5.0, corner == 1 ? 0.1 : 0.0, corner == 2 ? 0.1 : 0.0};
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  write_mesh(in / "in.ply", mesh);
  const auto run = run_in(in, {"fill", "in.ply", "-o", "out.ply", "--min-triangles", "2"});
  CHECK(run.status == 0);
  CHECK_THAT(squeezed(run.out), Contains("removed 1 piece of 1 triangle"));
  CHECK(facts_of(in, "out.ply")["components"] == 1);
}

TEST_CASE("TrianglesThatAreNoSurfaceAreLeftOutWithAWarning") {
  const ScratchDirectory in;
  TriangleMesh mesh = holed_sphere(in);
  const Triangle t = mesh.triangles[7];
  mesh.triangles.insert(mesh.triangles.begin(), {t[0], t[1], t[1]});
  mesh.triangles.push_back({t[1], t[2], t[0]});
  mesh.triangles.push_back({t[1], t[0], t[2]});
  write_mesh(in / "in.ply", mesh);
  const auto run = run_in(in, {"fill", "in.ply", "-o", "out.ply", "--report", "r.json"});
  CHECK(run.status == 0);
  CHECK_THAT(run.err, Contains("orbweave: warning: in.ply: left out 1 triangle with two equal "
                               "vertices, 2 repeated triangles\n"));
  const json report = report_in(in, "r.json");
  CHECK(report["input"]["triangles_dropped"] == json({{"degenerate", 1}, {"repeated", 2}}));
  CHECK(report["mesh"]["watertight"] == true);
}

TEST_CASE("VerticesThatAreNotFiniteAreLeftOutWithTheirTriangles") {
  const ScratchDirectory in;
  write_text(in / "in.obj",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv nan 0 0\n"
             "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 2 5\n");
  const auto run =
      run_in(in, {"fill", "in.obj", "-o", "out.ply", "--close-outer-border", "--progress", "none"});
  CHECK(run.status == 0);
  CHECK(run.err ==
        "orbweave: warning: in.obj: left out 1 triangle with a coordinate that is not finite\n");
  CHECK(facts_of(in, "out.ply")["watertight"] == true);
}

TEST_CASE("MeshWhoseTrianglesShareNoVerticesIsWarnedOf") {
  const ScratchDirectory in;
  const TriangleMesh mesh = holed_sphere(in);
  TriangleMesh soup;
  soup.vertices.schema = mesh.vertices.schema;
  for (const Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t v : t) soup.vertices.append(mesh.vertices, v);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  write_mesh(in / "soup.ply", soup);
  const auto run = run_in(in, {"fill", "soup.ply", "-o", "out.ply"});
  CHECK(run.status == 0);
  CHECK_THAT(run.err, Contains("no triangle shares an edge with another one"));
  // The way out that the warning names.
  REQUIRE(run_in(in, {"convert", "soup.ply", "joined.stl"}).status == 0);
  REQUIRE(run_in(in, {"fill", "joined.stl", "-o", "out.ply"}).status == 0);
  CHECK(facts_of(in, "out.ply")["watertight"] == true);
}

TEST_CASE("ASeamBetweenVerticesOfTheSamePlacesIsWarnedOf") {
  const ScratchDirectory in;
  const TriangleMesh mesh = holed_sphere(in);
  TriangleMesh seamed = mesh;
  const auto vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::uint32_t v = 0; v < vertices; ++v) seamed.vertices.append(mesh.vertices, v);
  const auto x = [&](std::uint32_t v) { return mesh.vertices.positions[v].x; };
  for (Triangle& t : seamed.triangles)
    if (x(t[0]) + x(t[1]) + x(t[2]) > 0.0)
      for (std::uint32_t& v : t) v += vertices;
  write_mesh(in / "seamed.ply", seamed);
  const auto run = run_in(in, {"fill", "seamed.ply", "-o", "out.ply"});
  CHECK(run.status == 0);
  CHECK_THAT(run.err, Contains("border edges lie on one another") && Contains("to .stl and back"));
  CHECK_THAT(run_in(in, {"inspect", "seamed.ply"}).out, Contains("doubled border"));
  // The way out that the warning names.
  REQUIRE(run_in(in, {"convert", "seamed.ply", "joined.stl"}).status == 0);
  const auto joined = run_in(in, {"fill", "joined.stl", "-o", "out.ply"});
  CHECK_THAT(joined.err, !Contains("lie on one another"));
  CHECK(facts_of(in, "out.ply")["watertight"] == true);
  // An open rim is no seam.
  write_mesh(in / "holed.ply", mesh);
  CHECK_THAT(run_in(in, {"inspect", "holed.ply"}).out, !Contains("doubled border"));
}

TEST_CASE("ClosedMeshIsWrittenAsItIs") {
  const ScratchDirectory in;
  write_mesh(in / "in.ply", shape_mesh(in, "torus"));
  const auto run = run_in(in, {"fill", "in.ply", "-o", "out.ply"});
  CHECK(run.status == 0);
  CHECK_THAT(squeezed(run.out), Contains("closed") && !Contains("loops"));
  CHECK_THAT(run_in(in, {"compare", "in.ply", "out.ply", "--samples", "100"}).out,
             Catch::StartsWith("same: "));
}

TEST_CASE("WhatFillCannotReadIsBadInput") {
  const ScratchDirectory in;
  write_text(in / "cloud.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  write_text(in / "broken.ply", "ply\nformat ascii 1.0\nelement vertex many\nend_header\n");
  write_text(in / "flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2\n");
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "50", "-o", "cloud.ply"}).status == 0);
  const std::string file =
      GENERATE("missing.ply", "cloud.xyz", "cloud.ply", "broken.ply", "flat.obj", ".");
  CAPTURE(file);
  const auto result = run_in(in, {"fill", file, "-o", "out.ply"});
  CHECK(result.status == 3);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Contains("orbweave: error: " + file + ": "));
  CHECK(!std::filesystem::exists(in / "out.ply"));
}

TEST_CASE("AMeshOfAFormatThatIsNotReadIsToldAsThat") {
  const ScratchDirectory in;
  write_mesh(in / "mesh.vtp", torus_mesh(500));
  write_text(in / "mesh.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  for (const std::string mesh : {"mesh.vtp", "mesh.off"})
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"fill", mesh, "-o", "out.ply"},
          {"simplify", mesh, "-o", "out.ply", "--triangles", "10"},
          {"tileset", mesh, "-o", "tiles"}}) {
      CAPTURE(mesh, command[0]);
      const ProgramResult result = run_in(in, command);
      CHECK(result.status == 2);
      CHECK_THAT(result.err, Contains(mesh + ": cannot read ." + mesh.substr(5) +
                                      " meshes; supported: .ply[.gz], .obj[.gz]"));
    }
}

TEST_CASE("WrongOptionsAndOutputsOfFillAreFoundBeforeAnyWork", "[costly]") {
  struct Case {
    std::vector<std::string> arguments;
    int status;
    const char* fragment;
  };
  const Case given = GENERATE(values<Case>(
      {{{"-o", "out.xyz"}, 2, "out.xyz: cannot write .xyz meshes"},
       {{"-o", "./in.ply"}, 2, "would replace the mesh that is read"},
       {{"-o", "out.ply", "--report", "in.ply"}, 2, "would replace the mesh that is read"},
       {{"-o", "no/out.ply"}, 4, "no/out.ply: the mesh cannot be written there"},
       {{"-o", "out.ply", "--picture", "no/p.png"},
        4,
        "no/p.png: the picture cannot be written there"},
       {{"-o", "out.ply", "--max-edge", "5"}, 2, "Did you mean --max-edges?"},
       {{"-o", "out.ply", "--max-edges", "-5"}, 2, "an integer of at least 0"},
       {{"-o", "out.ply", "--kernel", "cubic"}, 2, "\"biharmonic\" or \"triharmonic\""},
       {{"-o", "out.ply", "--neighborhood", "0.5"}, 2, "a number of at least 1"},
       {{"-o", "out.ply", "--patch-color", "blue"}, 2, "a colour such as"},
       {{}, 2, "--output"}}));
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sphere(in));
  const std::string before = file_text(in / "in.ply");
  std::vector<std::string> arguments = {"fill", "in.ply"};
  arguments.insert(arguments.end(), given.arguments.begin(), given.arguments.end());
  CAPTURE(given.arguments);
  const auto result = run_in(in, arguments);
  CHECK(result.status == given.status);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Contains(given.fragment));
  CHECK(file_text(in / "in.ply") == before);
  CHECK(names_in(in) == std::vector<std::string>{"in.ply"});
}

TEST_CASE("MeshesOfAScaleThatCannotBeComputedWithAreRefusedByName") {
  const ScratchDirectory in;
  const TriangleMesh given = holed_sheet(in);
  struct Scale {
    double factor;
    std::string message;
  };
  for (const Scale& scale :
       {Scale{1e160, "in.ply: the mesh is too large to be computed with; found a coordinate of "},
        Scale{1e-162, "in.ply: the mesh is too small to be computed with; found an extent of "}}) {
    write_mesh(in / "in.ply", moved(given, [&](Vec3 p) { return scale.factor * p; }));
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"fill", "in.ply", "-o", "out.ply", "--progress", "none"},
          {"inspect", "in.ply"},
          {"compare", "in.ply", "in.ply"}}) {
      CAPTURE(arguments, scale.factor);
      const ProgramResult result = run_in(in, arguments);
      CHECK(result.status == 3);
      CHECK(result.out.empty());
      CHECK_THAT(result.err, Contains(scale.message) &&
                                 Contains("expected an extent from 1e-75 to 1e75. Scale the"));
      CHECK(names_in(in) == std::vector<std::string>{"in.ply"});
    }
  }
  write_mesh(in / "in.ply", moved(given, [](Vec3 p) { return 1e30 * p; }));
  CHECK(facts_of(in, "in.ply")["holes"].size() == 2);
}

TEST_CASE("InspectListsTheLoopsAndWhichAreHoles") {
  const ScratchDirectory in;
  write_mesh(in / "in.ply", holed_sheet(in));
  const json facts = facts_of(in, "in.ply");
  REQUIRE(facts["holes"].size() == 2);
  std::size_t borders = 0;
  for (const json& hole : facts["holes"]) {
    CHECK(hole["filled"] == false);
    const bool is_border = hole["diameter"] > 1.0;
    borders += is_border ? 1 : 0;
    CHECK(hole["reason"].is_null() == !is_border);
  }
  CHECK(borders == 1);
  const auto text = run_in(in, {"inspect", "in.ply"});
  CHECK_THAT(text.out, Contains("at vertex") && Contains("\na hole  ") &&
                           Contains("\nno hole: the outer border of an open sheet"));
  write_mesh(in / "closed.ply", shape_mesh(in, "torus"));
  CHECK(facts_of(in, "closed.ply")["holes"] == json::array());
}

TEST_CASE("InspectShowsTheWidestLoopsOfMany") {
  const ScratchDirectory in;
  TriangleMesh mesh = shape_mesh(in, "plane");
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 3; ++j)
      mesh = with_hole(mesh, {0.2 + 0.2 * i, 0.25 + 0.25 * j, 0.0}, 0.03 + 0.004 * (3 * i + j));
  write_mesh(in / "in.ply", mesh);
  const auto text = run_in(in, {"inspect", "in.ply"});
  CHECK_THAT(text.out, Contains("widest loops") && Contains("and 5 more; --json lists all\n"));
  CHECK(facts_of(in, "in.ply")["holes"].size() == 13);
}

TEST_CASE("FillGoesOnWithTheConfidenceOfEarlierPatches", "[costly]") {
  const ScratchDirectory in;
  const TriangleMesh sheet = shape_mesh(in, "plane");
  const TriangleMesh holed =
      with_hole(with_hole(sheet, {0.3, 0.3, 0.0}, 0.06), {0.7, 0.7, 0.0}, 0.15);
  write_mesh(in / "in.ply", holed);
  REQUIRE(run_in(in, {"fill", "in.ply", "-o", "one.ply", "--confidence", "--max-diameter", "0.25",
                      "--progress", "none"})
              .status == 0);
  const std::map<std::int32_t, float> first = hole_confidence(in / "one.ply");
  REQUIRE(first.size() == 1);

  const ProgramResult run =
      run_in(in, {"fill", "one.ply", "-o", "two.ply", "--confidence", "--report", "r.json",
                  "--picture", "p.png", "--picture-colors", "confidence", "--progress", "none"});
  CHECK(run.err.empty());
  REQUIRE(run.status == 0);
  std::map<std::int32_t, float> expected = first;
  const json report = report_in(in, "r.json");
  for (const json& hole : report["holes"])
    if (hole["filled"] == true)
      expected[hole["id"].get<std::int32_t>()] = hole["confidence"].get<float>();
  REQUIRE(expected.size() == 2);
  CHECK(hole_confidence(in / "two.ply") == expected);

  // Without a loop to fill, and with ids that nobody can go on after.
  CHECK(run_in(in, {"fill", "two.ply", "-o", "three.ply", "--confidence", "--progress", "none"})
            .status == 0);
  CHECK(hole_confidence(in / "three.ply") == expected);
  // Nor is it lost where nobody asks for it again.
  CHECK(run_in(in, {"fill", "one.ply", "-o", "six.ply", "--progress", "none"}).status == 0);
  CHECK(hole_confidence(in / "six.ply") == expected);
  CHECK(run_in(in, {"convert", "two.ply", "five.ply"}).status == 0);
  CHECK(hole_confidence(in / "five.ply") == expected);
  TriangleMesh numbered = read_mesh(in / "one.ply");
  for (std::int32_t& id : numbered.hole) id = id > 0 ? std::numeric_limits<std::int32_t>::max() : 0;
  write_mesh(in / "last.ply", numbered);
  const ProgramResult refused = run_in(in, {"fill", "last.ply", "-o", "four.ply"});
  CHECK(refused.status == 3);
  CHECK_THAT(refused.err, Contains("last.ply: property hole") && Contains("leave no room"));
}
