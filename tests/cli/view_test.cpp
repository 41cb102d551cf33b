// The page that shows a mesh: what is in it, and what a browser makes of it.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <png.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/view/web_request.h"
#include "io/meshes/mesh_reader.h"
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

/// How chromium is called; `in`: where its profile lies.
std::string browser(const ScratchDirectory& in) {
  return "chromium --headless --no-sandbox --disable-gpu-sandbox --use-angle=swiftshader "
         "--enable-unsafe-swiftshader --user-data-dir=" +
         (in / "profile").string() + " ";
}

bool has_browser() {
  if (!output_of("command -v chromium").empty()) return true;
  std::cout << "SKIPPED: chromium\n";
  return false;
}

/// What a picture of the page shows left of the panel, in pixels.
struct SeenColors {
  int patch = 0;   ///< blue
  int unsure = 0;  ///< orange
  int plain = 0;
  int all = 0;  ///< but for the background
};

/// Red, green and blue of a picture left of the panel, and below the button.
std::vector<std::array<std::uint8_t, 3>> pixels_of(const std::filesystem::path& file) {
  constexpr unsigned kPanel = 270, kButton = 60;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&image, file.c_str()) != 0);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(image));
  REQUIRE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr) != 0);
  std::vector<std::array<std::uint8_t, 3>> pixels;
  for (unsigned y = kButton; y < image.height; ++y)
    for (unsigned x = 0; x + kPanel < image.width; ++x) {
      const std::uint8_t* const pixel = bytes.data() + 3 * (std::size_t{y} * image.width + x);
      pixels.push_back({pixel[0], pixel[1], pixel[2]});
    }
  return pixels;
}

SeenColors colors_of(const std::filesystem::path& file) {
  SeenColors seen;
  for (const auto& pixel : pixels_of(file)) {
    const int red = pixel[0], green = pixel[1], blue = pixel[2];
    if (red > 238 && green > 238 && blue > 235) continue;
    ++seen.all;
    if (blue > red + 20) ++seen.patch;
    if (red > 2 * blue && green > blue + 20) ++seen.unsure;
    if (red >= green && green >= blue && 3 * blue > 2 * red) ++seen.plain;
  }
  return seen;
}

SeenColors shown_colors(const ScratchDirectory& in, const std::string& address) {
  const std::filesystem::path picture = in / "page.png";
  std::filesystem::remove(picture);
  output_of(browser(in) + "--window-size=900,700 --virtual-time-budget=15000 --screenshot=" +
            picture.string() + " '" + address + "' 2> /dev/null");
  return colors_of(picture);
}

/// With two patches, of which the second is not to be relied on, and a small sphere beside it.
void write_patched_spheres(const std::filesystem::path& file) {
  const TriangleMesh small = moved(sphere_mesh(2), [](Vec3 p) {
    return 0.2 * p + Vec3{0.0, 1.4, 0.0};
  });
  TriangleMesh mesh = joined(sphere_mesh(4), small);
  const auto hole_of = [&](const Triangle& t) {
    const std::vector<Vec3>& at = mesh.vertices.positions;
    const Vec3 middle = (1.0 / 3.0) * (at[t[0]] + at[t[1]] + at[t[2]]);
    if (middle.y > 1.1) return 0;
    return middle.z > 0.8 ? 1 : middle.z < -0.8 ? 2 : 0;
  };
  std::ranges::stable_sort(mesh.triangles, {}, hole_of);
  for (const Triangle& t : mesh.triangles) mesh.hole.push_back(hole_of(t));
  MeshWriterOptions options;
  options.has_confidence = true;
  options.confidence = {1.0F, 0.0F};
  write_mesh(file, mesh, options);
}

/// What both viewers show of the spheres at an address without its fragment.
void check_patches_are_shown(const ScratchDirectory& in, const std::string& address) {
  const SeenColors plain = shown_colors(in, address + "#colors=plain");
  CHECK(plain.all > 10'000);
  CHECK(plain.plain > plain.all * 9 / 10);
  CHECK((plain.patch == 0 && plain.unsure == 0));
  const SeenColors patches = shown_colors(in, address + "#colors=patches");
  CHECK(patches.all == plain.all);
  CHECK(patches.patch > 500);
  CHECK(patches.unsure == 0);
  // The list has the patches one after the other; a click on the second one turns to it.
  const SeenColors sure = shown_colors(in, address + "#colors=confidence&hole=1");
  const SeenColors unsure = shown_colors(in, address + "#colors=confidence&hole=2");
  CHECK(std::max(sure.patch, unsure.patch) > 10'000);
  CHECK(std::max(sure.unsure, unsure.unsure) > 10'000);
  const SeenColors cut = shown_colors(in, address + "#colors=patches&axis=2&cut=400&cull=1");
  CHECK(cut.patch == 0);
  CHECK(cut.all < plain.all);
  CHECK(cut.all > 1'000);
  const SeenColors components = shown_colors(in, address + "#colors=components");
  CHECK(components.plain < components.all / 10);
}

/// The program serves a folder while this lives.
class ServedFolder {
 public:
  ServedFolder(const ScratchDirectory& in, const std::vector<std::string>& arguments)
      : said_(in / "said") {
    write_text(said_, "");
    program_ = std::make_unique<RunningProgram>(
        arguments, ProgramSetting{.directory = in.path(), .out_to = said_});
    const std::string before = "http://127.0.0.1:";
    while (program_->running()) {
      const std::string said = file_text(said_);
      const std::size_t at = said.find(before), end = said.find('/', at + before.size());
      if (at != std::string::npos && end != std::string::npos) {
        port_ = static_cast<std::uint16_t>(std::stoi(said.substr(at + before.size())));
        return;
      }
      ::usleep(10'000);
    }
    FAIL("ended before it served: " << program_->wait().err);
  }

  std::uint16_t port() const { return port_; }
  RunningProgram& program() { return *program_; }
  /// All that comes until the connection ends.
  std::string answer(const std::string& request) const {
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port_);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    const std::string text = request + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    REQUIRE(::send(socket, text.data(), text.size(), MSG_NOSIGNAL) ==
            static_cast<ssize_t>(text.size()));
    std::string all;
    std::array<char, 4096> buffer{};
    for (ssize_t got = 0; (got = ::recv(socket, buffer.data(), buffer.size(), 0)) > 0;)
      all.append(buffer.data(), static_cast<std::size_t>(got));
    ::close(socket);
    return all;
  }

 private:
  std::filesystem::path said_;
  std::unique_ptr<RunningProgram> program_;
  std::uint16_t port_ = 0;
};

std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}

/// To a request for a file "a.glb" of ten bytes, the only one.
WebAnswer answered(const std::string& line, const std::string& fields = "") {
  return answer_request(line + " HTTP/1.1\r\nHost: 127.0.0.1:8080\r\n" + fields + "\r\n",
                        [](const std::string& name) -> std::optional<std::uint64_t> {
                          if (name != "a.glb") return std::nullopt;
                          return 10;
                        });
}

bool has_status(const WebAnswer& answer, const std::string& status) {
  return answer.head.starts_with("HTTP/1.1 " + status + " ");
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

TEST_CASE("ViewPageIsFittedToTheSurface") {
  const ScratchDirectory in;
  write_text(
      in / "a.obj",
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nv 1e6 1e6 1e6\n");
  REQUIRE(run_in(in, {"view", "a.obj", "-o", "page.html"}).status == 0);
  CHECK_THAT(file_text(in / "page.html"), Contains("\"extent\":[1.0,1.0,1.0]"));
  // A corner that is nowhere is no reason for a surface that reaches to infinity.
  write_text(in / "b.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
             "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
             "end_header\n0 0 0\n1 0 0\n0 1 0\ninf 1 0\n3 0 1 2\n3 2 1 3\n");
  REQUIRE(run_in(in, {"view", "b.ply", "-o", "page.html"}).status == 0);
  CHECK_THAT(file_text(in / "page.html"), Contains("\"extent\":[1.0,1.0,0.0]"));
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
  std::ofstream(in / "deep.json") << std::string(200'000, '[') << std::string(200'000, ']');
  const ProgramResult deep =
      run_in(in, {"view", "mesh.ply", "-o", "page.html", "--report", "deep.json"});
  CHECK(deep.status == 3);
  CHECK_THAT(deep.err, Contains("deep.json: the report is nested too deeply"));
  const ProgramResult absent =
      run_in(in, {"view", "mesh.ply", "-o", "page.html", "--report", "absent.json"});
  CHECK(absent.status == 3);
  CHECK_THAT(absent.err, Contains("absent.json: no such file"));
  std::filesystem::create_directory(in / "tiles");
  const ProgramResult folder = run_in(in, {"view", "tiles", "-o", "page.html"});
  CHECK(folder.status == 2);
  CHECK_THAT(folder.err, Contains("a page is made of a mesh") && Contains("--folder DIR"));
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

TEST_CASE("WebRequestGetsTheBytesOfItsRange") {
  struct Asked {
    const char* range;
    const char* status;
    std::uint64_t first, bytes;
  };
  const Asked asked =
      GENERATE(Asked{"0-3", "206", 0, 4}, Asked{"7-", "206", 7, 3}, Asked{"8-99", "206", 8, 2},
               Asked{"-4", "206", 6, 4}, Asked{"-99", "206", 0, 10}, Asked{"9-9", "206", 9, 1},
               Asked{"10-", "416", 0, 0}, Asked{"-0", "416", 0, 0}, Asked{"5-2", "200", 0, 10},
               Asked{"0-1,4-5", "200", 0, 10}, Asked{"x", "200", 0, 10},
               Asked{"3-18446744073709551615", "206", 3, 7});
  INFO(asked.range);
  const WebAnswer answer =
      answered("GET /a.glb", "range: bytes=" + std::string(asked.range) + "\r\n");
  CHECK(has_status(answer, asked.status));
  CHECK(answer.first == asked.first);
  CHECK(answer.bytes == asked.bytes);
}

TEST_CASE("WebRequestIsRefusedUnlessItIsForAFileOfThisMachine") {
  for (const char* target : {"/b.glb", "/../a.glb", "/./a.glb", "//a.glb", "/x/a.glb", "/%61.glb",
                             "/.hidden", "a.glb", "/"}) {
    INFO(target);
    CHECK(has_status(answered("GET " + std::string(target)), "404"));
  }
  CHECK(has_status(answered("GET /a.glb?error=1"), "200"));
  CHECK(has_status(answered("POST /a.glb"), "405"));
  CHECK(has_status(answered("GET"), "400"));
  const auto none = [](const std::string&) { return std::optional<std::uint64_t>(1); };
  for (const char* host : {"evil.example", "127.0.0.1.evil.example", "localhost.evil.example", ""})
    CHECK(has_status(
        answer_request("GET /a.glb HTTP/1.1\r\nHost: " + std::string(host) + "\r\n\r\n", none),
        "403"));
  const WebAnswer head = answered("HEAD /a.glb");
  CHECK_THAT(head.head, Contains("Content-Length: 10\r\n"));
  CHECK((head.file.empty() && head.text.empty()));
}

TEST_CASE("ViewFolderHoldsTilesAndViewerAndIsServedUntilAnInterrupt") {
  const ScratchDirectory in;
  write_mesh(in / "mesh.ply", holed_sphere());
  write_text(in / "report.json", R"({"a": 1})");
  write_text(in / "secret.txt", "secret");
  ServedFolder served(
      in, {"view", "mesh.ply", "--folder", "v", "--report", "report.json", "--serve=0"});
  std::filesystem::create_symlink(in / "secret.txt", in / "v" / "secret.txt");
  for (const char* name :
       {"index.html", "viewer.js", "tileset.json", "000000.glb", "report.json"}) {
    INFO(name);
    const std::string answer = served.answer("GET /" + std::string(name));
    CHECK(answer.starts_with("HTTP/1.1 200 OK\r\n"));
    CHECK((body_of(answer) == file_text(in / "v" / name)));
  }
  CHECK((body_of(served.answer("GET /")) == file_text(in / "v" / "index.html")));
  CHECK(body_of(served.answer("HEAD /000000.glb")).empty());
  for (const char* name : {"secret.txt", "../secret.txt", "absent"})
    CHECK(served.answer("GET /" + std::string(name)).starts_with("HTTP/1.1 404 "));
  const ProgramResult taken = run_in(in, {"view", "v", "--serve=" + std::to_string(served.port())});
  CHECK(taken.status == 4);
  CHECK_THAT(taken.err, Contains("127.0.0.1:" + std::to_string(served.port())));
  served.program().send(SIGINT);
  CHECK(served.program().wait().status == 130);
  CHECK_FALSE(std::filesystem::exists(in / "v.work"));
}

TEST_CASE("ViewFolderOfATilesetHasItsTilesAndLeavesEverythingElseAlone") {
  const ScratchDirectory in;
  write_mesh(in / "mesh.ply", holed_sphere());
  REQUIRE(run_in(in, {"tileset", "mesh.ply", "-o", "tiles"}).status == 0);
  REQUIRE(run_in(in, {"view", "tiles", "--folder", "a"}).status == 0);
  REQUIRE(run_in(in, {"view", "tiles/tileset.json", "--folder", "b"}).status == 0);
  REQUIRE(run_in(in, {"view", "mesh.ply", "--folder", "b"}).status == 0);
  for (const char* name : {"tileset.json", "000000.glb", "viewer.js"}) {
    CHECK((file_text(in / "a" / name) == file_text(in / "b" / name)));
    CHECK(file_text(in / "a" / name).size() > 300);
  }
  CHECK(run_in(in, {"view", "tiles", "--folder", "tiles"}).status == 2);
  write_text(in / "a" / "notes.txt", "mine");
  const ProgramResult refused = run_in(in, {"view", "tiles", "--folder", "a"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("notes.txt"));
  CHECK(file_text(in / "a" / "notes.txt") == "mine");
  write_text(in / "tiles" / "000000.glb", "damaged");
  const ProgramResult damaged = run_in(in, {"view", "tiles", "--folder", "c"});
  CHECK(damaged.status == 3);
  CHECK_THAT(damaged.err, Contains("000000.glb"));
  CHECK_FALSE(std::filesystem::exists(in / "c"));
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"view", "mesh.ply"},
        {"view", "tiles", "--serve=0"},
        {"view", "mesh.ply", "-o", "m.html", "--folder", "d"},
        {"view", "b", "--serve=65536"},
        {"view", "tiles", "--folder", "d", "--tileset-compression", "meshopt"},
        {"view", "mesh.ply", "-o", "m.html", "--tileset-compression", "meshopt"}})
    CHECK(run_in(in, wrong).status == 2);
}

TEST_CASE("BrowserDrawsTheTilesOfAServedFolder", "[slow]") {
  if (output_of("command -v chromium").empty()) {
    std::cout << "SKIPPED: chromium\n";
    return;
  }
  const ScratchDirectory in;
  write_mesh(in / "mesh.ply", holed_sphere());
  REQUIRE(run_in(in, {"tileset", "mesh.ply", "-o", "tiles", "--leaf-triangles", "500"}).status ==
          0);
  const ServedFolder served(in, {"view", "tiles", "--folder", "v", "--serve=0"});
  const std::string page = output_of(
      "chromium --headless --no-sandbox --disable-gpu-sandbox --use-angle=swiftshader "
      "--enable-unsafe-swiftshader --user-data-dir=" +
      (in / "profile").string() + " --virtual-time-budget=20000 --dump-dom http://127.0.0.1:" +
      std::to_string(served.port()) + "/ 2> /dev/null");
  CHECK_THAT(page, Contains("data-drawn=\"") && Contains("data-holes=\"2\""));
  CHECK_THAT(page, !Contains("data-trouble"));
  CHECK_THAT(page, Contains("2 open in the coarsest level"));
}

TEST_CASE("BrowserColorsByTheConfidenceOfPointsInPagesAndTiles", "[slow]") {
  if (!has_browser()) return;
  const ScratchDirectory in;
  TriangleMesh mesh = sphere_mesh(4);
  mesh.vertices.schema.attributes = {{"confidence", ScalarType::kUint8}};
  for (const Vec3& p : mesh.vertices.positions)
    mesh.vertices.attributes.push_back(std::byte{p.z > 0.0});
  write_mesh(in / "mesh.ply", mesh);
  REQUIRE(run_in(in, {"view", "mesh.ply", "-o", "page.html"}).status == 0);
  const ServedFolder served(in, {"view", "mesh.ply", "--folder", "v", "--serve=0"});
  for (const std::string& address : {"file://" + (in / "page.html").string(),
                                     "http://127.0.0.1:" + std::to_string(served.port()) + "/"}) {
    INFO(address);
    const SeenColors seen = shown_colors(in, address + "#colors=vertex_confidence");
    CHECK(seen.patch > 5'000);
    CHECK(seen.unsure > 5'000);
    CHECK(seen.plain < seen.all / 10);
  }
}

TEST_CASE("BrowserShowsCompressedTilesAsTilesWithoutCompression", "[slow]") {
  if (!has_browser()) return;
  const ScratchDirectory in;
  write_patched_spheres(in / "mesh.ply");
  const auto picture_of = [&](const std::string& compression) {
    const ServedFolder served(in, {"view", "mesh.ply", "--folder", compression, "--serve=0",
                                   "--tileset-compression", compression});
    CHECK(shown_colors(in, "http://127.0.0.1:" + std::to_string(served.port()) + "/#colors=patches")
              .patch > 500);
    return pixels_of(in / "page.png");
  };
  CHECK((picture_of("meshopt") == picture_of("none")));
  CHECK(std::filesystem::file_size(in / "meshopt" / "000000.glb") <
        std::filesystem::file_size(in / "none" / "000000.glb"));
}

TEST_CASE("BrowserShowsPatchesConfidenceSectionsAndComponentsOfAPage", "[slow]") {
  if (!has_browser()) return;
  const ScratchDirectory in;
  write_patched_spheres(in / "mesh.ply");
  REQUIRE(run_in(in, {"view", "mesh.ply", "-o", "page.html"}).status == 0);
  check_patches_are_shown(in, "file://" + (in / "page.html").string());
}

TEST_CASE("BrowserShowsPatchesConfidenceSectionsAndComponentsOfTiles", "[slow]") {
  if (!has_browser()) return;
  const ScratchDirectory in;
  write_patched_spheres(in / "mesh.ply");
  REQUIRE(run_in(in, {"tileset", "mesh.ply", "-o", "tiles", "--leaf-triangles", "500"}).status ==
          0);
  const ServedFolder served(in, {"view", "tiles", "--folder", "v", "--serve=0"});
  const std::string address = "http://127.0.0.1:" + std::to_string(served.port()) + "/";
  // The coarsest tile alone, so that no picture depends on what is loaded by then.
  check_patches_are_shown(in, address + "?error=1000");
  const std::string page = output_of(browser(in) + "--virtual-time-budget=20000 --dump-dom " +
                                     address + " 2> /dev/null");
  // Vertices that tiles have twice at rims of patches open no loop.
  CHECK_THAT(page, Contains("data-holes=\"0\"") && Contains("data-filled=\"2\""));
  CHECK_THAT(page, Contains("confidence 1.00") && Contains("confidence 0.00"));
  CHECK_THAT(page, Contains("2 components") && !Contains("data-trouble"));
}

TEST_CASE("ViewersOfOthersLoadEveryTileOfATileset", "[slow]") {
  const std::string viewer = GENERATE("cesium", "3d-tiles-renderer");
  const std::string compression = GENERATE("none", "meshopt");
  if (output_of("command -v node").empty()) {
    std::cout << "SKIPPED: node\n";
    return;
  }
  const ScratchDirectory in;
  write_patched_spheres(in / "mesh.ply");
  REQUIRE(run_in(in, {"tileset", "mesh.ply", "-o", "tiles", "--leaf-triangles", "500",
                      "--tileset-compression", compression})
              .status == 0);
  const std::string told =
      output_of("node " + source_path("bench/quality/load_tileset.js").string() + " --in " +
                viewer + " " + (in / "tiles").string() + " 2>&1");
  if (told.starts_with("SKIPPED: ")) {
    std::cout << told;
    return;
  }
  INFO(told);
  const auto facts = nlohmann::json::parse(told);
  CHECK(facts["tiles"] > 10);
  CHECK(facts["loaded"] == facts["tiles"]);
  CHECK(facts["errors"].empty());
  CHECK(facts["triangles"] == read_mesh((in / "mesh.ply").string()).triangles.size());
}

TEST_CASE("FramesOfAFolderAreCountedWhileItTurns", "[slow]") {
  if (!has_browser()) return;
  if (output_of("command -v node").empty()) {
    std::cout << "SKIPPED: node\n";
    return;
  }
  const ScratchDirectory in;
  write_patched_spheres(in / "mesh.ply");
  REQUIRE(run_in(in, {"view", "mesh.ply", "--folder", "v"}).status == 0);
  const std::string told = output_of(
      "node " + source_path("bench/quality/view_frames.js").string() +
      " --load 1 --hash 'colors=patches&axis=0&cut=400' " + (in / "v").string() + " 2>&1");
  INFO(told);
  const auto facts = nlohmann::json::parse(told);
  CHECK(facts["frames_per_second"] > 0.0);
  CHECK(facts["tiles"] > 0);
  CHECK(facts["triangles"] > 0);
  CHECK(facts["first_bytes"] <= facts["bytes"]);
  CHECK(facts["trouble"].is_null());
}

TEST_CASE("ReportOfASmallMeshHoldsItsViewer") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "3000", "-o", "cloud.ply"}).status == 0);
  const auto page_of = [&](const char* mesh, const char* report) {
    REQUIRE(run_in(in, {"reconstruct", "cloud.ply", "-o", mesh, "--report", report}).status == 0);
    return file_text(std::filesystem::path(in / report).replace_extension(".html"));
  };
  const std::string page = page_of("mesh.ply", "mesh.json");
  REQUIRE(run_in(in, {"view", "mesh.ply", "-o", "view.html"}).status == 0);
  const std::string view = file_text(in / "view.html");
  const std::size_t data = view.find("<script id=\"data\"");
  REQUIRE(data != std::string::npos);
  // The same triangles as in the viewer's own page.
  const std::string coded = view.substr(view.find('>', data) + 1, 4000);
  CHECK_THAT(page, Contains("srcdoc=") && Contains(coded));
  // What is not read back has no viewer.
  CHECK_THAT(page_of("mesh.glb", "glb.json"), !Contains("srcdoc="));
}

TEST_CASE("BrowserDrawsTheViewerOfAReport", "[slow]") {
  if (!has_browser()) return;
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "3000", "-o", "cloud.ply"}).status == 0);
  REQUIRE(
      run_in(in, {"reconstruct", "cloud.ply", "-o", "mesh.ply", "--report", "mesh.json"}).status ==
      0);
  // The report's words around it are black on white.
  CHECK(shown_colors(in, "file://" + (in / "mesh.html").string()).plain > 10'000);
}
