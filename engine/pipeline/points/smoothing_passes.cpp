#include "engine/pipeline/points/smoothing_passes.h"

#include <algorithm>
#include <utility>

#include "engine/cleaning/local_cleaning.h"
#include "engine/pipeline/points/quality_pass.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "io/job/job_keys.h"
#include "io/job/setting.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

std::vector<std::uint32_t> kept_rows(const std::vector<std::uint8_t>& kept) {
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < kept.size(); ++i)
    if (kept[i] != 0) rows.push_back(i);
  return rows;
}

void normalize_all(std::vector<Vec3>& normals) {
  for (Vec3& normal : normals) normal = normalized(normal);
}

ProjectionOptions projection_of(const StageRunner& runner, const LocalCleaning& cleaning,
                                bool oriented) {
  return {cleaning.largest_radius(), oriented, &runner.stop,
          setting_name(runner.job, "cleaning.smooth_radius")};
}

ThinningOptions thinning_of(const StageRunner& runner, const LocalCleaning& cleaning) {
  return {cleaning.spacings.back(), kSameSheetCosine, &runner.stop};
}

LeveledPoints leveled(const PassPoints& points, const std::vector<std::uint8_t>& levels) {
  return {points.positions, points.normals, points.begin, points.end, levels};
}

/// Which of the chunk's own points stay. Normals without a side do not tell sheets apart.
std::vector<std::uint8_t> thinned(const PassPoints& points, const LocalCleaning& cleaning,
                                  const std::vector<std::uint8_t>& levels,
                                  const ThinningOptions& thinning, bool oriented) {
  LeveledPoints of_pass = leveled(points, levels);
  if (!oriented) of_pass.normals = {};
  return thin_locally(of_pass, cleaning.spacings, thinning);
}

void project(PassPoints& points, const LocalCleaning& cleaning,
             const std::vector<std::uint8_t>& levels, const ProjectionOptions& projection,
             std::span<const std::uint8_t> chosen = {}) {
  ProjectedPoints projected =
      project_locally(leveled(points, levels), cleaning.radii, projection, chosen);
  add_moves(points.own, projected.positions);
  points.own.positions = std::move(projected.positions);
  points.own.normals = std::move(projected.normals);
}

std::string key_of(const LocalCleaning& cleaning, bool oriented) {
  return key_line(stored_key_name("cleaning.smooth_radius"), cleaning.key()) +
         key_line("oriented", oriented ? "yes" : "no");
}

std::string thinning_key(const LocalCleaning& cleaning) {
  return key_line(stored_key_name("cleaning.thin_to_spacing"),
                  format_exact(cleaning.spacings.back()));
}

}  // namespace

RawPass smooth_pass(const StageRunner& runner, const LocalCleaning& cleaning, bool oriented,
                    int pass) {
  const ProjectionOptions projection = projection_of(runner, cleaning, oriented);
  return {.stage = directory_of(Stage::kSmoothing, pass + 1),
          .options = key_of(cleaning, oriented),
          .halo = local_projection_halo(cleaning.radii, projection),
          .drift = cleaning.largest_radius(),
          .work = [cleaning, projection](PassPoints&& points) {
            normalize_all(points.normals);
            project(points, cleaning, cleaning.levels_of(points.positions), projection);
            return PassResult{std::move(points.own)};
          }};
}

RawPass thin_pass(const StageRunner& runner, const LocalCleaning& cleaning, bool oriented) {
  const ThinningOptions thinning = thinning_of(runner, cleaning);
  return {.stage = directory_of(Stage::kThinning),
          .options = thinning_key(cleaning) + key_line("oriented", oriented ? "yes" : "no"),
          .halo = local_thinning_halo(cleaning.spacings),
          .dropped_reason = DropReason::kThinned,
          .work = [cleaning, thinning, oriented](PassPoints&& points) {
            normalize_all(points.normals);
            const auto levels = cleaning.levels_of(points.positions);
            const auto kept = thinned(points, cleaning, levels, thinning, oriented);
            return PassResult{kept_points(std::move(points.own), kept)};
          }};
}

RawPass thin_and_smooth_pass(const StageRunner& runner, const LocalCleaning& cleaning,
                             bool oriented) {
  const ProjectionOptions projection = projection_of(runner, cleaning, oriented);
  const ThinningOptions thinning = thinning_of(runner, cleaning);
  return {.stage = directory_of(Stage::kThinning),
          .options = thinning_key(cleaning) + key_of(cleaning, oriented),
          .halo = std::max(local_thinning_halo(cleaning.spacings),
                           local_projection_halo(cleaning.radii, projection)),
          .drift = cleaning.largest_radius(),
          .dropped_reason = DropReason::kThinned,
          .work = [cleaning, thinning, projection, oriented](PassPoints&& points) {
            normalize_all(points.normals);
            const auto levels = cleaning.levels_of(points.positions);
            const auto kept = thinned(points, cleaning, levels, thinning, oriented);
            project(points, cleaning, levels, projection, kept);
            return PassResult{kept_points(std::move(points.own), kept), kept_rows(kept)};
          }};
}

}  // namespace orbweave
