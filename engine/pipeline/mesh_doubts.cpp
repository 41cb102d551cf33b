#include "engine/pipeline/mesh_doubts.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/radii_choice.h"
#include "io/job/setting.h"
#include "io/points/dropped_points.h"
#include "io/report/hole_summary.h"
#include "io/report/reasons.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// Most points that a good mesh of a real scan lacks: trees and strays of airborne scans are up to
/// a tenth of the points.
constexpr double kMostMissing = 0.2;

/// Points that were left out because they had no normal, by reason.
Counted without_normal(const DroppedPoints& dropped) {
  constexpr std::array kReasons = {DropReason::kNormalNotFinite, DropReason::kZeroNormal,
                                   DropReason::kTooFewNeighbors};
  Counted found;
  for (const DropReason reason : kReasons) {
    const auto at = dropped.find(text_of(reason));
    if (at != dropped.end()) found.emplace_back(*at);
  }
  return found;
}

std::string way_of_surface(const StageRunner& runner, const RunResults& results) {
  return is_in_core(runner.job.reconstruct.method)
             ? "method " + method_name(runner.job)
             : short_radii(runner.job, results.partition, results.radii.values);
}

/// Whether all balls are too wide to reach the points between those that they rest on.
bool passes_over_points(const StageRunner& runner, const RunResults& results) {
  constexpr double kWideBall = 3.0;
  const double spacing = results.partition.spacing;
  return !is_in_core(runner.job.reconstruct.method) && spacing > 0.0 &&
         results.radii.values.front() > kWideBall * spacing;
}

std::string missing_points(const RunResults& results, const Counted& dropped) {
  Counted missing = dropped;
  if (results.points_unused > 0)
    missing.insert(missing.begin(), {"that no triangle uses", results.points_unused});
  return format_count(sum_of(missing)) + " of " +
         format_count(results.partition.points() + sum_of(dropped)) +
         " points are not in the mesh (" + counted_list(missing, missing.size()) + ")";
}

/// Whether the openings are too small to matter: one circle with all boundary edges around it would
/// have a thousandth of the mesh's area at most.
bool is_all_but_closed(const MeshFacts& mesh) {
  constexpr double kMostOpen = 1e-3;
  // An equilateral triangle of area 1 has edges whose square is this.
  constexpr double kSquaredEdge = 2.3094;
  const auto edges = static_cast<double>(mesh.boundary_edges);
  const double squared_perimeter =
      edges * edges * kSquaredEdge / static_cast<double>(mesh.triangles);  // of a mesh of area 1
  return squared_perimeter <= 4.0 * std::numbers::pi * kMostOpen;
}

/// A closed surface that shows its inner side although nothing says that it was seen from there.
void warn_of_inside_out(StageRunner& runner, const RunResults& results) {
  // Volumes that are smaller are those of thin plates, as far as patches let them be known.
  constexpr double kLeastVolume = 1e-3, kMostPatched = 0.2;
  const MeshFacts& mesh = results.mesh;
  const NormalFacts& normals = results.partition.normals;
  if (!is_all_but_closed(mesh) || mesh.patch_area > kMostPatched * mesh.area) return;
  // Cones to the patches are not counted: they matter the more, the farther a stray point moves the
  // middle of the points out of the mesh.
  const double off = norm(mesh.bounds.center() - results.partition.bounds.center());
  const double of_patches = off * mesh.patch_area / 3.0;
  if (mesh.scanned_volume + of_patches > -kLeastVolume * std::pow(mesh.area, 1.5)) return;
  if (normals.interiors > 0 || runner.job.normals.orientation == Orientation::kInward) return;
  runner.warn(
      std::string("the surface is closed and faces inward, as a room does; of an object, ") +
      (runner.job.estimates_normals ? "the normals' side was taken wrongly, try another " +
                                          setting_name(runner.job, "normals.orientation")
                                    : "the input's normals point to the wrong side, try " +
                                          setting(runner.job, "normals.source", "estimate")));
}

/// Points that the mesh lacks, or a surface full of holes.
void warn_of_what_is_missing(StageRunner& runner, const RunResults& results) {
  const MeshFacts& mesh = results.mesh;
  const std::string way = way_of_surface(runner, results);
  if (mesh.boundary_edges * 5 > mesh.triangles)
    return runner.warn("the mesh is riddled with holes: " + std::to_string(mesh.boundary_edges) +
                       " boundary edges on " + std::to_string(mesh.triangles) + " triangles, " +
                       std::to_string(results.points_unused) + " points unused; " + way);
  const Counted dropped = without_normal(results.partition.dropped);
  const auto missing = static_cast<double>(results.points_unused + sum_of(dropped));
  const auto all = static_cast<double>(results.partition.points() + sum_of(dropped));
  if (missing <= kMostMissing * all) return;
  const bool is_wide =
      results.points_unused > sum_of(dropped) && passes_over_points(runner, results);
  runner.warn(missing_points(results, dropped) + "; " + way +
              (is_wide
                   ? ": balls this wide pass over points; radii of one to five spacings reach them"
                   : ""));
}

/// Fewer say nothing.
constexpr std::uint64_t kFewestLookedAt = 100;

/// The normals are not those of the surface that the points lie on.
bool are_foreign(const SideFacts& sides) {
  constexpr double kMostSteep = 0.4;  // scans with noise: a tenth
  return sides.looked >= kFewestLookedAt &&
         static_cast<double>(sides.steep) > kMostSteep * static_cast<double>(sides.looked);
}

/// Sides change across smooth surfaces, along a line that is long for their size. (With the right
/// sides: 0 to 0.1 in real and most simulated scans, 0.6 in a cave seen at grazing angles.)
bool contradict(const SideFacts& sides, std::uint64_t points_of_cloud) {
  // Points beside the line per root of all points: 2 where half of a ball is flipped, 0.8 where a
  // cap of a sixteenth of its surface is.
  constexpr double kLongSeam = 0.7;
  constexpr std::uint64_t kFewestOnSeam = 4;
  if (sides.looked < kFewestLookedAt || sides.seams < kFewestOnSeam) return false;
  const std::uint64_t one_in = SideFacts::one_in(points_of_cloud);
  const auto smooth = static_cast<double>(sides.smooth * one_in);
  return static_cast<double>(sides.seams * one_in) > kLongSeam * std::sqrt(smooth);
}

/// Ground whose normals point down: one point in five or more is level, and ten face down for each
/// that faces up. Where z is not the height, upward and downward are not counted.
bool is_upside_down(const NormalOptions& options, const SideFacts& sides) {
  constexpr std::uint64_t kOneIn = 5, kForEach = 10;
  if (options.orientation != Orientation::kGround) return false;
  if (options.up && normalized(*options.up).z < 1.0) return false;
  return sides.looked >= kFewestLookedAt &&
         (sides.upward + sides.downward) * kOneIn >= sides.looked &&
         sides.downward > kForEach * sides.upward;
}

/// What to do about normals that were not turned by their neighbours.
std::string advice_on_sides(const StageRunner& runner, const RunResults& results) {
  if (results.partition.normals.source == NormalSource::kFile)
    return "try " + setting(runner.job, "normals.source", "estimate");
  return "check the place of each scanner (" + setting_name(runner.job, "input.poses") + ", " +
         setting_name(runner.job, "input.scanner") + "), or try " +
         setting(runner.job, "normals.orientation", "propagate");
}

/// Normals that were given, or turned to a scanner, and are not those of the surface.
void warn_of_sides(StageRunner& runner, const RunResults& results) {
  const SideFacts& sides = results.sides;
  const auto percent = [](std::uint64_t part, std::uint64_t whole) {
    return format_percent(static_cast<double>(part) / static_cast<double>(whole));
  };
  if (are_foreign(sides))
    return runner.warn("the normals do not fit the points: at " +
                       percent(sides.steep, sides.looked) +
                       " of them most neighbours lie in the direction of the normal rather than "
                       "beside it; the mesh is wrong or has holes there; " +
                       advice_on_sides(runner, results));
  if (contradict(sides, results.partition.points()))
    runner.warn("the normals contradict each other: at " + percent(sides.seams, sides.smooth) +
                " of the points on smooth surface neighbours face opposite sides, first near " +
                format_position(sides.place) +
                "; around there parts of the mesh face the wrong way, overlap or are missing; " +
                advice_on_sides(runner, results));
  if (results.partition.normals.source == NormalSource::kFile &&
      is_upside_down(runner.job.normals, sides))
    runner.warn("the input's normals face down where the surface is level, at " +
                percent(sides.downward, sides.upward + sides.downward) +
                " of these points: the ground of the mesh faces down; " +
                advice_on_sides(runner, results));
}

/// Tight Cocone closes whatever it is given. Its inside grows from well-sampled points; without
/// these it is a guess, and what comes out may be closed crumbs.
void warn_of_guessed_inside(StageRunner& runner, const RunResults& results) {
  constexpr double kMostUndersampled = 1.0 / 3.0;  // noisy scans of objects: a fifth
  if (runner.job.reconstruct.method != ReconstructionMethod::kTightCocone || !results.voronoi)
    return;
  const std::uint64_t points = results.partition.points();
  const std::uint64_t undersampled = results.voronoi->undersampled_points;
  if (static_cast<double>(undersampled) <= kMostUndersampled * static_cast<double>(points)) return;
  const std::uint64_t components = results.mesh.components;
  runner.warn("the surface is closed, but guessed: " + format_count(undersampled) + " of " +
              format_count(points) + " points are sampled too sparsely for tight_cocone to tell " +
              "inside from outside; the mesh is in " + format_count(components) +
              (components == 1 ? " component" : " components") + "; try " +
              setting(runner.job, "reconstruct.method", "power_crust") + " or ball_pivoting");
}

/// Radii that grow until balls rest on points which lie on no surface.
void warn_of_radii_for_noise(StageRunner& runner, const RunResults& results) {
  constexpr double kNoise = 0.33;  // leaves of trees: up to 0.3, surfaces: up to 0.2
  const Job& job = runner.job;
  if (is_in_core(job.reconstruct.method) || !job.reconstruct.ball_radii.empty()) return;
  if (results.partition.sparse_offset <= kNoise) return;
  const std::vector<double>& radii = results.radii.values;
  runner.warn("the largest ball radius is " +
              format_number(std::round(radii.back() / radii.front())) +
              " times the smallest, for sparse points most of which lie off the surface that their "
              "neighbours suggest, as noise does: the mesh may join such points to the surface or "
              "wrap it up; try " +
              setting(job, "reconstruct.ball_radii", format_number(radii.front())) +
              ", or leave the points out");
}

}  // namespace

void warn_of_doubtful_mesh(StageRunner& runner, const RunResults& results) {
  warn_of_what_is_missing(runner, results);
  warn_of_guessed_inside(runner, results);
  warn_of_inside_out(runner, results);
  warn_of_sides(runner, results);
  warn_of_radii_for_noise(runner, results);
}

}  // namespace orbweave
