// Estimated and oriented normals against the known ones: share of points whose sign agrees, angle
// error, CPU seconds; whole and cut into chunks with exactly the halo that is stated. One JSON line
// out. usage: bench_orientation CLOUD [CHUNKS] [THREADS] [CELL]
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "engine/geometry/point_tree.h"
#include "engine/normals/estimate_normals.h"
#include "engine/normals/orientation.h"
#include "io/box.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/points/point_source.h"
#include "partition/canonical_order.h"

namespace {

using orbweave::PointCloud;
using orbweave::Vec3;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Median distance to the sixth neighbour of a thousand points, as in a hexagonal grid.
double spacing_of(const std::vector<Vec3>& positions) {
  const orbweave::PointTree tree(positions);
  std::vector<orbweave::Neighbor> found;
  std::vector<double> distances;
  for (std::size_t i = 0; i < positions.size(); i += 1 + positions.size() / 1000) {
    tree.nearest(positions[i], 7, found);
    distances.push_back(std::sqrt(found.back().squared_distance));
  }
  std::sort(distances.begin(), distances.end());
  return distances[distances.size() / 2] * std::sqrt(std::numbers::pi / 7.0);
}

struct Found {
  std::vector<Vec3> normals;
  std::size_t patches = 0;
  orbweave::PatchOrientation graph;
  double normal_seconds = 0.0, patch_seconds = 0.0, graph_seconds = 0.0;
};

/// One chunk: owned points [begin, end) and everything in their box widened by `halo`.
struct Chunk {
  std::vector<std::uint32_t> rows;
  std::uint32_t begin = 0, end = 0;

  Chunk(const std::vector<Vec3>& positions, std::uint32_t first, std::uint32_t last, double halo) {
    orbweave::Box box;
    for (std::uint32_t i = first; i < last; ++i) box.extend(positions[i]);
    const Vec3 margin{halo, halo, halo};
    const Vec3 low = box.min - margin, high = box.max + margin;
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
      if (i == first) begin = static_cast<std::uint32_t>(rows.size());
      const Vec3 p = positions[i];
      if (low.x <= p.x && p.x <= high.x && low.y <= p.y && p.y <= high.y && low.z <= p.z &&
          p.z <= high.z)
        rows.push_back(i);
    }
    end = begin + (last - first);
  }
  template <class T>
  std::vector<T> of(const std::vector<T>& whole) const {
    std::vector<T> part;
    part.reserve(rows.size());
    for (const std::uint32_t row : rows) part.push_back(whole[row]);
    return part;
  }
};

template <class T>
void append(std::vector<T>& to, const std::vector<T>& rows) {
  to.insert(to.end(), rows.begin(), rows.end());
}

/// `cell`: side of the patches' cells; 0: from the spacing.
Found run(const std::vector<Vec3>& positions, std::uint32_t chunks, double spacing, double cell) {
  const auto size = static_cast<std::uint32_t>(positions.size());
  const auto begin_of = [&](std::uint32_t chunk) {
    return static_cast<std::uint32_t>(std::uint64_t{chunk} * size / chunks);
  };
  const orbweave::NormalEstimateOptions normals{16, 8.0 * spacing};
  orbweave::OrientationOptions options;
  options.cell = cell > 0.0 ? cell : std::exp2(std::round(std::log2(14.0 * spacing)));
  options.max_radius = 8.0 * spacing;
  std::vector<std::uint64_t> global(size);
  std::iota(global.begin(), global.end(), std::uint64_t{0});
  Found found;
  for (std::uint32_t c = 0; c < chunks; ++c) {
    const Chunk chunk(positions, begin_of(c), begin_of(c + 1), normals.max_radius);
    const std::vector<Vec3> part = chunk.of(positions);
    const double begin = cpu_seconds();
    append(found.normals,
           orbweave::estimate_normals(part, chunk.begin, chunk.end, normals).normals);
    found.normal_seconds += cpu_seconds() - begin;
  }
  orbweave::OrientedPatches all;
  for (std::uint32_t c = 0; c < chunks; ++c) {
    const Chunk chunk(positions, begin_of(c), begin_of(c + 1), orbweave::orientation_halo(options));
    const std::vector<Vec3> part = chunk.of(positions), directions = chunk.of(found.normals);
    const std::vector<std::uint64_t> numbers = chunk.of(global);
    const double begin = cpu_seconds();
    const orbweave::OrientedPatches patches =
        orbweave::orient_patches(part, directions, numbers, chunk.begin, chunk.end, options);
    found.patch_seconds += cpu_seconds() - begin;
    append(all.patch_of, patches.patch_of);
    append(all.turn, patches.turn);
    append(all.sums, patches.sums);
    append(all.votes, patches.votes);
  }
  const double begin = cpu_seconds();
  found.patches = all.sums.size();
  found.graph = orbweave::orient_patch_graph(std::move(all.sums), std::move(all.votes),
                                             {.cell = options.cell});
  found.graph_seconds = cpu_seconds() - begin;
  for (std::uint32_t i = 0; i < size; ++i) {
    const auto& ids = found.graph.patches;
    const auto at = std::lower_bound(ids.begin(), ids.end(), all.patch_of[i]);
    if (at == ids.end() || *at != all.patch_of[i]) continue;
    if (all.turn[i] ^ found.graph.turn[at - ids.begin()]) found.normals[i] = -found.normals[i];
  }
  return found;
}

/// The components of at least a hundredth of the surface, and what was found on both sides of them.
nlohmann::json parts_of(const orbweave::PatchOrientation& graph) {
  double total = 0.0;
  for (const orbweave::OrientedPart& part : graph.parts) total += part.shape.area;
  nlohmann::json parts = nlohmann::json::array();
  for (const orbweave::OrientedPart& part : graph.parts) {
    if (part.shape.area < 0.01 * total) continue;
    const orbweave::PartSpace& space = part.space;
    parts.push_back({{"part", part.shape.first},
                     {"area", part.shape.area / total},
                     {"surface", part.shape.surface / total},
                     {"kind", static_cast<int>(part.shape.kind)},
                     {"side", static_cast<int>(part.side)},
                     {"doubt", static_cast<int>(part.doubt)},
                     {"openness", part.shape.openness},
                     {"bulge", part.is_turned ? -part.shape.bulge : part.shape.bulge},
                     {"shut", space.shut / space.area},
                     {"farther_front", space.farther_front / space.area},
                     {"farther_back", space.farther_back / space.area},
                     {"open_front", space.open_front},
                     {"open_back", space.open_back},
                     {"density", {part.density.even, part.density.inside, part.density.outside}}});
  }
  return parts;
}

nlohmann::json report(const Found& found, const PointCloud& cloud) {
  std::size_t agree = 0, none = 0;
  double angles = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double cosine = dot(found.normals[i], cloud.normals[i]);
    agree += cosine > 0.0;
    none += found.normals[i] == Vec3{};
    angles += std::acos(std::min(std::abs(cosine), 1.0));
  }
  const auto points = static_cast<double>(cloud.size());
  return {{"points", cloud.size()},
          {"agree", static_cast<double>(agree) / points},
          {"disagree", cloud.size() - agree},
          {"without_normal", none},
          {"mean_angle_degrees", angles / points * 180.0 / std::numbers::pi},
          {"patches", found.patches},
          {"components", found.graph.components},
          {"contested", found.graph.contested},
          {"contested_area", found.graph.contested_area},
          {"doubtful_area", found.graph.doubtful_area},
          {"weak_joins", found.graph.weak.size()},
          {"parts", parts_of(found.graph)},
          {"satisfied", found.graph.satisfied},
          {"normal_seconds", found.normal_seconds},
          {"patch_seconds", found.patch_seconds},
          {"graph_seconds", found.graph_seconds}};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fputs("usage: bench_orientation CLOUD [CHUNKS] [THREADS] [CELL]\n", stderr);
    return 2;
  }
  const auto chunks = static_cast<std::uint32_t>(argc > 2 ? std::stoul(argv[2]) : 1);
  const int threads = argc > 3 ? std::stoi(argv[3]) : 1;
  const double cell = argc > 4 ? std::stod(argv[4]) : 0.0;
  PointCloud cloud = orbweave::read_all(*orbweave::open_point_source(argv[1]));
  if (cloud.normals.empty() || cloud.size() < 8) {
    std::fputs("bench_orientation: the cloud must have normals and at least 8 points\n", stderr);
    return 1;
  }
  orbweave::sort_canonically(cloud, orbweave::root_cube(cloud.bounds()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  const double spacing = spacing_of(cloud.positions);
  const Found whole = run(cloud.positions, 1, spacing, cell);
  nlohmann::json line = report(whole, cloud);
  line["spacing"] = spacing;
  line["threads"] = threads;
  if (chunks > 1) {
    const Found parts = run(cloud.positions, chunks, spacing, cell);
    line["chunks"] = chunks;
    line["same_in_chunks"] = parts.normals == whole.normals;
  }
  std::printf("%s\n", line.dump().c_str());
  return 0;
} catch (const orbweave::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
