#include "engine/pipeline/surface/in_core_methods.h"

#include <algorithm>
#include <utility>

#include "engine/pipeline/stage/method_costs.h"
#include "engine/stitching/triangle_fans.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/system/memory_watch.h"
#include "io/text/quantity.h"

#ifdef ORBWEAVE_HAS_VORONOI
#include "engine/voronoi/voronoi.h"
#endif

namespace orbweave {
namespace {

#ifdef ORBWEAVE_HAS_VORONOI
/// Triangles, and flags of the points that are sampled too sparsely.
struct Found {
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> undersampled;
};

Found found_by(voronoi::PointSurface surface) {
  for (std::uint8_t& flag : surface.well_sampled) flag ^= 1;
  return {std::move(surface.triangles), std::move(surface.well_sampled)};
}

Found find_by(ReconstructionMethod method, std::span<const Vec3> positions, const StopToken* stop,
              const voronoi::ShareDone& done) {
  constexpr voronoi::CrustOptions kCrust{.filters = false, .extracts_manifold = true};
  if (method == ReconstructionMethod::kCrust)
    return found_by(voronoi::crust(positions, kCrust, stop, done));
  if (is_cocone(method)) return found_by(voronoi::cocone(positions, {}, stop, done));
  return found_by(voronoi::tight_cocone(positions, stop, done));
}

CoconeOfPart find_part(std::span<const Vec3> positions, std::span<const Vec3> normals,
                       const Box& known, const Box& cloud, const StopToken* stop) {
  voronoi::CoconePart part = voronoi::cocone_of_part(positions, normals, {known, cloud}, stop);
  Found found = found_by(std::move(part.surface));
  return {std::move(found.triangles), std::move(found.undersampled), std::move(part.certified)};
}

voronoi::PowerCrustSurface power_crust_of(std::span<const Vec3> positions, const StopToken* stop,
                                          const voronoi::ShareDone& done) {
  return voronoi::power_crust(positions, {}, stop, done);
}

std::vector<Triangle> triangles_of_crust(const voronoi::PowerCrustSurface& surface) {
  return voronoi::triangles_of(surface);
}

voronoi::Undersampling undersampling_of(std::span<const Vec3> positions, const StopToken* stop) {
  return voronoi::find_undersampling(positions, stop);
}

std::vector<Vec3> poles_of(std::span<const Vec3> positions, const StopToken* stop,
                           const voronoi::ShareDone& done) {
  return voronoi::pole_normals(positions, stop, done);
}
#else
struct Found {
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> undersampled;
};

Found find_by(ReconstructionMethod, std::span<const Vec3>, const StopToken*,
              const voronoi::ShareDone&) {
  return {};
}

CoconeOfPart find_part(std::span<const Vec3>, std::span<const Vec3>, const Box&, const Box&,
                       const StopToken*) {
  return {};
}

voronoi::PowerCrustSurface power_crust_of(std::span<const Vec3>, const StopToken*,
                                          const voronoi::ShareDone&) {
  return {};
}

std::vector<Triangle> triangles_of_crust(const voronoi::PowerCrustSurface&) { return {}; }

voronoi::Undersampling undersampling_of(std::span<const Vec3>, const StopToken*) { return {}; }

std::vector<Vec3> poles_of(std::span<const Vec3>, const StopToken*, const voronoi::ShareDone&) {
  return {};
}
#endif

[[noreturn]] void refuse_family(ErrorParts parts) {
  parts.advice = "Install CGAL (libcgal-dev) and build again; the program is under the GPL then";
  throw_usage("this program was built without the methods of the Voronoi family", parts);
}

void require_normal_source(const Job& job) {
  if (job.normals.source != NormalSource::kPoles || has_voronoi_family()) return;
  refuse_family({.place = setting_name(job, "normals.source"),
                 .found = "poles",
                 .expected = "auto, file or estimate"});
}

/// Where sampling is too sparse, only some methods find out.
void require_told_undersampling(const Job& job) {
  const bool is_drawn = job.output.picture_colors == PictureColors::kUndersampled;
  if (!(is_drawn || job.output.vertex_undersampled) || tells_undersampling(job.reconstruct.method))
    return;
  throw_usage("the method does not find out where the scan is undersampled",
              {.place = is_drawn ? setting(job, "output.picture_colors", "undersampled")
                                 : setting(job, "output.vertex_undersampled", "true"),
               .found = setting(job, "reconstruct.method", method_name(job)),
               .expected = "cocone, super_cocone or tight_cocone",
               .advice = "orbweave inspect --undersampled lists the places of any cloud"});
}

/// The least that a method holds at its peak, over what it holds when `share` of it is done.
double least_growth(ReconstructionMethod method, double share) {
  // A triangulation is read out into arrays of half its size before it goes.
  if (!is_cocone(method) && method != ReconstructionMethod::kTightCocone) return 1.5;
  // The insertion holds 36 bytes per tetrahedron, what follows 57, and facets or stars beside them.
  // Measured: 1.75 to 3.4 times the insertion, 1.37 to 1.95 times the cells; after the arrays,
  // Tight Cocone holds 1.1 to 1.3 times as much.
  if (share < voronoi::kCellsOfCocone) return 1.7;
  if (share < voronoi::kArraysOfCocone) return 1.3;
  return is_cocone(method) ? 1.0 : 1.1;
}

/// A part of a job that grows as the shape of the cloud has it.
struct GrowingPart {
  std::string name;         ///< "the method crust"
  double least_growth = 1;  ///< of what is held now
  std::string instead;      ///< what takes less memory
};

GrowingPart part_of(const Job& job, double share) {
  return {"the method " + method_name(job), least_growth(job.reconstruct.method, share),
          setting(job, "reconstruct.method", "ball_pivoting")};
}

/// Throws where the process will hold more than the job's budget. `before`: bytes held when the
/// part began; `share` of it is done.
void require_budget(const Job& job, const GrowingPart& part, std::uint64_t before, double share) {
  const std::uint64_t budget = job.partition.memory_bytes;
  const auto needed = [&] {
    const auto grown = static_cast<double>(std::max(resident_bytes(), before) - before);
    return before + static_cast<std::uint64_t>(part.least_growth * grown);
  };
  if (needed() <= budget) return;
  release_freed_memory();
  const std::uint64_t most = needed();
  if (most <= budget) return;
  throw_resource(
      part.name + " outgrows the memory budget",
      {.place = setting_name(job, "partition.memory"),
       .found = format_count((most >> 20) + 1) + " MiB needed or more, with " +
                std::to_string(static_cast<int>(100.0 * share)) + " % done",
       .expected = "no more than " + format_bytes(budget),
       .advice = "The shape has many more tetrahedra than most. Give a larger budget, or " +
                 part.instead});
}

/// The triangulation is read out into arrays of half its size before it goes.
constexpr double kGrowthOfPoles = 1.5;

}  // namespace

bool has_voronoi_family() {
#ifdef ORBWEAVE_HAS_VORONOI
  return true;
#else
  return false;
#endif
}

void require_voronoi_family() {
  if (!has_voronoi_family()) refuse_family({});
}

void require_method(const Job& job) {
  require_normal_source(job);
  require_told_undersampling(job);
  if (!is_in_core(job.reconstruct.method)) return;
  if (!has_voronoi_family())
    refuse_family({.file = {},
                   .place = setting_name(job, "reconstruct.method"),
                   .found = method_name(job),
                   .expected = "ball_pivoting"});
}

std::vector<Vec3> normals_from_poles(const Job& job, std::span<const Vec3> positions,
                                     const StopToken* stop) {
  require_voronoi_family();
  const GrowingPart part{setting(job, "normals.source", "poles"), kGrowthOfPoles,
                         setting(job, "normals.source", "estimate")};
  try {
    return poles_of(positions, stop, [&, before = resident_bytes()](double share) {
      require_budget(job, part, before, share);
    });
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput) throw;
    ErrorParts parts = error.parts();
    parts.place = setting_name(job, "normals.source");
    parts.advice = setting(job, "normals.source", "estimate") + " takes points of one plane";
    throw Error(error.kind(), error.problem(), std::move(parts));
  }
}

InCoreSurface reconstruct_in_core(const Job& job, std::span<const Vec3> positions,
                                  std::span<const Vec3> normals, const StopToken* stop,
                                  const voronoi::ShareDone& done) {
  require_method(job);
  Found found = find_by(job.reconstruct.method, positions, stop, done);
  turn_to_normals(positions, normals, found.triangles, stop);
  return {with_fans(std::move(found.triangles), positions.size(), stop),
          std::move(found.undersampled)};
}

CoconeOfPart cocone_of_part(std::span<const Vec3> positions, std::span<const Vec3> normals,
                            const Box& known, const Box& cloud, const StopToken* stop) {
  require_voronoi_family();
  CoconeOfPart part;
  try {
    part = find_part(positions, normals, known, cloud, stop);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput) throw;
    // Points on one line have no triangles; another chunk may know more.
    part.undersampled.assign(positions.size(), 1);
    part.certified.assign(positions.size(), 0);
  }
  turn_to_normals(positions, normals, part.triangles, stop);
  return part;
}

voronoi::ShareDone progress_within_chunk(StageRunner& runner, std::uint64_t points) {
  return
      [&runner, points, before = resident_bytes(), shown = std::uint64_t{0}](double share) mutable {
        require_budget(runner.job, part_of(runner.job, share), before, share);
        const auto reached = static_cast<std::uint64_t>(share * static_cast<double>(points - 1));
        if (reached <= shown) return;
        runner.progress.advance(reached - shown);
        shown = reached;
      };
}

voronoi::PowerCrustSurface power_crust_in_core(std::span<const Vec3> positions,
                                               const StopToken* stop,
                                               const voronoi::ShareDone& done) {
  require_voronoi_family();
  return power_crust_of(positions, stop, done);
}

std::vector<Triangle> triangles_in_core(const voronoi::PowerCrustSurface& surface) {
  return triangles_of_crust(surface);
}

voronoi::Undersampling find_undersampling(std::span<const Vec3> positions, const StopToken* stop) {
  require_voronoi_family();
  return undersampling_of(positions, stop);
}

}  // namespace orbweave
