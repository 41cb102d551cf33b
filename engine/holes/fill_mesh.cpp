#include "engine/holes/fill_mesh.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "engine/holes/hole_choice.h"
#include "engine/holes/hole_pass.h"
#include "engine/holes/mesh_surface.h"
#include "engine/holes/patch_vertices.h"
#include "engine/holes/split_vertices.h"

namespace orbweave {
namespace {

/// The loops of a mesh and what is to become of them.
struct Survey {
  std::vector<std::uint8_t> keep;  // per triangle; empty: all
  std::uint64_t pieces_removed = 0;
  std::vector<BoundaryLoop> loops;
  std::vector<std::string> reasons;
};

Survey survey_of(const TriangleMesh& mesh, const FillOptions& options) {
  const MeshSurface surface(mesh);
  const MeshPieces pieces = find_pieces(mesh, surface);
  Survey survey;
  for (const Piece& piece : pieces.pieces) {
    survey.pieces_removed += piece.triangles < options.min_triangles ? 1 : 0;
  }
  if (survey.pieces_removed > 0) {
    for (const std::uint32_t piece : pieces.of_triangle) {
      survey.keep.push_back(pieces.pieces[piece].triangles < options.min_triangles ? 0 : 1);
    }
  }
  MeshBoundary boundary = find_boundary(mesh, MeshSurface(mesh, survey.keep), pieces.of_triangle);
  survey.loops = trace_loops(std::move(boundary.fans), boundary.vertices);
  survey.reasons = reasons_to_stay_open(survey.loops, pieces.pieces, options);
  return survey;
}

/// Ids go on after those that the mesh has already.
void number(const TriangleMesh& mesh, std::span<const BoundaryLoop> loops,
            std::vector<HoleFacts>& holes) {
  std::int32_t last = 0;
  for (const std::int32_t id : mesh.hole) last = std::max(last, id);
  for (std::size_t l = 0; l < holes.size(); ++l) {
    holes[l].id = last + static_cast<std::int32_t>(l + 1);
    holes[l].first_vertex = loops[l].vertices.front();
  }
}

void remove_triangles(std::span<const std::uint8_t> keep, FilledMesh& filled) {
  if (keep.empty()) return;
  TriangleMesh& mesh = filled.mesh;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (keep[t] == 0) continue;
    if (!mesh.hole.empty()) mesh.hole[kept] = mesh.hole[t];
    mesh.triangles[kept++] = mesh.triangles[t];
  }
  filled.triangles_removed = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  if (!mesh.hole.empty()) mesh.hole.resize(kept);
}

void append(const LoopPatch& patch, std::int32_t id, TriangleMesh& mesh) {
  const std::uint64_t base = mesh.vertices.size();
  mesh.vertices.append(
      patch_vertices(mesh.vertices.schema, patch.positions, patch.normals, patch.values));
  for (const Triangle64& t : patch.triangles) {
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      triangle[k] =
          static_cast<std::uint32_t>(t[k] < kNewVertex ? t[k] : base + (t[k] - kNewVertex));
    }
    mesh.triangles.push_back(triangle);
    mesh.hole.push_back(id);
  }
}

}  // namespace

std::vector<HoleFacts> list_holes(const TriangleMesh& mesh, const FillOptions& options) {
  Survey survey = survey_of(mesh, options);
  std::vector<HoleFacts> holes;
  for (std::size_t l = 0; l < survey.loops.size(); ++l) {
    holes.push_back(facts_of_loop(survey.loops[l]));
    holes.back().reason = std::move(survey.reasons[l]);
  }
  number(mesh, survey.loops, holes);
  return holes;
}

FilledMesh fill_mesh(const TriangleMesh& mesh, const FillOptions& options) {
  Survey survey = survey_of(mesh, options);
  const MeshSurface surface(mesh, survey.keep);
  const auto taken = shared_pairs(survey.loops);
  std::vector<LoopPatch> patches(survey.loops.size());
  tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t l) {
    if (survey.reasons[l].empty()) {
      patches[l] = fill_loop(surface, survey.loops[l], taken[l], options);
    } else {
      patches[l].facts = facts_of_loop(survey.loops[l]);
      patches[l].facts.reason = std::move(survey.reasons[l]);
    }
  });
  FilledMesh filled;
  filled.mesh = mesh;
  filled.pieces_removed = survey.pieces_removed;
  remove_triangles(survey.keep, filled);
  filled.mesh.hole.resize(filled.mesh.triangles.size(), 0);
  for (LoopPatch& patch : patches) filled.holes.push_back(std::move(patch.facts));
  number(mesh, survey.loops, filled.holes);
  for (std::size_t l = 0; l < patches.size(); ++l) {
    append(patches[l], filled.holes[l].id, filled.mesh);
  }
  filled.vertices_doubled = split_vertices(filled.mesh, pinched_vertices(filled.mesh));
  return filled;
}

}  // namespace orbweave
