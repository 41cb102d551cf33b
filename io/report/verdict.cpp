#include "io/report/verdict.h"

#include <cmath>
#include <cstdint>

#include "io/report/hole_summary.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

std::string counted(std::uint64_t count, const char* one, const char* many) {
  return format_count(count) + " " + (count == 1 ? one : many);
}

std::string surface_text(const MeshFacts& mesh) {
  if (mesh.triangles == 0) return "No triangle was made.";
  if (mesh.watertight) return "The surface is watertight.";
  if (mesh.boundary_edges > 0)
    return "The surface is open: " +
           counted(mesh.boundary_loops, "boundary loop", "boundary loops") + " of " +
           counted(mesh.boundary_edges, "edge", "edges") + ".";
  return "The surface is closed, but no manifold: " +
         counted(mesh.nonmanifold_edges, "non-manifold edge", "non-manifold edges") + ", " +
         counted(mesh.nonmanifold_vertices, "non-manifold vertex", "non-manifold vertices") + ".";
}

std::string percent_of_area(double area, const MeshFacts& mesh) {
  const double share = mesh.area > 0.0 ? area / mesh.area : 0.0;
  return format_number(std::round(1000.0 * share) / 10.0) + " % of the area";
}

std::string patches_text(const HoleSummary& holes, const MeshFacts& mesh) {
  if (holes.filled == 0) return "No hole was filled.";
  if (holes.doubtful == 0)
    return "No patch of " + counted(holes.filled, "filled hole", "filled holes") +
           " is doubtful; they are " + percent_of_area(mesh.patch_area, mesh) + ".";
  return counted(holes.doubtful, "patch", "patches") + " of " + format_count(holes.filled) +
         (holes.doubtful == 1 ? " is" : " are") + " doubtful, " +
         percent_of_area(holes.doubtful_area, mesh) + ": look first near " +
         format_position(holes.most_doubtful) + ".";
}

std::string crossings_text(const MeshFacts& mesh) {
  if (mesh.crossing_pairs)
    return *mesh.crossing_pairs == 0
               ? "No triangles cross."
               : counted(*mesh.crossing_pairs, "pair", "pairs") + " of triangles cross.";
  if (mesh.patch_crossing_pairs)
    return *mesh.patch_crossing_pairs == 0 ? "No patch crosses the surface."
                                           : counted(*mesh.patch_crossing_pairs, "pair", "pairs") +
                                                 " of triangles cross at patches.";
  return "Crossings were not counted.";
}

std::string warnings_text(std::size_t warnings) {
  if (warnings == 0) return "The run had no warning.";
  return "The run had " + counted(warnings, "warning", "warnings") + ", below among the notes.";
}

}  // namespace

Verdict verdict_of(const RunReport& report) {
  const MeshFacts& mesh = report.mesh;
  const HoleSummary holes = hole_summary(report.holes);
  const bool crosses =
      mesh.crossing_pairs.value_or(0) > 0 || mesh.patch_crossing_pairs.value_or(0) > 0;
  Verdict verdict;
  verdict.text = surface_text(mesh) + " " + patches_text(holes, mesh) + " " + crossings_text(mesh) +
                 " " + warnings_text(report.warnings.size());
  verdict.is_clean = mesh.watertight && holes.doubtful == 0 && !crosses && report.warnings.empty();
  return verdict;
}

}  // namespace orbweave
