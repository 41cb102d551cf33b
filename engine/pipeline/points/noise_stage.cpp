#include "engine/pipeline/points/noise_stage.h"

#include <algorithm>
#include <array>
#include <utility>

#include "engine/pipeline/stage/cleaning_rule.h"
#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "engine/spacing/site_points.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr const char* kNoiseStage = directory_of(Stage::kNoise);
/// Where a smaller part of the places is thick, the scan is clean: edges look like noise.
constexpr double kLeastPart = 0.02;

static_assert(sizeof(NoisePlace) == 5 * sizeof(double), "stored as rows of five numbers");

void commit_places(ChunkStore& store, ChunkId chunk, const std::vector<NoisePlace>& places) {
  const std::array<ArrayView, 1> arrays = {
      ArrayView{"places", ScalarType::kFloat64, 5, places.size(), places.data()}};
  store.commit(kNoiseStage, chunk, arrays);
}

/// Every member has to know all of them.
std::vector<NoisePlace> all_places(const StageRunner& runner, const RawCloud& cloud) {
  std::vector<NoisePlace> all;
  for (ChunkId chunk = 0; chunk < cloud.partition.octree.chunks().size(); ++chunk) {
    runner.stop.check();
    const std::vector<NoisePlace> places =
        runner.store.open(kNoiseStage, chunk)->read_all<NoisePlace>("places");
    all.insert(all.end(), places.begin(), places.end());
  }
  return all;
}

void measure_chunks(StageRunner& runner, const RawCloud& cloud, const NoisePlaceOptions& options) {
  by_root(runner, [&] {
    begin_stage(runner, kNoiseStage,
                cloud.key + key_line("layout of noise", "1") +
                    key_line("cubes of noise", format_exact(options.cell)) +
                    key_line("reach of noise", format_exact(options.reach)));
  });
  require_points_for(runner, cloud, kNoiseStage);
  visit_chunks(
      runner, cloud, kNoiseStage, noise_halo(options), [&](ChunkId chunk, PassPoints&& points) {
        commit_places(runner.store, chunk,
                      measure_noise_places(points.positions, points.begin, points.end, options));
      });
}

std::string percent_of(double share) { return short_text(100.0 * share) + " %"; }

/// What was found place by place.
void describe_places(const Job& job, const SmoothingLevels& levels, CleaningFacts& facts) {
  const std::span<const double> radii = levels.radii();
  facts.untouched_share = levels.untouched_share();
  if (1.0 - facts.untouched_share < kLeastPart) {
    facts.options = job.cleaning;  // what the job asks for by number
    facts.is_local = false;
    facts.least_radius = facts.most_radius = 0.0;
    facts.reason += "; measured place by place, " + percent_of(facts.untouched_share) +
                    " of the places are thin layers: no cleaning";
    return;
  }
  facts.least_radius = radii[1];
  facts.most_radius = radii.back();
  facts.reason += "; place by place, radii from " + short_text(radii[1]) + " to " +
                  short_text(radii.back()) + ", and nothing is moved at " +
                  percent_of(facts.untouched_share) + " of the places, which are thin layers";
}

}  // namespace

std::vector<std::uint8_t> LocalCleaning::levels_of(std::span<const Vec3> positions) const {
  if (levels == nullptr) return std::vector<std::uint8_t>(positions.size(), 1);
  return levels->at(positions);
}

std::vector<LocalNoise> LocalCleaning::noise_of(std::span<const Vec3> positions) const {
  if (noise == nullptr) return std::vector<LocalNoise>(positions.size());
  return noise->noise_at(positions);
}

std::string LocalCleaning::key() const {
  std::string text = levels == nullptr ? "everywhere:" : "place by place:";
  for (const double radius : radii) text += " " + format_exact(radius);
  return text;
}

LocalCleaning local_cleaning(StageRunner& runner, const RawCloud& cloud, CleaningFacts& facts) {
  LocalCleaning local;
  local.radii = {0.0, facts.options.smooth_radius};
  local.spacings = {0.0, facts.options.thin_to_spacing};
  const bool is_wanted = runner.job.output.vertex_quality && cloud.partition.layers.spacing > 0.0;
  if (!facts.is_local && !is_wanted) return local;
  NoisePlaceOptions options = noise_options(cloud.partition);
  options.stop = &runner.stop;
  measure_chunks(runner, cloud, options);
  local.noise = std::make_shared<const SmoothingLevels>(all_places(runner, cloud), options.cell,
                                                        whole_cloud_noise(cloud.partition.layers),
                                                        &runner.stop);
  if (!facts.is_local) return local;
  describe_places(runner.job, *local.noise, facts);
  if (!facts.is_local) {
    local.radii = {0.0, 0.0};
    local.spacings = {0.0, facts.options.thin_to_spacing};
    return local;
  }
  local.levels = local.noise;
  const std::span<const double> radii = local.levels->radii();
  local.radii.assign(radii.begin(), radii.end());
  local.spacings.clear();
  for (const double radius : radii) local.spacings.push_back(kThinningPerRadius * radius);
  return local;
}

}  // namespace orbweave
