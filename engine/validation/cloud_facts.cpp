#include "engine/validation/cloud_facts.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "engine/spacing/automatic_radii.h"
#include "engine/spacing/coordinate_decades.h"
#include "engine/spacing/coordinate_step.h"
#include "engine/validation/usable_scale.h"
#include "partition/count_grid.h"
#include "partition/root_cube.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchPoints = 65536;

std::uint64_t position_hash(Vec3 p) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash += std::bit_cast<std::uint64_t>(p[axis] == 0.0 ? 0.0 : p[axis]) + 0x9E3779B97F4A7C15u;
    hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9u;
    hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EBu;
    hash ^= hash >> 31;
  }
  return hash;
}

/// What is gathered while the cloud streams by; lists stop growing at their limits.
struct Gathered {
  CountGrid grid;
  std::vector<Vec3> whole;
  std::vector<std::uint64_t> hashes;

  void add(std::span<const Vec3> finite, const CloudFactsOptions& options) {
    grid.add(finite);
    if (grid.points() <= options.whole_spacing_points)
      whole.insert(whole.end(), finite.begin(), finite.end());
    else
      std::vector<Vec3>().swap(whole);
    if (grid.points() <= options.duplicate_points)
      for (const Vec3& p : finite) hashes.push_back(position_hash(p));
    else
      std::vector<std::uint64_t>().swap(hashes);
  }
};

/// Keeps the finite positions of a batch.
std::vector<Vec3> finite_positions(const PointCloud& batch) {
  std::vector<Vec3> finite;
  finite.reserve(batch.size());
  std::copy_if(batch.positions.begin(), batch.positions.end(), std::back_inserter(finite),
               is_finite);
  return finite;
}

void gather(PointSource& source, const CloudFactsOptions& options, CloudFacts& facts,
            Gathered& gathered) {
  AttributeGatherer values(source.schema());
  PointCloud batch;
  while (source.read(batch, kBatchPoints)) {
    const std::vector<Vec3> finite = finite_positions(batch);
    values.add(batch);
    facts.points += batch.size();
    facts.not_finite += batch.size() - finite.size();
    for (const Vec3& n : batch.normals) {
      facts.zero_normals += n == Vec3{};
      facts.normals_not_finite += !is_finite(n);
    }
    if (!finite.empty()) gathered.add(finite, options);
  }
  facts.values = values.facts();
}

std::uint64_t count_duplicates(std::vector<std::uint64_t>& hashes) {
  tbb::parallel_sort(hashes.begin(), hashes.end());
  std::uint64_t duplicates = 0;
  for (std::size_t i = 1; i < hashes.size(); ++i) duplicates += hashes[i] == hashes[i - 1];
  return duplicates;
}

void measure_spacing(std::span<const SpacingSite> of_cloud, CloudFacts& facts) {
  constexpr std::size_t kNeighbors = 6;
  facts.doubt = objection_to_scale(facts.bounds);
  if (!facts.doubt.empty()) return;
  facts.doubt = objection_to_decades(coordinate_decades(of_cloud));
  if (!facts.doubt.empty()) return;
  const SearchedSites sites(of_cloud);
  const SampledNeighbors sample(sites, kNeighbors);
  const auto median = [&](std::size_t neighbors) -> std::optional<double> {
    const std::vector<double> distances = neighbor_distances(sample, neighbors);
    if (distances.empty()) return std::nullopt;
    return distances[(distances.size() - 1) / 2];
  };
  facts.coordinate_step = coordinate_step(sites.all());
  facts.spacing = median(1);
  facts.spacing_of_six = median(kNeighbors);
  facts.common_step = common_step(sites.all());
  const double spacing = facts.spacing_of_six.value_or(0.0);
  facts.doubt = objection_to_step(facts.coordinate_step, spacing);
  if (facts.doubt.empty()) facts.doubt = objection_to_common_step(facts.common_step, spacing);
}

void measure_whole(std::vector<Vec3> points, CloudFacts& facts) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const Box everything{{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  const SpacingSite whole{everything, everything, std::move(points)};
  measure_spacing({&whole, 1}, facts);
}

void measure_sites(PointSource& again, CountGrid& grid, CloudFacts& facts) {
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  SpacingSampler sampler(root, grid);
  PointCloud batch;
  while (again.read(batch, kBatchPoints)) sampler.add(finite_positions(batch));
  measure_spacing(sampler.sites(), facts);
}

}  // namespace

CloudFacts cloud_facts(PointSource& source, PointSource* again, const CloudFactsOptions& options) {
  CloudFacts facts;
  facts.has_normals = source.schema().has_normals;
  facts.position_type = source.schema().position_type;
  facts.attributes = source.schema().attributes;
  Gathered gathered;
  gather(source, options, facts, gathered);
  facts.file = source.facts();
  facts.left_out = source.left_out();
  facts.coordinate_system = source.coordinate_system();
  facts.meters_per_unit = source.meters_per_unit();
  const std::uint64_t finite = gathered.grid.points();
  if (finite > 0) facts.bounds = gathered.grid.bounds();
  if (finite <= options.duplicate_points) facts.duplicates = count_duplicates(gathered.hashes);
  if (finite <= options.whole_spacing_points)
    measure_whole(std::move(gathered.whole), facts);
  else if (again != nullptr)
    measure_sites(*again, gathered.grid, facts);
  return facts;
}

}  // namespace orbweave
