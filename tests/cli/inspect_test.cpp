// inspect and compare: facts that people read and scripts parse.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using nlohmann::json;
using orbweave::test::file_text;
using orbweave::test::ProgramResult;
using orbweave::test::run_in;
using orbweave::test::run_program;
using orbweave::test::ScratchDirectory;
using orbweave::test::write_text;

namespace {

json json_of(const ProgramResult& result) {
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  return json::parse(result.out);
}

void generate(const ScratchDirectory& in, const std::string& shape) {
  REQUIRE(
      run_in(in, {"generate", shape, "--points", "2000", "-o", "cloud.ply", "--truth", "mesh.ply"})
          .status == 0);
}

}  // namespace

TEST_CASE("PicturesOfMeshesAreFittedToTheSurface") {
  const ScratchDirectory in;
  const std::string surface =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  write_text(in / "plain.obj", surface);
  write_text(in / "stray.obj", surface + "v 1e6 1e6 1e6\n");
  for (const std::string name : {"plain", "stray"})
    REQUIRE(run_in(in, {"inspect", name + ".obj", "--picture", name + ".png"}).status == 0);
  CHECK((file_text(in / "plain.png") == file_text(in / "stray.png")));
}

TEST_CASE("InspectTellsACloudsFacts") {
  const ScratchDirectory in;
  write_text(in / "c.csv", "x,y,z,red\n0,0,0,1\n1,0,0,2\n1,0,0,2\n0,1,0,3\nnan,0,0,4\n3,0,2.5,5\n");
  const json facts = json_of(run_in(in, {"inspect", "c.csv", "--json"}));
  CHECK(facts["kind"] == "cloud");
  CHECK(facts["points"] == 6);
  CHECK(facts["bounds"]["min"] == json({0.0, 0.0, 0.0}));
  CHECK(facts["bounds"]["max"] == json({3.0, 1.0, 2.5}));
  CHECK(facts["attributes"][0]["name"] == "red");
  CHECK(facts["spacing"] == 1.0);
  CHECK(facts["duplicates"] == 1);
  CHECK(facts["not_finite"] == 1);
  CHECK(facts["normals"] == false);
  const auto text = run_in(in, {"inspect", "c.csv"});
  CHECK_THAT(text.out, Contains("points       6\n") && Contains("duplicates   1\n") &&
                           Contains("not finite   1\n") && Contains("(3 x 1 x 2.5)"));
}

TEST_CASE("BoundsOfAnyScaleAreShownWithDigits") {
  const ScratchDirectory in;
  const auto bounds_of = [&](const std::string& scale) {
    write_text(in / "c.xyz", "0 0 0\n2e" + scale + " 0 0\n0 3e" + scale + " 1e" + scale + "\n");
    return run_in(in, {"inspect", "c.xyz"}).out;
  };
  CHECK_THAT(bounds_of("0"), Contains("0.00000 .. 2.00000, 0.00000 .. 3.00000, "));
  CHECK_THAT(bounds_of("-29"), Contains("0 .. 2e-29, 0 .. 3e-29, 0 .. 1e-29 (2e-29 x "));
  CHECK_THAT(bounds_of("60"), Contains("0 .. 2e+60, 0 .. 3e+60, 0 .. 1e+60 (2e+60 x "));
  write_text(in / "c.xyz", "1e-9 7 7\n");
  CHECK_THAT(run_in(in, {"inspect", "c.xyz"}).out,
             Contains("1e-09 .. 1e-09, 7.000000 .. 7.000000, "));
}

TEST_CASE("ACloudTooSmallToBeComputedWithHasNoSpacing") {
  const ScratchDirectory in;
  write_text(in / "c.xyz", "0 0 0\n2e-200 0 0\n0 3e-200 0\n");
  const json facts = json_of(run_in(in, {"inspect", "c.xyz", "--json"}));
  CHECK(facts["spacing"].is_null());
  CHECK(
      facts["doubt"] ==
      "an extent of 3e-200 is too small to be computed with: the coordinates need a smaller unit");
}

TEST_CASE("InspectNamesTheFileOfACloudThatNoCubeHolds") {
  const ScratchDirectory in;
  write_text(in / "huge.xyz", "0 0 0\n1 0 0\n0 1 0\n1e305 0 0\n");
  const ProgramResult refused = run_in(in, {"inspect", "huge.xyz"});
  CHECK(refused.status == 3);
  CHECK_THAT(refused.err, Contains("huge.xyz: the cloud is too large"));
}

TEST_CASE("InspectListsUndersampledPlacesOfACloud") {
  const ScratchDirectory in;
  generate(in, "sphere");
  const auto text =
      run_in(in, {"inspect", "cloud.ply", "--undersampled", "--crop", "-2,-2,-2,2,2,0.5"});
  if (text.status == 2) {
    CHECK_THAT(text.err, Contains("without the methods of the Voronoi family"));
    return;
  }
  CHECK_THAT(text.out, Contains("undersampled: "));
  const json found = json_of(run_in(in, {"inspect", "cloud.ply", "--undersampled", "--json"}));
  CHECK(found["points"] == 2000);
  CHECK(found["undersampled"]["points"] == 0);
  CHECK(found["undersampled"]["share"] == 0.0);
  CHECK(found["undersampled"]["places"].empty());
  const json open = json_of(run_in(
      in, {"inspect", "cloud.ply", "--undersampled", "--json", "--crop", "-2,-2,-2,2,2,0.5"}));
  REQUIRE(open["undersampled"]["points"] > 0);
  CHECK(open["undersampled"]["places"][0]["bounds"]["max"][2] <= 0.5);
  CHECK_FALSE(json_of(run_in(in, {"inspect", "cloud.ply", "--json"})).contains("undersampled"));
}

TEST_CASE("InspectRefusesUndersampledPlacesThatItCannotFind") {
  const ScratchDirectory in;
  generate(in, "sphere");
  CHECK(run_in(in, {"inspect", "mesh.ply", "--undersampled"}).status == 2);
  CHECK(run_in(in, {"inspect", "-", "--undersampled"}).status == 2);
  const auto small = run_in(in, {"inspect", "cloud.ply", "--undersampled", "--memory", "64MiB"});
  if (small.status == 2) return;
  CHECK(small.status == 4);
  CHECK_THAT(small.err, Contains("at least 101 MiB"));
  write_text(in / "flat.csv", "x,y,z\n0,0,0\n1,0,0\n0,1,0\n1,1,0\n2,1,0\n");
  const auto flat = run_in(in, {"inspect", "flat.csv", "--undersampled"});
  CHECK(flat.status == 3);
  CHECK_THAT(flat.err, Contains("flat.csv: ") && Contains("5 points in one plane"));
  const auto none = run_in(in, {"inspect", "cloud.ply", "--undersampled", "--crop", "8,8,8,9,9,9"});
  CHECK(none.status == 3);
  CHECK_THAT(none.err,
             Contains("cloud.ply: ") && Contains("found 0 points") && !Contains("too large"));
}

TEST_CASE("InspectSaysWhatItsMemoryBudgetCountsFor") {
  const ScratchDirectory in;
  CHECK_THAT(run_in(in, {"inspect", "--help"}).out, Contains("counts for --undersampled alone"));
}

TEST_CASE("InspectTellsAMeshsFactsWithTheReportsKeys") {
  const ScratchDirectory in;
  generate(in, "torus");
  const json facts = json_of(run_in(in, {"inspect", "mesh.ply", "--json"}));
  CHECK(facts["kind"] == "mesh");
  CHECK(facts["watertight"] == true);
  CHECK(facts["euler_characteristic"] == 0);
  CHECK(facts["triangles"] == 2 * facts["vertices"].get<int>());
  for (const char* key : {"components", "boundary_edges", "boundary_loops", "nonmanifold_edges",
                          "nonmanifold_vertices", "area", "checksum"})
    CHECK(facts.contains(key));
  CHECK_THAT(run_in(in, {"inspect", "mesh.ply"}).out, Contains("watertight            yes\n"));
}

TEST_CASE("InspectOfAReconstructionAgreesWithItsReport") {
  const ScratchDirectory in;
  generate(in, "plane");
  REQUIRE(run_in(in, {"reconstruct", "cloud.ply", "-o", "out.ply", "--report", "r.json",
                      "--chunk-points", "300"})
              .status == 0);
  json facts = json_of(run_in(in, {"inspect", "out.ply", "--json"}));
  const json report = json::parse(file_text(in / "r.json"));
  facts.erase("kind");
  facts.erase("holes");
  CHECK(std::abs(facts["area"].get<double>() / report["mesh"]["area"].get<double>() - 1) < 1e-12);
  json mesh = report["mesh"];
  // The job looks for crossings at its patches alone, unless it is asked for all.
  CHECK(facts["crossing_pairs"] == 0);
  CHECK(mesh["patch_crossing_pairs"] == 0);
  CHECK(facts["patch_area"].get<double>() ==
        Approx(mesh["patch_area"].get<double>()).epsilon(1e-9));
  // A mesh in a file does not say which of its vertices were one before.
  CHECK(facts["pinches"].is_null());
  CHECK(mesh["pinches"] == 0);
  for (const char* key :
       {"area", "patch_area", "crossing_pairs", "patch_crossing_pairs", "pinches"}) {
    mesh.erase(key);
    facts.erase(key);
  }
  CHECK(facts == mesh);
}

TEST_CASE("InspectMeasuresDistancesToACloud") {
  const ScratchDirectory in;
  generate(in, "sphere");
  const json facts =
      json_of(run_in(in, {"inspect", "mesh.ply", "--against", "cloud.ply", "--json"}));
  const json& distances = facts["against"];
  CHECK(distances["file"] == "cloud.ply");
  CHECK(distances["cloud_to_mesh"]["points"] == 2000);
  CHECK(distances["cloud_to_mesh"]["max"] > 0.0);
  CHECK(distances["cloud_to_mesh"]["max"] < 0.01);  // sagitta of the truth mesh's facets
  CHECK_THAT(run_in(in, {"inspect", "mesh.ply", "--against", "cloud.ply"}).out,
             Contains("cloud to mesh") && Contains("largest"));
  CHECK(run_in(in, {"inspect", "cloud.ply", "--against", "cloud.ply"}).status == 3);
}

TEST_CASE("DistancesThatWereNotMeasuredAreNull") {
  const ScratchDirectory in;
  write_text(in / "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write_text(in / "nothing.ply",
             "ply\nformat ascii 1.0\nelement vertex 0\nproperty double x\nproperty double y\n"
             "property double z\nelement face 0\nproperty list uchar int vertex_indices\n"
             "end_header\n");
  const json found = json_of(run_in(in, {"compare", "m.obj", "nothing.ply", "--json"}));
  const json against =
      json_of(run_in(in, {"inspect", "m.obj", "--against", "nothing.ply", "--json"}))["against"];
  for (const json& distances : {found["a_to_b"], found["b_to_a"], against["mesh_to_cloud"],
                                against["surface_to_cloud"], against["cloud_to_mesh"]}) {
    CHECK(distances["measured"] == 0);
    for (const char* key : {"mean", "rms", "median", "percentile_95", "max"})
      CHECK(distances[key].is_null());
  }
}

TEST_CASE("InspectTellsOfVerticesOfAMeshThatAreNotFinite") {
  const ScratchDirectory in;
  write_text(in / "m.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
             "property double z\nelement face 4\nproperty list uchar int vertex_indices\n"
             "end_header\n0 0 0\n1 0 0\n0 1 0\nnan 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
  const json facts = json_of(run_in(in, {"inspect", "m.ply", "--json"}));
  CHECK(facts["not_finite"] == 1);
  CHECK(facts["area"] == 0.5);
  CHECK(facts["crossing_pairs"] == 0);
  CHECK(facts["watertight"] == false);
  CHECK_THAT(run_in(in, {"inspect", "m.ply"}).out,
             Contains("watertight            no\n") && Contains("vertices not finite   1\n"));
}

TEST_CASE("ACloudThatCannotBeComputedWithIsRefusedBehindAgainst") {
  const ScratchDirectory in;
  write_text(in / "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write_text(in / "far.xyz", "0 0 0\n1e200 0 0\n");
  const auto result = run_in(in, {"inspect", "m.obj", "--against", "far.xyz"});
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("far.xyz") && Contains("too large to be computed with"));
}

TEST_CASE("RoundingIsNoErrorInThePictureOfErrors") {
  const ScratchDirectory in;
  generate(in, "sphere");
  const auto same = run_in(in, {"compare", "mesh.ply", "mesh.ply", "--errors-picture", "e.png"});
  REQUIRE(same.status == 0);
  CHECK_THAT(same.out, Contains("e.png: white, there is no error"));
}

TEST_CASE("InspectMeasuresAMeshByAreaAgainstACloudAndDrawsItsErrors") {
  const ScratchDirectory in;
  generate(in, "sphere");
  const std::vector<std::string> words = {"inspect",  "mesh.ply",  "--against",        "cloud.ply",
                                          "--within", "0.001,0.2", "--samples",        "2000",
                                          "--errors", "e.ply",     "--errors-picture", "e.png"};
  const auto text = run_in(in, words);
  REQUIRE(text.status == 0);
  CHECK_THAT(text.out, Contains("mesh to cloud, by area") && Contains("F-score") &&
                           Contains("e.png: from white (0) to purple ("));
  CHECK_THAT(file_text(in / "e.ply"), Contains("property double error\n"));
  CHECK(file_text(in / "e.png").starts_with("\x89PNG"));
  std::vector<std::string> more = words;
  more.emplace_back("--json");
  const json distances = json_of(run_in(in, more))["against"];
  CHECK(distances["surface_to_cloud"]["measured"] == 2000);
  CHECK(distances["surface_to_cloud"]["max"] < 0.1);
  CHECK(distances["within"][0]["precision"] < 0.5);
  CHECK(distances["within"][1]["f_score"] == 1.0);
}

TEST_CASE("APictureOfErrorsThatAreAll0SaysSo") {
  const ScratchDirectory in;
  write_text(in / "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 3 2 4\n");
  const auto same = run_in(in, {"compare", "m.obj", "m.obj", "--errors-picture", "e.png"});
  CHECK(same.status == 0);
  CHECK_THAT(same.out, Contains("e.png: white, there is no error\n"));
}

TEST_CASE("MeasuresAgainstACloudNeedOne") {
  const ScratchDirectory in;
  generate(in, "sphere");
  CHECK(run_in(in, {"inspect", "mesh.ply", "--within", "0.1"}).status == 2);
  CHECK(run_in(in, {"inspect", "mesh.ply", "--errors", "e.ply"}).status == 2);
  CHECK(run_in(in, {"inspect", "mesh.ply", "--against", "cloud.ply", "--errors", "e.obj"}).status ==
        2);
  CHECK_FALSE(std::filesystem::exists(in / "e.ply"));
}

TEST_CASE("InspectDrawsMeshesAndClouds", "[costly]") {
  const ScratchDirectory in;
  generate(in, "cube");
  const std::string file = GENERATE("mesh.ply", "cloud.ply");
  CHECK(run_in(in, {"inspect", file, "--picture", "p.png"}).status == 0);
  CHECK(file_text(in / "p.png").substr(1, 3) == "PNG");
}

TEST_CASE("InspectOfDamagedFilesIsBadInput") {
  const ScratchDirectory in;
  write_text(in / "broken.ply", "ply\nformat ascii 1.0\nelement vertex many\nend_header\n");
  const std::string file = GENERATE("broken.ply", "missing.ply", ".");
  const auto result = run_in(in, {"inspect", file, "--json"});
  CHECK(result.status == 3);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, StartsWith("orbweave: error: " + file));
}

TEST_CASE("MeshIsTheSameAsItselfInAnyFormat") {
  const ScratchDirectory in;
  generate(in, "sphere");
  REQUIRE(run_in(in, {"convert", "mesh.ply", "mesh.obj"}).status == 0);
  const auto text = run_in(in, {"compare", "mesh.ply", "mesh.obj", "--samples", "100"});
  CHECK(text.status == 0);
  CHECK_THAT(text.out, StartsWith("same: "));
  const json found =
      json_of(run_in(in, {"compare", "mesh.ply", "mesh.obj", "--samples", "100", "--json"}));
  CHECK(found["identical"] == true);
  CHECK(found["a"]["checksum"] == found["b"]["checksum"]);
}

TEST_CASE("DifferentMeshesExitZeroAndShowHowTheyDiffer") {
  const ScratchDirectory in;
  generate(in, "sphere");
  REQUIRE(run_in(in, {"reconstruct", "cloud.ply", "-o", "out.ply"}).status == 0);
  const auto text = run_in(in, {"compare", "out.ply", "mesh.ply", "--samples", "100"});
  CHECK(text.status == 0);
  CHECK_THAT(text.out, StartsWith("different\n") && Contains("2,000") && Contains("A to B"));
  const json found =
      json_of(run_in(in, {"compare", "out.ply", "mesh.ply", "--samples", "100", "--json"}));
  CHECK(found["identical"] == false);
  CHECK(found["a"]["vertices"] == 2000);
  CHECK(found["a_to_b"]["max"] > 0.0);
  CHECK(found["b_to_a"]["measured"] == found["b"]["vertices"]);
}

TEST_CASE("CompareMeasuresSurfacesByAreaAndWritesErrors") {
  const ScratchDirectory in;
  generate(in, "sphere");
  REQUIRE(run_in(in, {"reconstruct", "cloud.ply", "-o", "out.ply"}).status == 0);
  const auto text = run_in(in, {"compare", "out.ply", "mesh.ply", "--within", "0.001,0.5",
                                "--samples", "20000", "--errors", "errors.ply"});
  CHECK(text.status == 0);
  CHECK_THAT(text.out, Contains("A to B, by area") && Contains("20,000") && Contains("F-score") &&
                           Contains("Hausdorff distance"));
  const json facts = json_of(run_in(in, {"inspect", "errors.ply", "--json"}));
  CHECK(facts["vertices"] == 2000);
  CHECK_THAT(file_text(in / "errors.ply"), Contains("property double error"));
  const json found = json_of(run_in(
      in, {"compare", "out.ply", "mesh.ply", "--within", "0.5", "--samples", "3000", "--json"}));
  CHECK(found["by_area"]["within"][0]["f_score"] == 1.0);
  CHECK(found["by_area"]["a_to_b"]["measured"] == 3000);
  CHECK(found["by_area"]["opposite_normals"] == 0.0);
  CHECK(run_in(in, {"compare", "out.ply", "mesh.ply", "--errors", "e.obj"}).status == 2);
  CHECK(run_in(in, {"compare", "out.ply", "mesh.ply", "--errors", "mesh.ply"}).status == 2);
  CHECK(run_in(in, {"compare", "out.ply", "mesh.ply", "--samples", "1000000000000"}).status == 2);
}

TEST_CASE("DistancesToLookWithinAreFiniteAndAboveZero") {
  const ScratchDirectory in;
  generate(in, "sphere");
  for (const std::string within : {"0", "-1", "nan", "1,nan", "inf", "1,far"}) {
    INFO(within);
    for (const auto& result :
         {run_in(in, {"compare", "mesh.ply", "mesh.ply", "--within", within}),
          run_in(in, {"inspect", "mesh.ply", "--against", "cloud.ply", "--within", within})}) {
      CHECK(result.status == 2);
      CHECK_THAT(result.err, Contains("--within") && Contains("expected a finite number above 0"));
      CHECK(result.err.size() < 150);
    }
  }
}

TEST_CASE("FloatThatWouldMovePointsIsCountedFromAnOrigin") {
  const ScratchDirectory in;
  write_text(in / "far.xyz", "1000000.123 0 0\n1000000.223 0 0\n1000000.323 0 0\n");
  write_text(in / "near.xyz", "0.123 0 0\n0.223 0 0\n0.323 0 0\n");
  const auto far = run_in(in, {"convert", "far.xyz", "far.ply", "--float"});
  CHECK(far.status == 0);
  CHECK(far.err.empty());
  CHECK_THAT(far.out, Contains("counted from 1000000, 0, 0"));
  CHECK(run_in(in, {"convert", "far.xyz", "far.ply", "--float", "--origin", "none"}).status == 2);
  const auto near = run_in(in, {"convert", "near.xyz", "near.ply", "--float"});
  CHECK(near.err.empty());
  CHECK_THAT(near.out, !Contains("counted from"));
}

TEST_CASE("InspectOfSeveralFilesNamesEachOfThem") {
  const ScratchDirectory in;
  generate(in, "torus");
  const json list = json_of(run_in(in, {"inspect", "cloud.ply", "mesh.ply", "--json"}));
  REQUIRE(list.size() == 2);
  CHECK(list[0]["file"] == "cloud.ply");
  CHECK(list[0]["kind"] == "cloud");
  CHECK(list[1]["file"] == "mesh.ply");
  CHECK(list[1]["kind"] == "mesh");
  const auto text = run_in(in, {"inspect", "cloud.ply", "mesh.ply"});
  CHECK_THAT(text.out, StartsWith("cloud.ply\n") && Contains("\n\nmesh.ply\n"));
  const auto drawn = run_in(in, {"inspect", "cloud.ply", "mesh.ply", "--picture", "p.png"});
  CHECK(drawn.status == 2);
  CHECK_FALSE(std::filesystem::exists(in / "p.png"));
}
