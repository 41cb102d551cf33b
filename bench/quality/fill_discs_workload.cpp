#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "bench/peers/fill_cgal.h"
#include "bench/quality/fill_patch.h"
#include "bench/quality/fill_workloads.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"

namespace orbweave::bench {
namespace {

using nlohmann::json;

json facts_of(const Patch& patch, const PatchQuality& quality, double spacing) {
  return {{"filled", patch.filled},
          {"closed", quality.closed},
          {"method", patch.method},
          {"reason", patch.reason},
          {"sites", patch.sites},
          {"rim_mean_deg", patch.rim_mean_deg},
          {"confidence", patch.confidence},
          {"new_points", patch.positions.size()},
          {"triangles", patch.triangles.size()},
          {"rms", quality.rms / spacing},
          {"max", quality.max / spacing},
          {"back_rms", quality.back_rms / spacing},
          {"back_max", quality.back_max / spacing},
          {"normal_mean_deg", quality.normal_mean_deg},
          {"normal_max_deg", quality.normal_max_deg},
          {"rim_dihedral_deg", quality.rim_dihedral_deg},
          {"self_intersections", quality.self_intersections},
          {"seconds", patch.seconds}};
}

/// Largest angle's cosine between a removed vertex's normal and their mean: how far from a plane
/// the piece was.
double least_normal_cosine(const MeshIndex& index, const Disc& disc) {
  Vec3 mean;
  for (const std::uint32_t v : disc.removed) mean = mean + index.normals()[v];
  mean = normalized(mean);
  double least = 1.0;
  for (const std::uint32_t v : disc.removed) least = std::min(least, dot(mean, index.normals()[v]));
  return least;
}

/// What was cut out, as a patch.
Patch removed_patch(const MeshIndex& index, const Disc& disc) {
  const std::vector<Vec3>& positions = index.mesh().vertices.positions;
  Patch patch;
  for (const std::uint32_t v : disc.removed) patch.positions.push_back(positions[v]);
  for (const std::uint32_t f : disc.faces) {
    Triangle t = index.mesh().triangles[f];
    for (std::uint32_t& v : t) {
      const auto at = std::lower_bound(disc.removed.begin(), disc.removed.end(), v);
      if (at == disc.removed.end() || *at != v) continue;
      v = static_cast<std::uint32_t>(positions.size() + (at - disc.removed.begin()));
    }
    patch.triangles.push_back(t);
  }
  return patch;
}

/// Where the meshes of a hole go; empty: nowhere.
std::string case_stem(const DiscWorkload& work, const Disc& disc, double radius_spacings) {
  if (work.cases.empty()) return {};
  std::filesystem::create_directories(work.cases);
  const std::string name = std::filesystem::path(work.mesh).stem().string() + "-" +
                           std::to_string(static_cast<int>(radius_spacings)) + "-" +
                           std::to_string(disc.center);
  return (std::filesystem::path(work.cases) / name).string();
}

void write_patches(const std::string& stem, const MeshIndex& index, const Disc& disc,
                   const Patch& ours, const Patch& theirs) {
  write_mesh(stem + "-engine.ply", patch_mesh(index, ours));
  write_mesh(stem + "-cgal.ply", patch_mesh(index, theirs));
  write_mesh(stem + "-removed.ply", patch_mesh(index, removed_patch(index, disc)));
}

/// The engine gathers within `neighborhood` radii of the rim's centre; a little more lies here, so
/// that it sees what it would see in the whole mesh.
Cut surroundings(const MeshIndex& index, const Disc& disc, double radius, double neighborhood) {
  const double reach = std::max(2.0, neighborhood) * 1.6 * radius + 10.0 * index.spacing();
  return cut_part(index, connected_within(index, disc.center, reach), disc.faces);
}

void refill(const MeshIndex& index, const Disc& disc, double radius_spacings,
            const DiscWorkload& work) {
  const double radius = radius_spacings * index.spacing();
  const Cut around = surroundings(index, disc, radius, work.neighborhood);
  const std::string stem = case_stem(work, disc, radius_spacings);
  if (!stem.empty()) write_mesh(stem + "-hole.ply", around.mesh);
  FillOptions options;
  options.kernel =
      work.kernel == "triharmonic" ? FillKernel::kTriharmonic : FillKernel::kBiharmonic;
  options.neighborhood = work.neighborhood;
  options.max_edges = disc.rim.size();  // the border of the part is longer
  options.keep_outer_border = false;
  const Patch ours = fill_by_engine(index, disc, around, options);
  const Patch theirs = fill_by_cgal(index, disc, around, work.cgal_continuity);
  const json line = {
      {"mesh", std::filesystem::path(work.mesh).filename().string()},
      {"spacing", index.spacing()},
      {"radius_spacings", radius_spacings},
      {"center", disc.center},
      {"removed_points", disc.removed.size()},
      {"measured_points", measured_points(index, disc).size()},
      {"rim_edges", disc.rim.size()},
      {"least_normal_cosine", least_normal_cosine(index, disc)},
      {"removed_intersections",
       quality_of(index, disc, removed_patch(index, disc)).self_intersections},
      {"engine", facts_of(ours, quality_of(index, disc, ours), index.spacing())},
      {"cgal", facts_of(theirs, quality_of(index, disc, theirs), index.spacing())},
  };
  std::puts(line.dump().c_str());
  std::fflush(stdout);
  if (!stem.empty()) write_patches(stem, index, disc, ours, theirs);
}

/// At least half of the disc must be scan, where an earlier fill has closed the scan's own holes.
std::optional<Disc> usable_disc(const MeshIndex& index, std::uint32_t center, double radius) {
  if (!index.in_main_component(center) || !index.is_scanned(center)) return std::nullopt;
  std::optional<Disc> disc = clean_disc(index, center, radius);
  if (disc && 2 * measured_points(index, *disc).size() < disc->removed.size()) disc.reset();
  return disc;
}

}  // namespace

void run_discs(const DiscWorkload& work) {
  const TriangleMesh mesh = read_mesh(work.mesh);
  const MeshIndex index(mesh);
  for (const double radius_spacings : work.radii_spacings) {
    const double radius = radius_spacings * index.spacing();
    for (const std::uint32_t center : work.centers) {
      const std::optional<Disc> disc = clean_disc(index, center, radius);
      if (disc) refill(index, *disc, radius_spacings, work);
    }
    if (!work.centers.empty()) continue;
    std::mt19937_64 random(work.seed);
    int done = 0;
    for (int tries = 0; done < work.count && tries < 400 * work.count; ++tries) {
      const auto center = static_cast<std::uint32_t>(random() % mesh.vertices.size());
      const std::optional<Disc> disc = usable_disc(index, center, radius);
      if (!disc) continue;
      refill(index, *disc, radius_spacings, work);
      ++done;
    }
  }
}

}  // namespace orbweave::bench
