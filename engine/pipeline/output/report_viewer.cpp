#include "engine/pipeline/output/report_viewer.h"

#include <filesystem>
#include <memory>
#include <string_view>

#include "engine/view/view_page.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_stream.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostTriangles = 250'000;

bool is_read_back(const OutputOptions& output) {
  const std::string_view mesh = output.mesh;
  std::error_code absent;
  return !output.tiles && (mesh.ends_with(".ply") || mesh.ends_with(".ply.gz")) &&
         fs::is_regular_file(output.mesh, absent);
}

/// Whether the budget holds the mesh, its page, and the report's page around it.
bool has_room(const MeshStream& mesh, std::uint64_t memory_bytes) {
  constexpr std::uint64_t kCopies = 16;
  const std::uint64_t page = view_page_bytes(mesh.vertices(), mesh.faces(), mesh.schema());
  return mesh.faces() <= kMostTriangles && kCopies * page <= memory_bytes;
}

std::string page_of_mesh(const ResolvedJob& job, const std::string& coordinate_system) {
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  ViewPage page;
  page.name = fs::path(job.output.mesh).filename().string();
  page.facts = {format_count(mesh.vertices.size()) + " vertices, " +
                format_count(mesh.triangles.size()) + " triangles"};
  page.confidence = face_confidence(job.output.mesh);
  page.up_axis =
      upright_axis(picture_up(job, job.files, coordinate_system), mesh.vertices.bounds());
  return view_page(mesh, page);
}

}  // namespace

std::string report_viewer(const ResolvedJob& job, const std::string& coordinate_system) {
  if (!is_read_back(job.output)) return {};
  try {
    if (!has_room(*open_mesh_stream(job.output.mesh), job.partition.memory_bytes)) return {};
    return page_of_mesh(job, coordinate_system);
  } catch (const Error&) {
    // A mesh without triangles, or one that was moved meanwhile: the report stands without it.
    return {};
  }
}

}  // namespace orbweave
