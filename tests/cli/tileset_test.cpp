// GLB and levels of detail, as a user makes them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "io/meshes/mesh_writer.h"
#include "tests/io/glb_file.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/meshes.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

void make_mesh(const ScratchDirectory& in, Vec3 place = {}) {
  write_mesh(in / "mesh.ply", moved(torus_mesh(3000), [&](Vec3 p) { return p + place; }));
}

nlohmann::json tileset_in(const fs::path& folder) {
  std::ifstream stream(folder / "tileset.json");
  return nlohmann::json::parse(stream);
}

const std::vector<std::string> kLevelsJob = {
    "reconstruct", "scan.ply",   "-o",        "mesh.ply",    "--tileset",
    "levels",      "--simplify", "ratio=0.1", "--progress",  "none",
    "--threads",   "2",          "--report",  "report.json", "--tileset-compression",
    "meshopt"};

/// What the report says of a stage.
nlohmann::json stage_in_status(const ScratchDirectory& in, const std::string& name) {
  const std::string text = run_in(in, {"status", "mesh.work", "--json"}).out;
  const nlohmann::json status = nlohmann::json::parse(text);
  for (const nlohmann::json& stage : status["stages"])
    if (stage["name"] == name) return stage;
  return {};
}

nlohmann::json stage_in_report(const ScratchDirectory& in, const std::string& name) {
  const nlohmann::json report = nlohmann::json::parse(file_text(in / "report.json"));
  for (const nlohmann::json& stage : report["stages"])
    if (stage["name"] == name) return stage;
  return {};
}

/// Kills the job as soon as so many nodes of a stage are committed; returns what it said.
std::string kill_with_nodes(const ScratchDirectory& in, const std::string& stage,
                            std::size_t nodes) {
  RunningProgram program(kLevelsJob, {.directory = in.path()});
  const auto reached = [&] { return results_in(in / "mesh.work" / stage) >= nodes; };
  REQUIRE(program.hold_when(reached));
  program.send(SIGKILL);
  const ProgramResult result = program.wait();
  CHECK(result.status == 128 + SIGKILL);
  return result.err;
}

fs::path a_stored_node(const fs::path& stage) {
  for (const fs::directory_entry& entry : fs::directory_iterator(stage))
    if (entry.path().extension() == ".h5") return entry.path();
  return {};
}

void check_same_levels(const ScratchDirectory& in, const ScratchDirectory& undisturbed) {
  CHECK(names_in(in) == names_in(undisturbed));
  for (const char* file : {"mesh.ply", "mesh.simplified.ply"})
    CHECK((file_text(in / file) == file_text(undisturbed / file)));
  std::size_t tiles = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(undisturbed / "levels")) {
    const std::string name = entry.path().filename().string();
    CHECK((file_text(in / "levels" / name) == file_text(entry.path())));
    ++tiles;
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(in / "levels"))
    tiles -= entry.is_regular_file() ? 1 : 0;
  CHECK(tiles == 0);
}

}  // namespace

TEST_CASE("GlbOfAJobIsTheSameForAnyCutAndThatOfItsConvertedPly") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "bumpy-torus", "--points", "3000", "-o", "scan.ply"}).status ==
          0);
  const auto reconstruct = [&](const char* mesh, const char* points) {
    const ProgramResult result =
        run_in(in, {"reconstruct", "scan.ply", "-o", mesh, "--chunk-points", points});
    CHECK(result.status == 0);
  };
  reconstruct("a.glb", "3000");
  reconstruct("b.glb", "400");
  reconstruct("c.ply", "3000");
  REQUIRE(run_in(in, {"convert", "c.ply", "d.glb"}).status == 0);
  CHECK(file_text(in / "a.glb") == file_text(in / "b.glb"));
  CHECK(file_text(in / "a.glb") == file_text(in / "d.glb"));
  CHECK(GlbFile(in / "a.glb").triangles().size() > 5000);
}

TEST_CASE("FilesForParaViewOfAJobAreThoseOfItsConvertedPly") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "bumpy-torus", "--points", "3000", "-o", "scan.ply"}).status ==
          0);
  for (const char* folder : {"a", "b"}) {
    fs::create_directory(in / folder);
    const std::string at = folder;
    for (const char* mesh : {"/m.vtp", "/m.xdmf"})
      CHECK(run_in(in, {"reconstruct", "scan.ply", "-o", at + mesh, "--no-fill", "--chunk-points",
                        at == "a" ? "3000" : "400"})
                .status == 0);
  }
  fs::create_directory(in / "c");
  REQUIRE(run_in(in, {"reconstruct", "scan.ply", "-o", "c.ply", "--no-fill"}).status == 0);
  for (const char* mesh : {"c/m.vtp", "c/m.xdmf"})
    REQUIRE(run_in(in, {"convert", "c.ply", mesh}).status == 0);
  for (const char* file : {"m.vtp", "m.xdmf", "m.h5"}) {
    INFO(file);
    CHECK((file_text(in / "a" / file) == file_text(in / "b" / file)));
    CHECK((file_text(in / "a" / file) == file_text(in / "c" / file)));
    CHECK(file_text(in / "a" / file).size() > 300);
  }
  const ProgramResult text = run_in(in, {"fill", "c.ply", "-o", "text.vtp", "--format", "text"});
  CHECK(text.status == 2);
  CHECK_THAT(text.err, Contains("VTP has no text encoding"));
  CHECK(run_in(in, {"inspect", "c/m.vtp"}).status == 2);
  const ProgramResult same = run_in(in, {"convert", "c.ply", "c/m.h5"});
  CHECK(same.status == 2);
}

TEST_CASE("GlbIsReadWhereverAMeshMayBe") {
  const ScratchDirectory in;
  make_mesh(in);
  REQUIRE(run_in(in, {"convert", "mesh.ply", "mesh.glb"}).status == 0);
  // What GLB keeps of the mesh, as PLY.
  REQUIRE(run_in(in, {"convert", "mesh.glb", "again.ply"}).status == 0);
  const ProgramResult compared = run_in(in, {"compare", "mesh.glb", "again.ply", "--json"});
  CHECK(compared.status == 0);
  CHECK(Json::parse(compared.out)["identical"] == true);
  const auto facts = [&](const char* file) {
    const ProgramResult told = run_in(in, {"inspect", file, "--json"});
    CHECK(told.status == 0);
    return Json::parse(told.out);
  };
  CHECK(facts("mesh.glb") == facts("again.ply"));
  for (const char* command : {"tileset", "fill", "reconstruct"}) {
    INFO(command);
    CHECK(run_in(in, {command, "mesh.glb", "-o", "glb.ply"}).status == 0);
    CHECK(run_in(in, {command, "again.ply", "-o", "ply.ply"}).status == 0);
    const char* file = fs::is_directory(in / "glb.ply") ? "000000.glb" : "";
    CHECK((file_text(in / "glb.ply" / file) == file_text(in / "ply.ply" / file)));
    fs::remove_all(in / "glb.ply");
    fs::remove_all(in / "ply.ply");
  }
  CHECK(run_in(in, {"view", "mesh.glb", "-o", "page.html"}).status == 0);
  write_text(in / "short.glb", file_text(in / "mesh.glb").substr(0, 1000));
  const ProgramResult damaged = run_in(in, {"inspect", "short.glb"});
  CHECK(damaged.status == 3);
  CHECK_THAT(damaged.err, Contains("short.glb") && Contains("byte 8"));
  const ProgramResult text = run_in(in, {"fill", "mesh.ply", "-o", "text.glb", "--format", "text"});
  CHECK(text.status == 2);
  CHECK_THAT(text.err, Contains("GLB has no text encoding"));
}

TEST_CASE("GlbShowsTheUprightAxisOfThePictureAndTheWorldsCoordinates") {
  const ScratchDirectory in;
  make_mesh(in, {4'176'000.3, -512'000.2, 250.0});
  REQUIRE(run_in(in, {"fill", "mesh.ply", "-o", "z.glb", "--picture-up", "z"}).status == 0);
  REQUIRE(run_in(in, {"fill", "mesh.ply", "-o", "y.glb", "--picture-up", "y"}).status == 0);
  const std::vector<Vec3> z = GlbFile(in / "z.glb").seen_positions();
  const std::vector<Vec3> y = GlbFile(in / "y.glb").seen_positions();
  for (std::size_t i = 0; i < z.size(); ++i) {
    CHECK(norm(Vec3{z[i].x, -z[i].z, z[i].y} - y[i]) < 1e-6);
    CHECK(std::abs(y[i].x - 4'176'000.0) < 2.0);
  }
  CHECK_FALSE(fs::exists(in / "z.glb.shift.txt"));
}

TEST_CASE("TilesetCommandSaysWhatItMade") {
  const ScratchDirectory in;
  make_mesh(in);
  const ProgramResult made =
      run_in(in, {"tileset", "mesh.ply", "-o", "tiles", "--leaf-triangles", "700"});
  REQUIRE(made.status == 0);
  CHECK_THAT(made.out, Contains("tiles/tileset.json") && Contains("at borders"));
  CHECK(tileset_in(in / "tiles")["asset"]["version"] == "1.1");
  CHECK_FALSE(fs::exists(in / "tiles.work"));
  const std::string before = file_text(in / "tiles" / "tileset.json");
  const ProgramResult again = run_in(in, {"tileset", "mesh.ply", "-o", "tiles", "--leaf-triangles",
                                          "700", "--threads", "3", "--memory", "64MiB"});
  REQUIRE(again.status == 0);
  CHECK(again.out == made.out);
  CHECK(file_text(in / "tiles" / "tileset.json") == before);
}

TEST_CASE("CompressedTilesetOfAJobHasTheBytesOfTheCommand") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "bumpy-torus", "--points", "3000", "-o", "scan.ply"}).status ==
          0);
  write_text(in / "job.toml",
             "[input]\nfiles = [\"scan.ply\"]\n[output]\nmesh = \"mesh.ply\"\ntileset = \"a\"\n"
             "tileset_compression = \"meshopt\"\n");
  REQUIRE(run_in(in, {"run", "job.toml"}).status == 0);
  REQUIRE(
      run_in(in, {"tileset", "mesh.ply", "-o", "b", "--tileset-compression", "meshopt"}).status ==
      0);
  for (const char* file : {"tileset.json", "tiles.json", "000000.glb"})
    CHECK(file_text(in / "a" / file) == file_text(in / "b" / file));
  CHECK_THAT(file_text(in / "a" / "000000.glb"), Contains("EXT_meshopt_compression"));
  const ProgramResult refused =
      run_in(in, {"tileset", "mesh.ply", "-o", "b", "--tileset-compression", "zip"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("zip") && Contains("meshopt"));
}

TEST_CASE("TilesetOfAJobHasTheBytesOfTheCommand") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "bumpy-torus", "--points", "3000", "-o", "scan.ply"}).status ==
          0);
  const ProgramResult made =
      run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--tileset", "a"});
  REQUIRE(made.status == 0);
  CHECK_THAT(made.out, Contains("tileset"));
  REQUIRE(run_in(in, {"tileset", "mesh.ply", "-o", "b"}).status == 0);
  for (const char* file : {"tileset.json", "tiles.json", "000000.glb"})
    CHECK(file_text(in / "a" / file) == file_text(in / "b" / file));
  const ProgramResult refused =
      run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.stl", "--tileset", "c"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("--tileset") && Contains(".ply"));
  CHECK_FALSE(fs::exists(in / "mesh.stl"));
}

TEST_CASE("TilesetOfAJobThatIsKilledMeanwhileIsMadeByTheNextRun", "[slow]") {
  const ScratchDirectory undisturbed;
  const ScratchDirectory in;
  const std::vector<std::string> command = {"reconstruct", "scan.ply",  "-o",         "mesh.ply",
                                            "--tileset",   "levels",    "--threads",  "2",
                                            "--simplify",  "ratio=0.5", "--progress", "none"};
  for (const ScratchDirectory* where : {&undisturbed, &in})
    REQUIRE(
        run_in(*where, {"generate", "bumpy-torus", "--points", "60000", "-o", "scan.ply"}).status ==
        0);
  REQUIRE(run_in(undisturbed, command).status == 0);
  const auto a_tile_is_there = [&] {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(in.path()))
      if (entry.path().extension() == ".glb") return true;
    return false;
  };
  bool was_killed = false;
  for (int attempt = 0; attempt < 5 && !was_killed; ++attempt) {
    for (const char* output : {"levels", "mesh.simplified.ply", "mesh.ply", "mesh.work"})
      fs::remove_all(in / output);
    RunningProgram program(command, {.directory = in.path()});
    was_killed = program.hold_when(a_tile_is_there);
    if (was_killed) program.send(SIGKILL);
    CHECK(program.wait().status == (was_killed ? 128 + SIGKILL : 0));
  }
  REQUIRE(was_killed);
  CHECK_FALSE(fs::exists(in / "levels"));
  REQUIRE(run_in(in, command).status == 0);
  CHECK(names_in(in) == names_in(undisturbed));
  for (const char* file : {"mesh.ply", "mesh.simplified.ply"})
    CHECK((file_text(in / file) == file_text(undisturbed / file)));
  for (const fs::directory_entry& entry : fs::directory_iterator(undisturbed / "levels")) {
    const fs::path name = entry.path().filename();
    CHECK((file_text(in / "levels" / name.string()) == file_text(entry.path())));
  }
}

TEST_CASE("JobThatIsKilledAmongItsLevelsSimplifiesNoNodeAgain", "[slow]") {
  const ScratchDirectory undisturbed;
  const ScratchDirectory in;
  for (const ScratchDirectory* where : {&undisturbed, &in})
    REQUIRE(run_in(*where, {"generate", "bumpy-torus", "--points", "200000", "-o", "scan.ply"})
                .status == 0);
  REQUIRE(run_in(undisturbed, kLevelsJob).status == 0);
  CHECK(stage_in_report(undisturbed, "tileset")["chunks_reused"] == 0);
  CHECK(stage_in_report(undisturbed, "simplify")["chunks_reused"] == 0);
  const fs::path tiles = in / "mesh.work" / "tileset";
  std::size_t kept = 0;
  for (const std::size_t nodes : {1, 3}) {
    kill_with_nodes(in, "tileset", nodes);
    CHECK_FALSE(fs::exists(in / "levels"));
    CHECK(results_in(tiles) >= std::max(nodes, kept));
    kept = results_in(tiles);
  }
  CHECK(stage_in_status(in, "tileset")["chunks_done"] == kept);
  damage(a_stored_node(tiles));
  CHECK_THAT(kill_with_nodes(in, "simplify", 1), Contains("computing it again"));
  const std::size_t of_tileset = results_in(tiles);
  const std::size_t of_simplified = results_in(in / "mesh.work" / "simplify");
  CHECK(of_tileset > kept);
  REQUIRE(run_in(in, kLevelsJob).status == 0);
  CHECK(stage_in_report(in, "tileset")["chunks_reused"] == of_tileset);
  CHECK(stage_in_report(in, "simplify")["chunks_reused"] == of_simplified);
  check_same_levels(in, undisturbed);
}

TEST_CASE("TilesetLiesOnTheEarthWhereTheCoordinateSystemIsKnown") {
  const ScratchDirectory in;
  make_mesh(in, {500'000, 4'500'000, 100});
  std::ofstream(in / "mesh.prj") << "EPSG:32612";
  const ProgramResult made = run_in(in, {"tileset", "mesh.ply", "-o", "tiles"});
  REQUIRE(made.status == 0);
  CHECK_THAT(made.out, Contains("on the Earth"));
  const auto m = tileset_in(in / "tiles")["root"]["transform"].get<std::vector<double>>();
  CHECK(std::abs(norm(Vec3{m[12], m[13], m[14]}) - 6'369'000.0) < 10'000.0);
}

TEST_CASE("TilesetLeavesEverythingElseAlone") {
  const ScratchDirectory in;
  make_mesh(in);
  fs::create_directory(in / "mine");
  std::ofstream(in / "mine" / "notes.txt") << "mine";
  const ProgramResult refused = run_in(in, {"tileset", "mesh.ply", "-o", "mine"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("notes.txt"));
  CHECK(file_text(in / "mine" / "notes.txt") == "mine");
  CHECK(run_in(in, {"tileset", "mesh.ply", "-o", "."}).status == 2);
  CHECK(run_in(in, {"tileset", "absent.ply", "-o", "tiles"}).status == 3);
  CHECK_FALSE(fs::exists(in / "tiles"));
  CHECK_FALSE(fs::exists(in / "tiles.work"));
}
