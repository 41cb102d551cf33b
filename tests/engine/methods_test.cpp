// Jobs with the methods that take the whole cloud at once, and the fans of their triangles.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/stage/stages.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/planning/plan_job.h"
#include "engine/stitching/triangle_fans.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

using namespace test;

constexpr ReconstructionMethod kMethods[] = {
    ReconstructionMethod::kCrust, ReconstructionMethod::kPowerCrust, ReconstructionMethod::kCocone,
    ReconstructionMethod::kTightCocone};

std::string message_of(const Job& job) {
  try {
    run(job);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("FansOfTrianglesAreThoseThatBallPivotingFinds") {
  const NamedCloud named = noisy_torus(3000, 0.5, 5);
  const BallPivotingResult found = ball_pivoting(named.cloud.positions, named.cloud.normals, {},
                                                 {.ball_radii = {named.ball_radius}});
  REQUIRE(found.boundary.size() > 5);
  const BallPivotingResult made = with_fans(found.triangles, named.cloud.size());
  CHECK(made.triangles == found.triangles);
  CHECK(made.fans == found.fans);
  CHECK(made.fan_members == found.fan_members);
  auto expected = found.boundary, boundary = made.boundary;
  std::sort(expected.begin(), expected.end());
  std::sort(boundary.begin(), boundary.end());
  CHECK(boundary == expected);
}

TEST_CASE("ComponentsTurnToTheirNormalsOneByOne") {
  const TriangleMesh left = sphere_mesh(2);
  const TriangleMesh right = moved(flipped(left), [](Vec3 p) { return p + Vec3{5.0, 0.0, 0.0}; });
  const TriangleMesh both = joined(left, right);
  std::vector<Vec3> outward;
  for (const Vec3 p : both.vertices.positions)
    outward.push_back(p.x > 2.5 ? p - Vec3{5.0, 0.0, 0.0} : p);
  std::vector<Triangle> triangles;
  for (const Triangle& t : both.triangles) triangles.push_back(smallest_first(t));
  turn_to_normals(both.vertices.positions, outward, triangles);
  for (const Triangle& t : triangles) {
    const auto& p = both.vertices.positions;
    CHECK(dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), outward[t[0]]) > 0.0);
  }
}

TEST_CASE("MethodsThatAreNotThereSaySo") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(500, 0.0, 1));
  const auto expected = Catch::Matchers::Contains("without the methods of the Voronoi family");
  for (const ReconstructionMethod method : kMethods) {
    job.reconstruct.method = method;
    if (has_voronoi_family())
      CHECK(message_of(job).empty());
    else
      CHECK_THAT(message_of(job), expected);
  }
}

TEST_CASE("MethodsCloseATorusInAJob") {
  if (!has_voronoi_family()) return;
  for (const ReconstructionMethod method : kMethods) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, painted_torus(3000, 0.1, 3));
    job.reconstruct.method = method;
    const RunReport report = run(job);
    INFO("method " << static_cast<int>(method));
    CHECK(report.chunks == 1);
    CHECK(report.radii.empty());
    CHECK(report.mesh.watertight);
    CHECK(report.mesh.euler_characteristic == 0);
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    CHECK(validate_mesh(mesh).empty());
    CHECK(mesh_facts(mesh).watertight);
    CHECK(mesh_facts(mesh).triangles == report.mesh.triangles);
  }
}

TEST_CASE("MethodsCloseTwoComponentsInAJob") {
  SyntheticOptions options;
  options.shape = Shape::kTwoComponents;
  options.points = 4000;
  SyntheticCloud source(options);
  PointCloud cloud;
  source.read(cloud, options.points);
  const NamedCloud named{"two components", std::move(cloud), 1.3 * spacing(options)};
  for (const ReconstructionMethod method :
       {ReconstructionMethod::kBallPivoting, ReconstructionMethod::kCocone,
        ReconstructionMethod::kTightCocone}) {
    if (is_in_core(method) && !has_voronoi_family()) continue;
    ScratchDirectory scratch;
    Job job = job_for(scratch, named);
    job.reconstruct.method = method;
    const RunReport report = run(job);
    INFO("method " << static_cast<int>(method));
    CHECK(report.mesh.watertight);
    CHECK(report.mesh.components == 2);
    CHECK(report.mesh.euler_characteristic == 2);
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    CHECK(validate_mesh(mesh).empty());
    std::uint64_t on_sphere = 0;
    for (const Vec3 p : mesh.vertices.positions) on_sphere += p.z > 0.6 ? 1 : 0;
    const auto of_sphere = std::ranges::count_if(
        mesh.triangles, [&](const Triangle& t) { return mesh.vertices.positions[t[0]].z > 0.6; });
    CHECK(of_sphere == static_cast<std::ptrdiff_t>(2 * on_sphere - 4));  // Euler number 2, then 0
  }
}

TEST_CASE("MethodsMakeTheSameBytesForAnyOrderThreadsAndChunks") {
  if (!has_voronoi_family()) return;
  NamedCloud named = painted_torus(1500, 0.3, 3);
  for (const ReconstructionMethod method : kMethods) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, named);
    job.reconstruct.method = method;
    const std::string expected = mesh_bytes(job);
    NamedCloud other = named;
    shuffle(other.cloud, 7);
    ScratchDirectory again;
    Job shuffled = job_for(again, other);
    shuffled.reconstruct.method = method;
    shuffled.partition.chunk_points = 300;
    shuffled.run.threads = 1;
    INFO("method " << static_cast<int>(method));
    CHECK((mesh_bytes(shuffled) == expected));
  }
}

TEST_CASE("InterruptedMethodsResumeToTheSameBytes", "[costly]") {
  if (!has_voronoi_family()) return;
  for (const ReconstructionMethod method :
       {ReconstructionMethod::kTightCocone, ReconstructionMethod::kPowerCrust}) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, painted_torus(1500, 0.3, 3));
    job.reconstruct.method = method;
    const std::string expected = mesh_bytes(job);
    std::filesystem::remove(job.output.mesh);
    INFO("method " << static_cast<int>(method));
    CHECK(run_with_interruptions(job, 1, 3) > 0);
    CHECK((bytes_of(job.output.mesh) == expected));
  }
}

TEST_CASE("PowerCrustVerticesCarryTheAttributesOfAPointNearThem") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  const NamedCloud named = painted_torus(1500, 0.0, 3);
  Job job = job_for(scratch, named);
  job.reconstruct.method = ReconstructionMethod::kPowerCrust;
  const RunReport report = run(job);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  const PointCloud& vertices = mesh.vertices;
  REQUIRE(vertices.size() > 4 * named.cloud.size());
  CHECK(report.points_read == named.cloud.size());
  CHECK(report.points_unused == 0);
  REQUIRE(vertices.schema.attributes == named.cloud.schema.attributes);
  const auto nearest_alike = [&](std::size_t v) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < named.cloud.size(); ++i)
      if (std::ranges::equal(named.cloud.attribute_row(i), vertices.attribute_row(v)))
        nearest = std::min(nearest, norm(named.cloud.positions[i] - vertices.positions[v]));
    return nearest;
  };
  std::size_t looked_at = 0, far = 0;
  for (std::size_t v = 0; v < vertices.size(); v += 7) {
    const double distance = nearest_alike(v);
    CHECK(distance < 4.0 * named.ball_radius);
    ++looked_at;
    far += distance < 2.0 * named.ball_radius ? 0 : 1;
  }
  CHECK(far * 20 < looked_at);
}

TEST_CASE("PowerCrustsAreTurnedToTheNormalsOfThePoints") {
  if (!has_voronoi_family()) return;
  NamedCloud named = painted_torus(1000, 0.0, 3);
  for (const bool inward : {false, true}) {
    if (inward)
      for (Vec3& n : named.cloud.normals) n = -n;
    ScratchDirectory scratch;
    Job job = job_for(scratch, named);
    job.reconstruct.method = ReconstructionMethod::kPowerCrust;
    run(job);
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    const std::vector<Vec3>& p = mesh.vertices.positions;
    double volume = 0.0, agreement = 0.0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 area = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
      volume += dot(p[t[0]], area) / 6.0;
      for (const std::uint32_t v : t) agreement += dot(mesh.vertices.normals[v], area) / 6.0;
    }
    CHECK((volume < 0.0) == inward);
    CHECK(agreement > 0.95 * mesh_facts(mesh).area);
  }
}

TEST_CASE("APowerCrustComesAsPolygonsAndWithItsMedialAxis") {
  if (!has_voronoi_family()) return;
  NamedCloud named = painted_torus(1500, 0.1, 3);
  for (Vec3& n : named.cloud.normals) n = -n;  // all files are turned alike
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.reconstruct.method = ReconstructionMethod::kPowerCrust;
  job.output.medial_axis = (scratch / "medial_axis.ply").string();
  for (const char* name : {"polygons.ply", "polygons.obj"}) {
    job.output.polygons = (scratch / name).string();
    run(job);
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    const TriangleMesh polygons = read_mesh(job.output.polygons);
    CHECK((polygons.vertices.positions == mesh.vertices.positions));
    CHECK(polygons.triangles.size() == mesh.triangles.size());
    CHECK(mesh_facts(polygons).watertight);
    CHECK(mesh_facts(polygons).area == Approx(mesh_facts(mesh).area).epsilon(1e-6));
  }
  CHECK(bytes_of(job.output.medial_axis).find("property double radius") != std::string::npos);
  const TriangleMesh axis = read_mesh(job.output.medial_axis);
  REQUIRE(axis.vertices.size() > 100);
  for (std::size_t b = 0; b < axis.vertices.size(); b += 5) {
    double radius = 0.0;
    std::memcpy(&radius, axis.vertices.attribute_row(b).data(), sizeof radius);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3 p : named.cloud.positions)
      nearest = std::min(nearest, norm(p - axis.vertices.positions[b]));
    CHECK(nearest == Approx(radius).epsilon(1e-6));  // an empty ball that touches points
  }
}

TEST_CASE("OnlyAPowerCrustHasPolygonsAndAMedialAxis") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(500, 0.0, 1));
  job.output.polygons = (scratch / "polygons.ply").string();
  CHECK_THAT(message_of(job), Catch::Matchers::Contains("only a Power Crust") &&
                                  Catch::Matchers::Contains("output.polygons"));
  job.reconstruct.method = ReconstructionMethod::kPowerCrust;
  job.output.polygons = (scratch / "polygons.stl").string();
  CHECK_THAT(message_of(job), Catch::Matchers::Contains(".ply or .obj"));
  job.output.polygons.clear();
  job.output.medial_axis = (scratch / "axis.obj").string();
  CHECK_THAT(message_of(job), Catch::Matchers::Contains("output.medial_axis"));
  CHECK_FALSE(std::filesystem::exists(job.run.work_dir));
}

TEST_CASE("ADamagedPowerCrustIsMadeAgain") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(1500, 0.0, 3));
  job.reconstruct.method = ReconstructionMethod::kPowerCrust;
  job.run.keep_work_dir = true;
  const std::string expected = mesh_bytes(job);
  std::filesystem::remove(job.output.mesh);
  const std::filesystem::path stored = std::filesystem::path(job.run.work_dir) / kPowerCrustStage;
  REQUIRE(results_in(stored) == 1);
  for (const auto& entry : std::filesystem::directory_iterator(stored))
    if (entry.path().extension() == ".h5") damage(entry.path());
  CHECK((mesh_bytes(job) == expected));
}

TEST_CASE("AStoredPowerCrustIsTakenAgain") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(1500, 0.0, 3));
  job.reconstruct.method = ReconstructionMethod::kPowerCrust;
  job.run.keep_work_dir = true;
  const std::string expected = mesh_bytes(job);
  job.output.binary = false;
  const RunReport report = run(job);
  std::uint64_t reused = 0;
  for (const StageFacts& stage : report.stages)
    if (stage.name == name_of(Stage::kPowerCrust)) reused += stage.chunks_reused;
  CHECK(reused == 1);
  job.output.binary = true;
  CHECK((mesh_bytes(job) == expected));
}

TEST_CASE("ProgressComesFromInsideTheTriangulations") {
  if (!has_voronoi_family()) return;
  for (const ReconstructionMethod method : kMethods) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, painted_torus(6000, 0.0, 3));
    job.reconstruct.method = method;
    RecordingProgress progress;
    int steps = 0;
    progress.at_step = [&] {
      const std::string& stage = progress.stages.back();
      if (stage == name_of(Stage::kPowerCrust) || stage == name_of(Stage::kReconstruct)) ++steps;
    };
    run_job(job, {"test"}, progress, StopToken());
    INFO("method " << static_cast<int>(method));
    CHECK(steps > 6);
  }
}

TEST_CASE("MethodsRefuseACloudOfOnePlaneInAJob") {
  if (!has_voronoi_family()) return;
  for (const ReconstructionMethod method : kMethods) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, grid_sheet(12, 0.0));
    job.reconstruct.method = method;
    INFO("method " << static_cast<int>(method));
    CHECK_THAT(message_of(job), Catch::Matchers::Contains(job.input.files.front() +
                                                          ": no tetrahedron can be formed") &&
                                    Catch::Matchers::Contains("in one plane"));
    CHECK_FALSE(std::filesystem::exists(job.run.work_dir));
    CHECK_FALSE(std::filesystem::exists(job.output.mesh));
  }
}

TEST_CASE("MethodsTakeTheSurfaceOfAGridInAJob") {
  if (!has_voronoi_family()) return;
  PointCloud cloud;
  cloud.schema.has_normals = true;
  constexpr int kSide = 7;
  for (int i = 0; i <= kSide; ++i)
    for (int j = 0; j <= kSide; ++j)
      for (int k = 0; k <= kSide; ++k) {
        const Vec3 p{1.0 * i, 1.0 * j, 1.0 * k};
        const bool is_inside = i % kSide != 0 && j % kSide != 0 && k % kSide != 0;
        if (is_inside) continue;
        cloud.positions.push_back(p);
        cloud.normals.push_back(normalized(p - Vec3{3.5, 3.5, 3.5}));
      }
  for (const ReconstructionMethod method : kMethods) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, {"grid", cloud, 1.0});
    job.reconstruct.method = method;
    const RunReport report = run(job);
    INFO("method " << static_cast<int>(method));
    CHECK(report.mesh.nonmanifold_edges == 0);
    CHECK(validate_mesh(read_mesh(job.output.mesh)).empty());
    const bool is_closed =
        method == ReconstructionMethod::kPowerCrust || method == ReconstructionMethod::kTightCocone;
    if (is_closed) CHECK(report.mesh.watertight);
  }
}

TEST_CASE("AWorkDirectoryOfAnotherMethodIsNotTaken") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(1500, 0.3, 3));
  job.run.keep_work_dir = true;
  const std::string pivoted = mesh_bytes(job);
  job.reconstruct.method = ReconstructionMethod::kTightCocone;
  const std::string tight = mesh_bytes(job);
  CHECK((tight != pivoted));
  CHECK(read_mesh(job.output.mesh).triangles.size() > 0);
  job.reconstruct.method = ReconstructionMethod::kBallPivoting;
  CHECK((mesh_bytes(job) == pivoted));
}

TEST_CASE("MoreTetrahedraThanForeseenStayInsideTheBudget", "[costly]") {
  if (!has_voronoi_family()) return;
  // The poles of a torus lie on a circle, and each is a neighbour of a whole ring of points.
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(60'000, 0.0, 1));
  job.run.threads = 1;
  job.reconstruct.method = ReconstructionMethod::kPowerCrust;
  job.partition.memory_bytes = std::uint64_t{400} << 20;
  CHECK_THAT(message_of(job),
             Catch::Matchers::Contains("the method power_crust outgrows the memory budget") &&
                 Catch::Matchers::Contains("no more than 400.0 MiB") &&
                 Catch::Matchers::Contains("ball_pivoting"));
}

namespace {

/// Each pair of neighbours on one line and each pair on the other span a tetrahedron.
PointCloud two_lines(int points_per_line) {
  PointCloud cloud;
  for (int i = 0; i < points_per_line; ++i) {
    const double along = (i + 0.5) / points_per_line - 0.5;
    cloud.positions.push_back({along, 0.0, 0.0});
    cloud.positions.push_back({0.0, along, 1.0});
  }
  return cloud;
}

}  // namespace

TEST_CASE("PolesOfMoreTetrahedraThanForeseenStayInsideTheBudget", "[costly]") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, {"two lines", two_lines(2600), 0.1});
  job.run.threads = 1;
  job.normals.source = NormalSource::kPoles;
  job.partition.memory_bytes = std::uint64_t{200} << 20;
  CHECK_THAT(message_of(job),
             Catch::Matchers::Contains("normals.source = \"poles\" outgrows the memory budget") &&
                 Catch::Matchers::Contains("no more than 200.0 MiB") &&
                 Catch::Matchers::Contains("estimate"));
}

TEST_CASE("ConesOfMoreTetrahedraThanForeseenStayInsideTheBudget", "[costly]") {
  if (!has_voronoi_family()) return;
  PointCloud cloud = two_lines(2000);
  cloud.normals.assign(cloud.positions.size(), {0.0, 0.0, 1.0});
  cloud.schema.has_normals = true;
  ScratchDirectory scratch;
  Job job = job_for(scratch, {"two lines", std::move(cloud), 0.1});
  job.run.threads = 1;
  job.reconstruct.method =
      GENERATE(ReconstructionMethod::kCocone, ReconstructionMethod::kTightCocone);
  job.partition.memory_bytes = std::uint64_t{200} << 20;
  CHECK_THAT(message_of(job), Catch::Matchers::Contains("cocone outgrows the memory budget") &&
                                  Catch::Matchers::Contains("no more than 200.0 MiB"));
  job.partition.memory_bytes = std::uint64_t{1} << 30;
  CHECK_THAT(message_of(job), !Catch::Matchers::Contains("outgrows"));
}

TEST_CASE("TooManyPointsForTheBudgetAreRefusedWithTheFigures") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(200'000, 0.0, 1));
  job.run.threads = 1;
  job.partition.memory_bytes = std::uint64_t{256} << 20;
  for (const ReconstructionMethod method :
       {ReconstructionMethod::kCrust, ReconstructionMethod::kPowerCrust}) {
    job.reconstruct.method = method;
    const std::string refused = "too small for the method " + method_name(job);
    CHECK_THAT(message_of(job), Catch::Matchers::Contains(refused) &&
                                    Catch::Matchers::Contains("200,239 points") &&
                                    Catch::Matchers::Contains("at least"));
    RecordingProgress progress;
    const StopToken stop;
    try {
      plan_job(job, progress, stop);
      FAIL("the plan takes what the run refuses");
    } catch (const Error& error) {
      CHECK_THAT(std::string(error.what()), Catch::Matchers::Contains(refused));
    }
  }
}

}  // namespace orbweave
