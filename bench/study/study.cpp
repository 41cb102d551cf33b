// One method of the comparative study on one model, alone in its process: CPU seconds of the method
// (one thread; a busy machine disturbs little), peak memory and mesh size, as one JSON line.
// usage: bench_study METHOD MODEL [--radius R] [--repeats N] [--noise VARIANCE] [--mesh OUT.obj]
// METHOD: ball_pivoting, crust, power_crust, cocone, tight_cocone; triangulations: the seconds of
// the triangulations alone that these cannot do without; delaunay: without those of power_crust;
// none: the points are loaded and nothing more. The process deals with memory as the program does.
#include <oneapi/tbb/global_control.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/cli/freed_memory.h"
#include "engine/normals/normals_from_faces.h"
#include "engine/validation/mesh_facts.h"
#include "engine/voronoi/voronoi.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/report/machine.h"
#include "partition/canonical_order.h"

namespace {

using namespace orbweave;
using Json = nlohmann::json;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Options {
  std::string method, model, mesh;
  double radius = 0.0;
  double noise_variance = 0.0;
  int repeats = 1;
};

/// Gaussian noise of the same bits on every machine's mt19937_64.
void add_noise(PointCloud& cloud, double variance) {
  std::mt19937_64 bits(1);
  const auto uniform = [&] { return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53; };
  for (Vec3& p : cloud.positions)
    for (int axis = 0; axis < 3; ++axis)
      p[axis] += std::sqrt(variance) * std::sqrt(-2.0 * std::log(uniform())) *
                 std::cos(2.0 * std::numbers::pi * uniform());
}

/// The vertices of a mesh with the normals of its faces, or of a cloud, in canonical order.
PointCloud load(const Options& options) {
  TriangleMesh mesh = read_mesh(options.model);
  PointCloud cloud;
  cloud.normals = normals_from_faces(mesh);
  cloud.positions = std::move(mesh.vertices.positions);
  cloud.schema.has_normals = true;
  cloud.schema.normal_type = ScalarType::kFloat64;
  if (options.noise_variance > 0.0) add_noise(cloud, options.noise_variance);
  sort_canonically(cloud, root_cube(cloud.bounds()));
  return cloud;
}

/// What a method made.
struct Made {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  std::size_t polygons = 0;
};

Made make(const Options& options, const PointCloud& cloud) {
  const std::vector<Vec3>& points = cloud.positions;
  if (options.method == "ball_pivoting")
    return {points,
            ball_pivoting(points, cloud.normals, {}, {.ball_radii = {options.radius}}).triangles};
  if (options.method == "crust") return {points, voronoi::crust(points).triangles};
  if (options.method == "cocone") return {points, voronoi::cocone(points).triangles};
  if (options.method == "tight_cocone") return {points, voronoi::tight_cocone(points).triangles};
  voronoi::PowerCrustSurface surface = voronoi::power_crust(points);
  std::vector<Triangle> triangles = voronoi::triangles_of(surface);
  return {std::move(surface.vertices), std::move(triangles), surface.polygons()};
}

Json triangulations(const PointCloud& cloud, bool with_balls) {
  const voronoi::TriangulationSeconds seconds =
      voronoi::time_triangulations(cloud.positions, with_balls);
  return {{"points", seconds.points},
          {"points_here", seconds.points_here},
          {"points_and_poles", seconds.points_and_poles},
          {"bounded_points", seconds.bounded_points},
          {"balls", seconds.balls}};
}

void write_obj(const Made& made, const std::string& path) {
  std::ofstream out(path);
  out.precision(9);
  for (const Vec3 v : made.vertices) out << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
  for (const Triangle& t : made.triangles)
    out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
}

Json facts_of(const Made& made) {
  TriangleMesh mesh;
  mesh.vertices.positions = made.vertices;
  mesh.triangles = made.triangles;
  const MeshFacts facts = mesh_facts(mesh);
  return {{"vertices", facts.vertices},
          {"triangles", facts.triangles},
          {"polygons", made.polygons},
          {"boundary_edges", facts.boundary_edges},
          {"boundary_loops", facts.boundary_loops},
          {"nonmanifold_edges", facts.nonmanifold_edges},
          {"components", facts.components},
          {"euler_characteristic", facts.euler_characteristic}};
}

Json measure(const Options& options) {
  const PointCloud cloud = load(options);
  Json line = {{"method", options.method}, {"points", cloud.size()}};
  std::vector<double> seconds;
  const bool with_balls = options.method == "triangulations";
  if (with_balls || options.method == "delaunay") {
    line["seconds"] = Json::array();
    for (int i = 0; i < options.repeats; ++i)
      line["seconds"].push_back(triangulations(cloud, with_balls));
  } else if (options.method != "none") {
    Made made;
    for (int i = 0; i < options.repeats; ++i) {
      const double begin = cpu_seconds();
      made = make(options, cloud);
      seconds.push_back(cpu_seconds() - begin);
    }
    line["seconds"] = seconds;
    line["peak_memory_bytes"] = peak_memory_bytes();
    line["mesh"] = facts_of(made);
    if (!options.mesh.empty()) write_obj(made, options.mesh);
    return line;
  }
  line["peak_memory_bytes"] = peak_memory_bytes();
  return line;
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  CLI::App app("One method of the comparative study on one model");
  app.add_option("METHOD", options.method)
      ->required()
      ->check(CLI::IsMember({"ball_pivoting", "cocone", "tight_cocone", "crust", "power_crust",
                             "triangulations", "delaunay", "none"}));
  app.add_option("MODEL", options.model)->required();
  app.add_option("--radius", options.radius);
  app.add_option("--noise", options.noise_variance);
  app.add_option("--repeats", options.repeats);
  app.add_option("--mesh", options.mesh);
  CLI11_PARSE(app, argc, argv);
  constexpr std::uint64_t kBudgetBytes = std::uint64_t{8} << 30;
  keep_freed_memory(kBudgetBytes, 1);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::puts(measure(options).dump().c_str());
  return 0;
} catch (const orbweave::Error& error) {
  std::fprintf(stderr, "bench_study: %s\n", error.what());
  return static_cast<int>(error.kind());
}
