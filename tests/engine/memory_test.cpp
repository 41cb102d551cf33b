// The budget holds for the whole process, whatever the cloud looks like: jobs as a user runs them,
// their peak as the system measured it.
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "engine/pipeline/budget/memory_forecast.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;
using test::bytes_of;
using test::ProgramResult;
using test::Random;
using test::run_program;
using test::ScratchDirectory;

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kSmallBudget = 208 * kMiB;

/// A torus of radii 1 and 0.4 from two angles, with its normal.
void add_torus_point(double u, double v, PointCloud& cloud) {
  const double ring = 1.0 + 0.4 * std::cos(v);
  cloud.positions.push_back({ring * std::cos(u), ring * std::sin(u), 0.4 * std::sin(v)});
  cloud.normals.push_back({std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v)});
}

void add_scattered(std::size_t points, Random& random, PointCloud& cloud) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (std::size_t i = 0; i < points; ++i) {
    const double u = kTurn * random.uniform(), v = kTurn * random.uniform();
    add_torus_point(u, v, cloud);
  }
}

/// In a piece of the torus whose sides are that long.
void add_spot(std::size_t points, double side, Random& random, PointCloud& cloud) {
  for (std::size_t i = 0; i < points; ++i) {
    const double u = (random.uniform() - 0.5) * side / 1.4;
    const double v = (random.uniform() - 0.5) * side / 0.4;
    add_torus_point(u, v, cloud);
  }
}

PointCloud oriented_cloud() {
  PointCloud cloud;
  cloud.schema.has_normals = true;
  return cloud;
}

/// The side of a cube of that share of the torus's bounds.
double side_of_volume(double share) { return std::cbrt(2.8 * 2.8 * 0.8 * share); }

std::string write(const ScratchDirectory& scratch, PointCloud cloud) {
  test::shuffle(cloud, 5);
  const std::string file = (scratch / "cloud.ply").string();
  write_cloud(file, cloud);
  return file;
}

ProgramResult reconstruct(const ScratchDirectory& scratch, const std::string& cloud,
                          const std::string& mesh, double radius, const std::string& memory,
                          const std::vector<std::string>& more = {"--no-fill"}) {
  std::vector<std::string> words = {"reconstruct", cloud};
  const std::string path = (scratch / mesh).string();
  for (const auto& [option, value] : {std::pair<std::string, std::string>{"-o", path},
                                      {"--report", path + ".json"},
                                      {"--radii", std::to_string(radius)},
                                      {"--memory", memory},
                                      {"--threads", "2"},
                                      {"--progress", "plain"}}) {
    words.push_back(option);
    words.push_back(value);
  }
  words.insert(words.end(), more.begin(), more.end());
  return run_program(words);
}

/// The report's, which is the kernel's high-water mark of the process.
std::uint64_t peak_of(const ScratchDirectory& scratch, const std::string& mesh) {
  return Json::parse(test::file_text(scratch / (mesh + ".json"))).at("peak_memory_bytes");
}

/// The same bytes inside the small budget and with room for everything.
void require_same_in_small_budget(const ScratchDirectory& scratch, const std::string& cloud,
                                  double radius) {
  const ProgramResult small = reconstruct(scratch, cloud, "small.ply", radius, "208MiB");
  INFO(small.err);
  REQUIRE(small.status == 0);
  CHECK(peak_of(scratch, "small.ply") < kSmallBudget);
  REQUIRE(reconstruct(scratch, cloud, "large.ply", radius, "8GiB").status == 0);
  CHECK(bytes_of(scratch / "small.ply") == bytes_of(scratch / "large.ply"));
}

/// A torus with bumps, row by row: little of it is in the memory of this process.
void write_torus_mesh(const std::string& file, std::uint64_t rows, std::uint64_t columns) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  MeshHeader header;
  header.vertices = rows * columns;
  header.triangles = 2 * rows * columns;
  const auto writer = open_mesh_writer(file, header);
  for (std::uint64_t row = 0; row < rows; ++row) {
    PointCloud points;
    const double u = kTurn * static_cast<double>(row) / static_cast<double>(rows);
    for (std::uint64_t column = 0; column < columns; ++column) {
      const double v = kTurn * static_cast<double>(column) / static_cast<double>(columns);
      const double tube = 0.4 + 0.01 * std::sin(97.0 * u) * std::sin(83.0 * v);
      const double ring = 1.0 + tube * std::cos(v);
      points.positions.push_back({ring * std::cos(u), ring * std::sin(u), tube * std::sin(v)});
    }
    writer->write_vertices(points);
  }
  for (std::uint64_t row = 0; row < rows; ++row) {
    std::vector<Triangle64> triangles;
    const std::uint64_t here = row * columns, ahead = (row + 1) % rows * columns;
    for (std::uint64_t column = 0; column < columns; ++column) {
      const std::uint64_t next = (column + 1) % columns;
      triangles.push_back({here + column, ahead + column, ahead + next});
      triangles.push_back({here + column, ahead + next, here + next});
    }
    writer->write_triangles(triangles);
  }
  writer->finish();
}

/// Of all programs that this process ran and waited for.
std::uint64_t largest_child_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_CHILDREN, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) << 10;
}

}  // namespace

TEST_CASE("APeakBeyondWhatTheSystemGivesIsToldWithTheKeyThatLowersIt") {
  const Job job;
  CHECK(objection_to_peak(job, 100 * kMiB, 100 * kMiB).empty());
  CHECK(objection_to_peak(job, 100 * kMiB, std::nullopt).empty());
  const std::string told = objection_to_peak(job, 300 * kMiB, 200 * kMiB);
  for (const char* word : {"300.0 MiB", "200.0 MiB", "killed", "partition.memory"})
    CHECK(told.find(word) != std::string::npos);
}

TEST_CASE("ADensitySpikeStaysInsideTheBudget") {
  const ScratchDirectory scratch;
  constexpr std::size_t kPoints = 700'000;
  // A third of the points in a thousandth of the volume, half of them in a millionth.
  const auto [share, volume] = GENERATE(std::pair{0.3, 1e-3}, std::pair{0.5, 1e-6});
  const auto dense = static_cast<std::size_t>(share * kPoints);
  const double side = side_of_volume(volume);
  std::string file;
  {
    Random random(1);
    PointCloud cloud = oriented_cloud();
    add_scattered(kPoints - dense, random, cloud);
    add_spot(dense, side, random, cloud);
    file = write(scratch, std::move(cloud));
  }
  // The ball that the spike asks for.
  require_same_in_small_budget(scratch, file, 2.0 * side / std::sqrt(static_cast<double>(dense)));
}

TEST_CASE("DuplicatesOfOnePointStayInsideTheBudget") {
  const ScratchDirectory scratch;
  std::string file;
  {
    Random random(2);
    PointCloud cloud = oriented_cloud();
    add_scattered(300'000, random, cloud);
    for (int i = 0; i < 900'000; ++i) add_torus_point(0.3, 0.4, cloud);
    file = write(scratch, std::move(cloud));
  }
  require_same_in_small_budget(scratch, file, 0.012);
}

TEST_CASE("AChunkSizeBeyondTheBudgetIsCappedWithAWarning") {
  const ScratchDirectory scratch;
  std::string file;
  {
    Random random(3);
    PointCloud cloud = oriented_cloud();
    add_scattered(900'000, random, cloud);
    file = write(scratch, std::move(cloud));
  }
  const ProgramResult result = reconstruct(scratch, file, "mesh.ply", 0.01, "208MiB",
                                           {"--no-fill", "--chunk-points", "10000000"});
  INFO(result.err);
  REQUIRE(result.status == 0);
  CHECK(result.err.find("more than the memory budget has room for") != std::string::npos);
  CHECK(peak_of(scratch, "mesh.ply") < kSmallBudget);
}

TEST_CASE("ManyHolesAreFilledInsideTheBudgetToTheSameBytes", "[soak]") {
  const ScratchDirectory scratch;
  std::string file;
  {
    Random random(6);
    PointCloud cloud = oriented_cloud();
    add_scattered(1'000'000, random, cloud);
    file = write(scratch, std::move(cloud));
  }
  // Balls that hardly bridge the mean spacing: a third of all edges are boundary.
  const double radius = 0.0042;
  const ProgramResult small = reconstruct(scratch, file, "small.ply", radius, "208MiB", {});
  INFO(small.err);
  REQUIRE(small.status == 0);
  const Json report = Json::parse(test::file_text(scratch / "small.ply.json"));
  CHECK(report.at("holes").size() > 30'000);
  CHECK(peak_of(scratch, "small.ply") < kSmallBudget);
  CHECK(report.at("predicted").at("peak_memory_bytes").get<std::uint64_t>() <= kSmallBudget);
  REQUIRE(reconstruct(scratch, file, "large.ply", radius, "8GiB", {}).status == 0);
  CHECK(bytes_of(scratch / "small.ply") == bytes_of(scratch / "large.ply"));
}

TEST_CASE("ABallThatReachesMorePointsThanTheBudgetHoldsSaysTheLeast") {
  const ScratchDirectory scratch;
  std::string file;
  {
    Random random(4);
    PointCloud cloud = oriented_cloud();
    add_scattered(1'300'000, random, cloud);
    add_spot(900'000, 0.1, random, cloud);
    file = write(scratch, std::move(cloud));
  }
  // Ten radii are the halo: every chunk of the spot would have the whole spot for its halo.
  const ProgramResult result = reconstruct(scratch, file, "mesh.ply", 0.012, "208MiB");
  INFO(result.err);
  CHECK(result.status == 4);
  CHECK(result.err.find("at least") != std::string::npos);
  CHECK(result.err.find("--memory") != std::string::npos);
}

TEST_CASE("ABoundaryThatTheBudgetCannotHoldSaysTheLeast") {
  ResolvedJob job;
  job.partition.memory_bytes = 512 * kMiB;
  const HoleLoad fits{1'400'000, 200'000, 32 * kMiB, 4 * kMiB, 400 * kMiB};
  CHECK_NOTHROW(require_memory_for_holes(job, Partition(), fits));
  CHECK(predicted_hole_bytes(job, Partition(), fits) <= job.partition.memory_bytes);
  const HoleLoad large{14'000'000, 2'000'000, 32 * kMiB, 4 * kMiB, 4000 * kMiB};
  try {
    require_memory_for_holes(job, Partition(), large);
    FAIL("a boundary of gigabytes was taken");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kResource);
    const std::string text = error.what();
    CHECK(text.find("at least") != std::string::npos);
    CHECK(text.find("partition.memory") != std::string::npos);
  }
}

TEST_CASE("TilesOnAMapGridStayInsideTheBudgetWithTheSameBytes") {
  const ScratchDirectory scratch;
  Random random(3);
  PointCloud cloud = oriented_cloud();
  add_scattered(1'000'000, random, cloud);
  const std::string file = write(scratch, std::move(cloud));
  // All of it in four tiles, then in more tiles than may be open.
  for (const char* size : {"100", "0.05"}) {
    INFO("tiles of " << size);
    const std::vector<std::string> more = {"--tiles", "--tile-size", size};
    const ProgramResult small = reconstruct(scratch, file, "small.ply", 0.006, "208MiB", more);
    INFO(small.err);
    REQUIRE(small.status == 0);
    CHECK(peak_of(scratch, "small.ply") < kSmallBudget);
    REQUIRE(reconstruct(scratch, file, "large.ply", 0.006, "8GiB", more).status == 0);
    CHECK(bytes_of(scratch / "small.tiles" / "tiles.json") ==
          bytes_of(scratch / "large.tiles" / "tiles.json"));  // has all checksums
  }
}

TEST_CASE("LevelsOfDetailStayInsideTheBudget") {
  const ScratchDirectory scratch;
  const std::string mesh = (scratch / "mesh.ply").string();
  write_torus_mesh(mesh, 1000, 1000);
  const auto made = [&](const std::string& memory, const std::string& name) {
    const ProgramResult tiles =
        run_program({"tileset", mesh, "-o", (scratch / name).string(), "--memory", memory,
                     "--threads", "2", "--measure", "--progress", "none"});
    INFO(tiles.err);
    REQUIRE(tiles.status == 0);
    REQUIRE(run_program({"simplify", mesh, "-o", (scratch / (name + ".ply")).string(), "--ratio",
                         "0.3", "--memory", memory, "--threads", "2", "--progress", "none"})
                .status == 0);
  };
  constexpr std::uint64_t kBudget = 176 * kMiB;
  made("176MiB", "small");
  CHECK(largest_child_bytes() < kBudget);
  // The same bytes with room for everything.
  made("4GiB", "large");
  CHECK(bytes_of(scratch / "small" / "tiles.json") == bytes_of(scratch / "large" / "tiles.json"));
  CHECK(bytes_of(scratch / "small.ply") == bytes_of(scratch / "large.ply"));
}

}  // namespace orbweave
