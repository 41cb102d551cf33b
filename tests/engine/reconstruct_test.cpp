// The front door gives the bytes of the job.
#include "engine/reconstruct.h"

#include <catch2/catch.hpp>
#include <limits>
#include <thread>

#include "engine/run_job.h"
#include "engine/validation/mesh_facts.h"
#include "io/clouds/open_point_source.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/jobs.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

/// A job on a cloud with everything that the front door's options say.
Job same_job(const ScratchDirectory& scratch, const PointCloud& cloud,
             const ReconstructionOptions& options) {
  write_cloud(scratch / "cloud.ply", cloud);
  Job job;
  job.input.files = {(scratch / "cloud.ply").string()};
  job.input.keep_strays = options.keep_strays;
  job.normals = options.normals;
  job.reconstruct.ball_radii = options.ball_radii;
  job.reconstruct.levels = options.levels;
  job.fill = options.fill;
  job.output.mesh = (scratch / "job.ply").string();
  return job;
}

std::string bytes_of_mesh(const ScratchDirectory& scratch, const Reconstruction& result) {
  write_mesh(scratch / "door.ply", result.mesh);
  return bytes_of(scratch / "door.ply");
}

void check_holes(const std::vector<HoleFacts>& holes, const std::vector<HoleFacts>& expected) {
  REQUIRE(holes.size() == expected.size());
  for (std::size_t i = 0; i < holes.size(); ++i) {
    CHECK(holes[i].id == expected[i].id);
    CHECK(holes[i].first_vertex == expected[i].first_vertex);
    CHECK(holes[i].edges == expected[i].edges);
    CHECK(holes[i].perimeter == expected[i].perimeter);
    CHECK(holes[i].filled == expected[i].filled);
    CHECK(holes[i].method == expected[i].method);
    CHECK(holes[i].reason == expected[i].reason);
    CHECK(holes[i].triangles_added == expected[i].triangles_added);
  }
}

/// Mesh, holes, radii and dropped points are those of the job. `scanner`: of the job, where all
/// points were seen from.
void check_same_as_job(const PointCloud& cloud, const ReconstructionOptions& options = {},
                       const std::optional<Vec3>& scanner = {}) {
  ScratchDirectory scratch;
  Job job = same_job(scratch, cloud, options);
  if (scanner) job.input.scanner = ScannerPlace{*scanner, false};
  const RunReport report = run(job);
  const std::string expected = bytes_of(scratch / "job.ply");
  const Reconstruction result = reconstruct(cloud, options);
  CHECK(bytes_of_mesh(scratch, result) == expected);
  CHECK(result.ball_radii == report.radii);
  CHECK(result.dropped == report.points_dropped);
  check_holes(result.holes, report.holes);
}

PointCloud without_normals(PointCloud cloud) {
  cloud.normals.clear();
  cloud.schema.has_normals = false;
  return cloud;
}

/// What files of clouds hold: normals of 32 bits.
PointCloud with_float_normals(PointCloud cloud) {
  cloud.schema.normal_type = ScalarType::kFloat32;
  for (Vec3& n : cloud.normals)
    n = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
  return cloud;
}

PointCloud torus(std::size_t points, double noise) {
  PointCloud cloud = with_float_normals(painted_torus(points, noise, 5).cloud);
  shuffle(cloud, 17);
  return cloud;
}

/// Takes the points away that lie in a ball.
void cut_ball(PointCloud& cloud, Vec3 center, double radius) {
  PointCloud rest;
  rest.schema = cloud.schema;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (norm(cloud.positions[i] - center) > radius) rest.append(cloud, i);
  cloud = std::move(rest);
}

PointCloud holed_torus() {
  PointCloud cloud = torus(8000, 0.1);
  cut_ball(cloud, {1.4, 0.0, 0.0}, 0.25);
  cut_ball(cloud, {-1.0, 0.0, 0.4}, 0.12);
  return cloud;
}

}  // namespace

TEST_CASE("TheFrontDoorGivesTheBytesOfTheJob", "[costly]") {
  check_same_as_job(holed_torus());
  check_same_as_job(torus(3000, 0.4));
  check_same_as_job(torus(3000, 1.6));  // mended
  check_same_as_job(with_float_normals(random_sphere(3000, 3).cloud));
}

TEST_CASE("TheFrontDoorGivesTheBytesOfTheJobWithoutNormals", "[costly]") {
  check_same_as_job(without_normals(holed_torus()));
  check_same_as_job(without_normals(random_sphere(3000, 3).cloud));
  ReconstructionOptions options;
  options.normals.source = NormalSource::kEstimate;
  options.normals.neighbors = 24;
  check_same_as_job(torus(3000, 0.2), options);
  options.normals.viewpoint = Vec3{0.0, 0.0, 9.0};
  check_same_as_job(torus(3000, 0.2), options);
  options.normals.viewpoint.reset();
  options.normals.up = Vec3{0.0, 0.0, 1.0};
  check_same_as_job(torus(3000, 0.2), options);
  options.normals.orientation = Orientation::kNone;
  check_same_as_job(torus(3000, 0.2), options);
}

TEST_CASE("TheFrontDoorTurnsNormalsToTheScannersAsAJobDoes", "[costly]") {
  PointCloud cloud = without_normals(torus(3000, 0.2));
  cloud.append(cloud, 5);  // a duplicate
  const Vec3 place{0.5, 0.0, 9.0};
  const std::vector<Vec3> places(cloud.size(), place);
  ReconstructionOptions options;
  options.scanners = places;
  for (const Orientation rule : {Orientation::kAuto, Orientation::kScanner, Orientation::kGround}) {
    options.normals.orientation = rule;
    check_same_as_job(cloud, options, place);
  }
  options.normals.orientation = Orientation::kUp;
  check_same_as_job(cloud, options, place);
  // Normals that the cloud has stay as they are.
  const PointCloud oriented = torus(3000, 0.2);
  options.scanners = std::span(places).first(oriented.size());
  options.normals.orientation = Orientation::kScanner;
  check_same_as_job(oriented, options, place);
}

TEST_CASE("NormalsOfPointsInMemoryFaceTheScannerOfEachPoint") {
  // A sheet whose left half was seen from below and whose right half was seen from above.
  PointCloud cloud;
  std::vector<Vec3> scanners;
  for (int i = 0; i < 2500; ++i) {
    const Vec3 p{0.1 * (i % 50), 0.1 * (i / 50 + 0.01 * (i % 7)), 0.0};
    cloud.positions.push_back(p);
    scanners.push_back(p + Vec3{0.3, 0.2, p.x < 2.5 ? -4.0 : 4.0});
  }
  const auto facing = [&](const Reconstruction& result) {
    std::size_t right = 0;
    for (const Triangle& t : result.mesh.triangles) {
      const Vec3 a = result.mesh.vertices.positions[t[0]];
      const Vec3 b = result.mesh.vertices.positions[t[1]];
      const Vec3 c = result.mesh.vertices.positions[t[2]];
      right += (cross(b - a, c - a).z < 0.0) == (a.x + b.x + c.x < 7.5) ? 1 : 0;
    }
    return static_cast<double>(right) / static_cast<double>(result.mesh.triangles.size());
  };
  ReconstructionOptions options;
  options.fill.enabled = false;
  options.scanners = scanners;
  const Reconstruction result = reconstruct(cloud, options);
  CHECK(result.mesh.triangles.size() > 4000);
  CHECK(facing(result) == 1.0);
  CHECK(result.mesh.vertices.schema.attributes.empty());
  const Reconstruction of_spans = reconstruct(cloud.positions, {}, options);
  CHECK(of_spans.mesh.triangles == result.mesh.triangles);
  // A place that is not known leaves the side of all to the neighbours.
  scanners[7].x = std::numeric_limits<double>::quiet_NaN();
  CHECK(facing(reconstruct(cloud, options)) < 0.6);
  options.normals.orientation = Orientation::kScanner;
  CHECK_THROWS_WITH(reconstruct(cloud, options),
                    Contains("scanned from") && Contains("1 point without a scanner"));
  options.scanners = std::span(scanners).first(9);
  CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("9 places") && Contains("2500"));
}

TEST_CASE("ScanLinesFarApartBecomeOneSheetWithoutANumberGiven", "[costly]") {
  for (const double ratio : {6.0, 40.0}) {
    CAPTURE(ratio);
    const PointCloud lines = without_normals(sheet_of_lines(ratio, 20000)).cloud;
    check_same_as_job(lines);
    const Reconstruction sheet = reconstruct(lines, {});
    CHECK(static_cast<double>(sheet.mesh.vertices.size()) >
          0.99 * static_cast<double>(lines.size()));
    const std::size_t open =
        std::ranges::count_if(sheet.holes, [](const HoleFacts& hole) { return !hole.filled; });
    CHECK(open == 1);  // the border of the sheet
  }
}

TEST_CASE("TheFrontDoorTakesTheOptionsOfTheJob", "[costly]") {
  const PointCloud cloud = torus(4000, 0.5);
  ReconstructionOptions options;
  options.levels = 2;
  check_same_as_job(cloud, options);
  options.fill.enabled = false;
  check_same_as_job(cloud, options);
  options = {};
  options.ball_radii = {0.06, 0.09};
  options.fill.min_triangles = 30;
  check_same_as_job(cloud, options);
  options.fill.max_edges = 6;
  options.fill.kernel = FillKernel::kTriharmonic;
  check_same_as_job(cloud, options);
}

TEST_CASE("TheFrontDoorLeavesOutWhatTheJobLeavesOut", "[costly]") {
  PointCloud cloud = torus(4000, 0.1);
  cloud.append(cloud, 7);                                    // an exact duplicate
  for (int i = 0; i < 5; ++i) cloud.append(cloud, 100 + i);  // missing returns
  for (std::size_t i = cloud.size() - 4; i < cloud.size(); ++i) cloud.positions[i] = {};
  cloud.append(cloud, 11);
  cloud.positions.back() = {9e5, 0.0, 0.0};  // a stray
  cloud.append(cloud, 12);
  cloud.normals.back() = {};
  cloud.append(cloud, 13);
  cloud.positions.back().y = std::numeric_limits<double>::quiet_NaN();
  check_same_as_job(cloud);
  check_same_as_job(without_normals(cloud));
}

TEST_CASE("TheFrontDoorGivesTheBytesOfTheJobForTheBunny", "[slow]") {
  const auto file = data_path("stanford/bun_zipper.ply");
  if (skipped_without(file)) return;
  const PointCloud raw = without_normals(read_all(*open_point_source(file)));
  check_same_as_job(raw);
  PointCloud oriented = raw;
  for (const Vec3& p : raw.positions)
    oriented.normals.push_back(normalized(p - Vec3{-0.02, 0.09, 0.0}));
  oriented.schema.has_normals = true;
  check_same_as_job(with_float_normals(oriented));
}

TEST_CASE("SpansGiveTheSameMeshAsACloud", "[costly]") {
  PointCloud cloud = holed_torus();
  cloud.schema.attributes.clear();
  cloud.attributes.clear();
  cloud.schema.normal_type = ScalarType::kFloat64;
  ScratchDirectory scratch;
  for (const bool stray : {false, true}) {
    if (stray) {
      cloud.append(cloud, 0);
      cloud.positions.back() = {9e5, 0.0, 0.0};
    }
    const std::string expected = bytes_of_mesh(scratch, reconstruct(cloud));
    const Reconstruction result = reconstruct(cloud.positions, cloud.normals);
    CHECK(bytes_of_mesh(scratch, result) == expected);
    CHECK(result.dropped.size() == (stray ? 1 : 0));
    const std::string raw = bytes_of_mesh(scratch, reconstruct(without_normals(cloud)));
    CHECK(bytes_of_mesh(scratch, reconstruct(cloud.positions, {})) == raw);
  }
}

// What every build makes of these clouds: without optimisation, by another compiler, under
// sanitizers, and in the next version, unless the changelog says that meshes have other bytes.
TEST_CASE("KnownCloudsGiveTheMeshesTheyAlwaysGave") {
  const auto checksum_of = [](const PointCloud& cloud, bool fill) {
    ReconstructionOptions options;
    options.fill.enabled = fill;
    return mesh_facts(reconstruct(cloud, options).mesh).checksum;
  };
  const PointCloud cloud = torus(4000, 0.1);
  CHECK(checksum_of(cloud, false) == "664a3a68ee5fc18b");
  CHECK(checksum_of(without_normals(cloud), false) == "664a3a68ee5fc18b");
  CHECK(checksum_of(holed_torus(), true) == "826446dfbe60c243");
}

TEST_CASE("TheFrontDoorTellsItsStagesAndStopsInAnyOfThem") {
  const PointCloud cloud = without_normals(torus(2000, 0.1));
  std::vector<std::string> stages;
  ReconstructionOptions options;
  options.threads = 2;
  options.progress = [&](std::string_view stage, double done) {
    CHECK(done == Approx(static_cast<double>(stages.size()) / 6.0));
    stages.emplace_back(stage);
  };
  reconstruct(cloud, options);
  CHECK(stages ==
        std::vector<std::string>{"measure", "sort", "normals", "orient", "reconstruct", "fill"});
  for (const std::string& last : stages) {
    StopToken stop;
    options.stop = &stop;
    options.progress = [&](std::string_view stage, double) {
      if (stage == last) stop.request();
    };
    try {
      reconstruct(cloud, options);
      FAIL("was not stopped in " << last);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kInterrupted);
    }
  }
}

TEST_CASE("TheFrontDoorSaysWhatIsWrong") {
  ReconstructionOptions options;
  CHECK_THROWS_WITH(reconstruct(PointCloud{}), Contains("no usable point"));
  CHECK_THROWS_WITH(reconstruct(random_sphere(2, 1).cloud), Contains("no triangle"));
  const PointCloud cloud = torus(1000, 0.0);
  CHECK_THROWS_WITH(reconstruct(cloud.positions, std::span(cloud.normals).first(3)),
                    Contains("3 normals for "));
  options.levels = 9;
  CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("levels") && Contains("0 to 8"));
  options = {};
  options.normals.orientation = Orientation::kScanner;
  CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("scanned from"));
  options = {};
  options.ball_radii = {1e6};
  CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("too large"));
  options.ball_radii = {1e-6};
  CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("found ball radius 1e-06, at a point"));
  options.ball_radii = {1e-6, 2e-6};
  CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("found ball radii 1e-06 to 2e-06, at"));
  options = {};
  options.normals.source = NormalSource::kFile;
  CHECK_THROWS_WITH(reconstruct(without_normals(cloud), options), Contains("no normals"));
  for (const double scale : {1e-80, 1e-200}) {
    PointCloud tiny = cloud;
    for (Vec3& p : tiny.positions) p = scale * p;
    for (const PointCloud& one : {tiny, without_normals(tiny)})
      CHECK_THROWS_WITH(reconstruct(one), Contains("the cloud is too small to be computed with") &&
                                              Contains("expected an extent from 1e-75 to 1e75"));
  }
}

TEST_CASE("TheFrontDoorRefusesFillOptionsThatAJobRefuses") {
  const PointCloud cloud = torus(1000, 0.0);
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const double wrong : {0.5, -1.0, none, std::numeric_limits<double>::infinity()}) {
    ReconstructionOptions options;
    options.fill.neighborhood = wrong;
    CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("fill.neighborhood"));
  }
  for (const double wrong : {0.0, -1.0, none}) {
    ReconstructionOptions options;
    options.fill.max_diameter = wrong;
    CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("fill.max_diameter"));
    options = {};
    options.fill.max_perimeter = wrong;
    CHECK_THROWS_WITH(reconstruct(cloud.positions, {}, options), Contains("fill.max_perimeter"));
  }
}

TEST_CASE("TheFrontDoorRefusesPlacesAndDirectionsThatAreNone") {
  const PointCloud cloud = without_normals(torus(1000, 0.0));
  const double none = std::numeric_limits<double>::quiet_NaN();
  const double far = std::numeric_limits<double>::infinity();
  for (const Vec3 wrong : {Vec3{0, 0, none}, Vec3{far, 0, 0}}) {
    ReconstructionOptions options;
    options.normals.viewpoint = wrong;
    CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("normals.viewpoint"));
    options = {};
    options.normals.up = wrong;
    CHECK_THROWS_WITH(reconstruct(cloud, options), Contains("normals.up"));
  }
  ReconstructionOptions options;
  options.normals.up = Vec3{};
  CHECK_THROWS_WITH(reconstruct(cloud.positions, {}, options), Contains("normals.up"));
}

TEST_CASE("TheFrontDoorRefusesColumnsThatDoNotBelongTogether") {
  const PointCloud whole = torus(1000, 0.0);
  const std::string points = std::to_string(whole.size());
  PointCloud cloud = whole;
  for (const std::size_t wrong : {std::size_t{10}, whole.size() + 1}) {
    cloud.normals.resize(wrong);
    CHECK_THROWS_WITH(reconstruct(cloud),
                      Contains(std::to_string(wrong) + " normals for " + points + " positions"));
  }
  cloud = whole;
  cloud.attributes.resize(8);
  CHECK_THROWS_WITH(reconstruct(cloud),
                    Contains("8 bytes") && Contains("each of " + points + " points"));
  cloud = whole;
  cloud.schema.attributes.push_back({"more", ScalarType::kFloat64});
  CHECK_THROWS_WITH(reconstruct(cloud), Contains("the attributes are not those of the schema"));
}

TEST_CASE("AJobThatAProgramFilledInIsHeldToTheRangesOfJobFiles") {
  ScratchDirectory scratch;
  write_cloud(scratch / "cloud.ply", torus(1000, 0.0));
  Job good;
  good.input.files = {(scratch / "cloud.ply").string()};
  good.output.mesh = (scratch / "mesh.ply").string();
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const char* key, void (*spoil)(Job&, double)) {
    Job job = good;
    spoil(job, none);
    CHECK_THROWS_WITH(run_job(job), Contains(key));
  };
  refused("input.files", [](Job& job, double) { job.input.files.clear(); });
  refused("normals.neighbors", [](Job& job, double) { job.normals.neighbors = -1; });
  refused("normals.viewpoint", [](Job& job, double nan) {
    job.normals.viewpoint = Vec3{nan, 0, 0};
  });
  refused("cleaning.smooth_passes", [](Job& job, double) { job.cleaning.smooth_passes = -3; });
  refused("cleaning.thin_to_spacing",
          [](Job& job, double nan) { job.cleaning.thin_to_spacing = nan; });
  refused("fill.max_diameter", [](Job& job, double nan) { job.fill.max_diameter = nan; });
  refused("output.simplify", [](Job& job, double nan) {
    job.output.simplify = SimplifyTarget{SimplifyTarget::Kind::kRatio, nan};
  });
  refused("run.threads", [](Job& job, double) { job.run.threads = -5; });
  refused("output.mesh", [](Job& job, double) { job.output.mesh.clear(); });
  refused("cannot write .xyz meshes", [](Job& job, double) { job.output.mesh = "mesh.xyz"; });
  refused("OBJ has no binary encoding", [](Job& job, double) {
    job.output.mesh = "mesh.obj";
    job.output.requires_binary = true;
  });
  for (const char* left : {".work", "mesh.work"}) CHECK_FALSE(std::filesystem::exists(left));
  CHECK_FALSE(std::filesystem::exists(good.output.mesh));
  good.fill.max_edges = good.partition.memory_bytes = std::numeric_limits<std::uint64_t>::max();
  good.input.crop = Box{{none, none, none}, {1, 1, 1}};
  CHECK_THROWS_WITH(run_job(good), Contains("outside the crop"));
  good.input.crop.reset();
  CHECK(run_job(good).mesh.triangles > 0);
}

TEST_CASE("TwoCallsAtOnceGiveTheMeshesOfOneCallEach", "[costly]") {
  ScratchDirectory scratch;
  const PointCloud holed = holed_torus();
  const PointCloud raw = without_normals(torus(4000, 0.1));
  const std::string expected_holed = bytes_of_mesh(scratch, reconstruct(holed));
  const std::string expected_raw = bytes_of_mesh(scratch, reconstruct(raw));
  for (const int threads : {0, 3}) {
    ReconstructionOptions options;
    options.threads = threads;
    Reconstruction other;
    std::thread second([&] { other = reconstruct(raw, options); });
    const Reconstruction result = reconstruct(holed, options);
    second.join();
    CHECK(bytes_of_mesh(scratch, result) == expected_holed);
    CHECK(bytes_of_mesh(scratch, other) == expected_raw);
  }
}

TEST_CASE("AnExceptionOfTheProgressCallbackReachesTheCaller") {
  struct Refusal {};
  ReconstructionOptions options;
  options.threads = 2;
  options.progress = [](std::string_view stage, double) {
    if (stage == "reconstruct") throw Refusal();
  };
  CHECK_THROWS_AS(reconstruct(torus(1000, 0.0), options), Refusal);
}
