// Ball pivoting alone: points per second and core on an oriented cloud, positions in canonical
// order in memory, one JSON line out. CPU seconds, so that a busy machine disturbs little.
// usage: bench_kernel CLOUD RADIUS[,RADIUS...] [REPEATS] [THREADS]
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <time.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/points/point_source.h"
#include "partition/canonical_order.h"

namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<double> numbers(std::string_view text) {
  std::vector<double> values;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    double value = 0.0;
    std::from_chars(text.data(), text.data() + comma, value);
    values.push_back(value);
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return values;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::fputs("usage: bench_kernel CLOUD RADIUS[,RADIUS...] [REPEATS] [THREADS]\n", stderr);
    return 2;
  }
  const int repeats = argc > 3 ? std::stoi(argv[3]) : 5;
  const int threads = argc > 4 ? std::stoi(argv[4]) : 1;
  orbweave::PointCloud cloud = orbweave::read_all(*orbweave::open_point_source(argv[1]));
  const orbweave::RootCube root = orbweave::root_cube(cloud.bounds());
  orbweave::sort_canonically(cloud, root);
  const orbweave::BallPivotingOptions options{numbers(argv[2])};
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  std::vector<double> cpu, wall;
  std::size_t triangles = 0, boundary_edges = 0;
  for (int r = 0; r < repeats; ++r) {
    const double cpu_begin = cpu_seconds(), wall_begin = wall_seconds();
    arena.execute([&] {
      const auto result = orbweave::ball_pivoting(cloud.positions, cloud.normals, {}, options);
      triangles = result.triangles.size();
      boundary_edges = result.boundary.size();
    });
    cpu.push_back(cpu_seconds() - cpu_begin);
    wall.push_back(wall_seconds() - wall_begin);
  }
  std::vector<double> sorted = cpu;
  std::sort(sorted.begin(), sorted.end());
  const nlohmann::json line = {
      {"points", cloud.size()},
      {"threads", threads},
      {"cpu_seconds", cpu},
      {"wall_seconds", wall},
      {"points_per_second_and_core", static_cast<double>(cloud.size()) / sorted[sorted.size() / 2]},
      {"triangles", triangles},
      {"boundary_edges", boundary_edges},
  };
  std::puts(line.dump().c_str());
  return 0;
} catch (const orbweave::Error& error) {
  std::fprintf(stderr, "bench_kernel: %s\n", error.what());
  return static_cast<int>(error.kind());
}
