// The page that shows a mesh: what is in it, and what a browser makes of it.
#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "io/meshes/mesh_writer.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

/// With two holes.
TriangleMesh holed_sphere() {
  TriangleMesh mesh = sphere_mesh(4);
  cut(mesh, [](Vec3 p) { return p.z > 0.9 || p.x > 0.95; });
  return mesh;
}

std::string output_of(const std::string& command) {
  std::string output;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  std::array<char, 4096> buffer{};
  while (pipe && std::fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr)
    output += buffer.data();
  return output;
}

}  // namespace

TEST_CASE("ViewPageHoldsTheMeshAndAsksForNothingElse") {
  const ScratchDirectory in;
  write_mesh(in / "a mesh <b>.ply", holed_sphere());
  std::ofstream(in / "report.json") << R"({"words": "</script> & <b>"})";
  const ProgramResult made =
      run_in(in, {"view", "a mesh <b>.ply", "-o", "page.html", "--report", "report.json"});
  REQUIRE(made.status == 0);
  CHECK_THAT(made.out, Contains("page.html") && Contains("2 loops"));
  const std::string page = file_text(in / "page.html");
  for (const char* word : {"src=", "href=", "http:", "https:", "import ", "fetch("})
    CHECK(page.find(word) == std::string::npos);
  CHECK_THAT(page, Contains("a mesh \\u003cb>.ply") && Contains("\\u003c/script> & \\u003cb>"));
  REQUIRE(run_in(in, {"view", "a mesh <b>.ply", "-o", "again.html", "--report", "report.json"})
              .status == 0);
  CHECK(file_text(in / "again.html") == page);
}

TEST_CASE("ViewRefusesWhatIsNoMeshAndWhatIsNoReport") {
  const ScratchDirectory in;
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}};
  write_cloud(in / "cloud.ply", cloud);
  const ProgramResult no_mesh = run_in(in, {"view", "cloud.ply", "-o", "page.html"});
  CHECK(no_mesh.status == 3);
  CHECK_THAT(no_mesh.err, Contains("no faces"));
  write_mesh(in / "mesh.ply", holed_sphere());
  const ProgramResult no_report =
      run_in(in, {"view", "mesh.ply", "-o", "page.html", "--report", "cloud.ply"});
  CHECK(no_report.status == 3);
  CHECK_THAT(no_report.err, Contains("cloud.ply") && Contains("JSON"));
  CHECK(run_in(in, {"view", "mesh.ply", "-o", "mesh.ply"}).status == 2);
  CHECK_FALSE(std::filesystem::exists(in / "page.html"));
}

TEST_CASE("ViewOverwritesNoScanWhoseNameStandsForAPage") {
  const ScratchDirectory in;
  write_mesh(in / "mesh.ply", holed_sphere());
  test::write_text(in / "scan.las", "mine");
  const ProgramResult refused = run_in(in, {"view", "mesh.ply", "-o", "scan.las"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("scan.las") && Contains(".html"));
  CHECK(file_text(in / "scan.las") == "mine");
}

TEST_CASE("BrowserDrawsThePageAndFindsItsHoles", "[slow]") {
  if (output_of("command -v chromium").empty()) {
    std::cout << "SKIPPED: chromium\n";
    return;
  }
  const ScratchDirectory in;
  write_mesh(in / "mesh.ply", holed_sphere());
  REQUIRE(run_in(in, {"view", "mesh.ply", "-o", "page.html"}).status == 0);
  const std::string page = output_of(
      "chromium --headless --no-sandbox --disable-gpu-sandbox --use-angle=swiftshader "
      "--enable-unsafe-swiftshader --user-data-dir=" +
      (in / "profile").string() + " --virtual-time-budget=5000 --dump-dom file://" +
      (in / "page.html").string() + " 2> /dev/null");
  CHECK_THAT(page, Contains("data-frames=\"1\"") || Contains("data-frames=\"2\""));
  CHECK_THAT(page, Contains("data-holes=\"2\""));
  CHECK_THAT(page, Contains("2 open, 0 filled"));
}
