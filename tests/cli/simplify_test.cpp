// orbweave simplify and output.simplify, as a user calls them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

namespace fs = std::filesystem;

}  // namespace

TEST_CASE("SimplifyCommandSaysWhatItMade") {
  const ScratchDirectory in;
  write_mesh(in / "mesh.ply", torus_mesh(3000));
  const ProgramResult made =
      run_in(in, {"simplify", "mesh.ply", "-o", "small.ply", "--triangles", "1000"});
  INFO(made.err);
  REQUIRE(made.status == 0);
  CHECK_THAT(made.out, Contains("small.ply") && Contains("triangles") && Contains("error"));
  CHECK(read_mesh(in / "small.ply").triangles.size() <= 1000);
  CHECK_FALSE(fs::exists(in / "small.ply.work"));
  REQUIRE(run_in(in, {"simplify", "mesh.ply", "-o", "again.ply", "--triangles", "1000", "--threads",
                      "3", "--memory", "500MiB"})
              .status == 0);
  CHECK((file_text(in / "small.ply") == file_text(in / "again.ply")));
  for (const char* name : {"a.stl", "a.obj", "a.glb", "a.ply.gz"}) {
    INFO(name);
    CHECK(run_in(in, {"simplify", "mesh.ply", "-o", name, "--ratio", "0.1"}).status == 0);
    CHECK(fs::exists(in / name));
  }
}

TEST_CASE("AnInterruptedCommandOfLevelsSaysThatNothingWasWritten") {
  const std::string command = GENERATE("simplify", "tileset");
  const ScratchDirectory in;
  write_mesh(in / "mesh.ply", torus_mesh(40000));
  std::vector<std::string> words = {command, "mesh.ply", "-o", "out.ply"};
  if (command == "simplify") words.insert(words.end(), {"--ratio", "0.1"});
  bool in_time = false;
  for (int tries = 0; tries < 20 && !in_time; ++tries) {
    fs::remove_all(in / "out.ply");
    RunningProgram program(words, {.directory = in.path()});
    in_time = program.hold_when([&] { return fs::exists(in / "out.ply.work"); });
    if (in_time) program.send(SIGINT);
    program.release();
    const ProgramResult result = program.wait();
    in_time = in_time && result.status != 0;
    if (!in_time) continue;
    CHECK(result.status == 130);
    CHECK_THAT(result.err, Contains("interrupted; nothing was written") &&
                               !Contains("the same command resumes"));
    CHECK(names_in(in) == std::vector<std::string>{"mesh.ply"});
  }
  CHECK(in_time);
}

TEST_CASE("ASimplifiedMeshNeverVanishes") {
  const ScratchDirectory in;
  REQUIRE(
      run_in(in, {"generate", "sphere", "--points", "1000", "-o", "c.ply", "--truth", "ball.ply"})
          .status == 0);
  write_text(in / "sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n");
  const auto simplified = [&](const char* mesh, std::vector<std::string> limit) {
    std::vector<std::string> all = {"simplify", mesh, "-o", "small.ply"};
    all.insert(all.end(), limit.begin(), limit.end());
    const ProgramResult result = run_in(in, all);
    REQUIRE(result.status == 0);
    return std::pair(read_mesh(in / "small.ply").triangles.size(), result.err);
  };
  for (const std::vector<std::string>& limit : std::vector<std::vector<std::string>>{
           {"--ratio", "1e-6"}, {"--triangles", "1"}, {"--triangles", "3"}, {"--error", "1e6"}}) {
    const auto [triangles, told] = simplified("ball.ply", limit);
    CHECK(triangles == 4);
    CHECK((limit[0] != "--error") == (told.find("cannot be simplified to") != told.npos));
  }
  CHECK(simplified("sheet.obj", {"--triangles", "1"}).first == 1);
  CHECK(simplified("sheet.obj", {"--error", "1e6"}).first == 1);
  // Some triangles are there from behind, too.
  TriangleMesh twins = read_mesh(in / "ball.ply");
  for (std::size_t i = 0; i < 30; ++i) {
    const Triangle t = twins.triangles[i];
    twins.triangles.push_back({t[0], t[2], t[1]});
  }
  write_mesh(in / "twins.ply", twins);
  for (const char* limit : {"--triangles", "--error"}) {
    const std::size_t left = simplified("twins.ply", {limit, limit[2] == 't' ? "1" : "1e6"}).first;
    CHECK(left > 0);
    CHECK(left < 100);
  }
}

TEST_CASE("SimplifiedFacesKeepTheHolesThatTheyFill") {
  const ScratchDirectory in;
  TriangleMesh mesh = torus_mesh(3000);
  const auto middle_of = [](const TriangleMesh& of, const Triangle& t) {
    const std::vector<Vec3>& at = of.vertices.positions;
    return (1.0 / 3.0) * (at[t[0]] + at[t[1]] + at[t[2]]);
  };
  const double spacing = norm(mesh.vertices.positions[mesh.triangles[0][0]] -
                              mesh.vertices.positions[mesh.triangles[0][1]]);
  const double edge = 0.5 * mesh.vertices.bounds().max.x;
  for (const Triangle& t : mesh.triangles) mesh.hole.push_back(middle_of(mesh, t).x > edge ? 7 : 0);
  MeshWriterOptions options;
  options.has_confidence = true;
  options.confidence = std::vector<float>(7, 0.25F);
  write_mesh(in / "mesh.ply", mesh, options);
  REQUIRE(run_in(in, {"simplify", "mesh.ply", "-o", "small.ply", "--ratio", "0.3",
                      "--leaf-triangles", "400"})
              .status == 0);
  const TriangleMesh small = read_mesh(in / "small.ply");
  const std::vector<float> confidence = face_confidence(in / "small.ply");
  REQUIRE(small.hole.size() == small.triangles.size());
  REQUIRE(confidence.size() == small.triangles.size());
  CHECK(std::ranges::count(small.hole, 7) > 20);
  for (std::size_t t = 0; t < small.triangles.size(); ++t) {
    const double beyond = middle_of(small, small.triangles[t]).x - edge;
    if (std::abs(beyond) > 4.0 * spacing) CHECK(small.hole[t] == (beyond > 0.0 ? 7 : 0));
    CHECK(confidence[t] == (small.hole[t] == 7 ? 0.25F : 1.0F));
  }
  const ProgramResult as_obj =
      run_in(in, {"simplify", "mesh.ply", "-o", "small.obj", "--ratio", "0.3"});
  CHECK_THAT(as_obj.out, Contains("hole (of faces)") && Contains("confidence (of faces)"));
}

TEST_CASE("SimplifyRefusesWhatItCannotDo") {
  const ScratchDirectory in;
  write_mesh(in / "mesh.ply", torus_mesh(500));
  struct Refused {
    std::vector<std::string> arguments;
    std::string said;
  };
  const std::vector<Refused> all = {{{}, "--ratio 0.1"},
                                    {{"--ratio", "0"}, "above 0 and at most 1"},
                                    {{"--ratio", "1.5"}, "above 0 and at most 1"},
                                    {{"--ratio", "few"}, "--ratio"},
                                    {{"--triangles", "0"}, "at least 1"},
                                    {{"--triangles", "2.5"}, "an integer"},
                                    {{"--error", "-1"}, "positive"},
                                    {{"--error", "nan"}, "positive"},
                                    {{"--ratio", "0.5", "--error", "1"}, "more than one limit"}};
  for (const Refused& refused : all) {
    std::vector<std::string> arguments = {"simplify", "mesh.ply", "-o", "small.ply"};
    arguments.insert(arguments.end(), refused.arguments.begin(), refused.arguments.end());
    const ProgramResult result = run_in(in, arguments);
    CHECK(result.status == 2);
    CHECK_THAT(result.err, Contains(refused.said));
  }
  const auto status = [&](const std::vector<std::string>& arguments) {
    return run_in(in, arguments).status;
  };
  CHECK(status({"simplify", "mesh.ply", "-o", "mesh.ply", "--ratio", "0.5"}) == 2);
  CHECK(status({"simplify", "mesh.ply", "-o", "-", "--ratio", "0.5"}) == 2);
  CHECK(status({"simplify", "mesh.ply", "-o", "small.xyz", "--ratio", "0.5"}) == 2);
  CHECK(status({"simplify", "absent.ply", "-o", "small.ply", "--ratio", "0.5"}) == 3);
  CHECK(status({"simplify", "mesh.ply", "-o", "small.ply", "--ratio", "0.5", "--memory",
                "64MiB"}) == 4);
  CHECK(names_in(in) == std::vector<std::string>{"mesh.ply"});
}

TEST_CASE("SimplifiedMeshOfAJobHasTheBytesOfTheCommand") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "bumpy-torus", "--points", "3000", "-o", "scan.ply"}).status ==
          0);
  write_text(in / "job.toml",
             "[input]\nfiles = [\"scan.ply\"]\n[output]\nmesh = \"mesh.ply\"\n"
             "simplify = {ratio = 0.25}\nsimplified = \"small.ply\"\n");
  const ProgramResult made = run_in(in, {"run", "job.toml"});
  INFO(made.err);
  REQUIRE(made.status == 0);
  CHECK_THAT(made.out, Contains("small.ply"));
  REQUIRE(run_in(in, {"simplify", "mesh.ply", "-o", "own.ply", "--ratio", "0.25"}).status == 0);
  CHECK((file_text(in / "small.ply") == file_text(in / "own.ply")));
  REQUIRE(run_in(in, {"reconstruct", "scan.ply", "-o", "other.ply", "--simplify", "ratio=0.25",
                      "--chunk-points", "400"})
              .status == 0);
  CHECK((file_text(in / "small.ply") == file_text(in / "other.simplified.ply")));
}

TEST_CASE("AMeshThatCannotBeSimplifiedIsNamed") {
  const ScratchDirectory in;
  write_text(in / "a.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
             "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
             "end_header\n0 0 0\n1 0 0\n0 1 0\nnan 1 0\n3 0 1 2\n3 2 1 3\n");
  const std::string problem = "a.ply: a triangle has a coordinate that is not finite";
  CHECK_THAT(run_in(in, {"simplify", "a.ply", "-o", "b.ply", "--ratio", "0.5"}).err,
             Contains(problem));
  CHECK_THAT(run_in(in, {"tileset", "a.ply", "-o", "tiles"}).err, Contains(problem));
}

TEST_CASE("AMeshThatCannotBeComputedWithIsNeitherSimplifiedNorTiled") {
  const ScratchDirectory in;
  for (const auto& [scale, said] :
       {std::pair(1e80,
                  "in.ply: the mesh is too large to be computed with; found a coordinate of "),
        std::pair(1e-80,
                  "in.ply: the mesh is too small to be computed with; found an extent of ")}) {
    INFO(scale);
    write_mesh(in / "in.ply",
               moved(torus_mesh(500), [factor = scale](Vec3 p) { return factor * p; }));
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"simplify", "in.ply", "-o", "out.ply", "--ratio", "0.5"},
          std::vector<std::string>{"tileset", "in.ply", "-o", "tiles"}}) {
      const ProgramResult refused = run_in(in, arguments);
      CHECK(refused.status == 3);
      CHECK_THAT(refused.err, Contains(said));
    }
  }
  CHECK(names_in(in) == std::vector<std::string>{"in.ply"});
}

TEST_CASE("SimplifiedMeshesOfAJobThatCannotBeMadeAreRefusedBeforeTheWork") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "500", "-o", "scan.ply"}).status == 0);
  struct Refused {
    std::vector<std::string> arguments;
    std::string said;
  };
  const std::vector<Refused> all = {
      {{"-o", "mesh.stl", "--simplify", "ratio=0.5"}, ".ply"},
      {{"-o", "mesh.ply", "--simplify", "ratio=2"}, "--simplify"},
      {{"-o", "mesh.ply", "--simplified", "small.ply"}, "--simplify ratio=0.1"},
      {{"-o", "mesh.ply", "--simplify", "ratio=0.5", "--simplified", "a.las"}, ".ply"},
      {{"-o", "mesh.ply", "--simplify", "ratio=0.5", "--simplified", "mesh.ply"}, "mesh.ply"},
      {{"-o", "mesh.ply", "--simplify", "ratio=0.5", "--memory", "100MiB"}, "at least 168"}};
  for (const Refused& refused : all) {
    std::vector<std::string> arguments = {"reconstruct", "scan.ply"};
    arguments.insert(arguments.end(), refused.arguments.begin(), refused.arguments.end());
    const ProgramResult result = run_in(in, arguments);
    CHECK(result.status == 2);
    CHECK_THAT(result.err, Contains(refused.said));
  }
  CHECK(names_in(in) == std::vector<std::string>{"scan.ply"});
}
