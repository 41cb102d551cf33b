#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "bench/quality/fill_discs.h"
#include "bench/quality/fill_workloads.h"
#include "engine/holes/fill_mesh.h"
#include "io/meshes/mesh_reader.h"

namespace orbweave::bench {
namespace {

struct Punched {
  TriangleMesh mesh;
  std::uint64_t holes = 0;
  double mean_rim_edges = 0.0;
};

/// Discs share no vertex with the faces of another, so that each stays a hole of its own.
Punched punch(const TriangleMesh& mesh, const CostWorkload& work) {
  const MeshIndex index(mesh);
  std::mt19937_64 random(work.seed);
  std::vector<bool> taken(mesh.vertices.size(), false);
  std::vector<std::uint32_t> without;
  Punched punched;
  const int most = std::max(10'000, 20 * work.count);
  for (int tries = 0; punched.holes < static_cast<std::uint64_t>(work.count) && tries < most;
       ++tries) {
    const auto center = static_cast<std::uint32_t>(random() % mesh.vertices.size());
    const auto disc = clean_disc(index, center, work.radius_spacings * index.spacing());
    if (!disc) continue;
    std::vector<std::uint32_t> vertices = disc->removed;
    vertices.insert(vertices.end(), disc->rim.begin(), disc->rim.end());
    if (std::any_of(vertices.begin(), vertices.end(), [&](auto v) { return taken[v]; })) continue;
    for (const std::uint32_t v : vertices) taken[v] = true;
    without.insert(without.end(), disc->faces.begin(), disc->faces.end());
    punched.mean_rim_edges += static_cast<double>(disc->rim.size());
    ++punched.holes;
  }
  std::sort(without.begin(), without.end());
  std::vector<std::uint32_t> all(mesh.vertices.size());
  std::iota(all.begin(), all.end(), 0u);
  punched.mesh = cut_part(index, all, without).mesh;
  if (punched.holes > 0) punched.mean_rim_edges /= static_cast<double>(punched.holes);
  return punched;
}

}  // namespace

void run_cost(const CostWorkload& work) {
  const Punched punched = punch(read_mesh(work.mesh), work);
  std::vector<double> seconds, hole_seconds;
  std::uint64_t filled = 0, points = 0;
  for (int r = 0; r < work.repeats; ++r) {
    const auto begin = std::chrono::steady_clock::now();
    const FilledMesh result = fill_mesh(punched.mesh, {});
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    seconds.push_back(spent.count());
    filled = points = 0;
    hole_seconds.push_back(0.0);
    for (const HoleFacts& hole : result.holes) {
      filled += hole.filled ? 1 : 0;
      points += hole.points_added;
      hole_seconds.back() += hole.seconds;
    }
  }
  const nlohmann::json line = {
      {"vertices", punched.mesh.vertices.size()},
      {"holes", punched.holes},
      {"rim_edges", punched.mean_rim_edges},
      {"radius_spacings", work.radius_spacings},
      {"filled", filled},
      {"points_added", points},
      {"seconds", seconds},
      {"hole_seconds", hole_seconds},
  };
  std::puts(line.dump().c_str());
}

}  // namespace orbweave::bench
