#include "engine/pipeline/output/mesh_for_levels.h"

#include <sys/stat.h>

#include <filesystem>
#include <optional>

#include "engine/levels/levels.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/system/file_sample.h"
#include "io/text/file_format.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// What of the job stands in the way of reading the mesh file again from front to back; empty:
/// nothing.
std::string obstacle(const OutputOptions& output) {
  if (output.tiles) return "output.tiles = true, which writes no mesh file";
  if (output.mesh == "-") return "standard output";
  const std::optional<NamedFormat> named = format_of_name(output.mesh);
  if (!named || named->facts.format != FileFormat::kPly || named->is_gzipped)
    return fs::path(output.mesh).filename().string();
  std::error_code absent;
  const fs::file_status status = fs::status(output.mesh, absent);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
    return "a pipe or a device";
  return "";
}

[[noreturn]] void throw_other_mesh(const std::string& mesh, const MeshFileState& now) {
  throw_resource("the mesh changed before all was made of it that the job asks for",
                 {.file = mesh,
                  .found = now.content.empty() ? "no such file" : "a file with other content",
                  .expected = "the file that this job wrote, where it wrote it",
                  .advice = "Leave the mesh where it is until the job has ended"});
}

}  // namespace

void check_mesh_for_levels(const Job& job, const MadeOfMesh& made) {
  const OutputOptions& output = job.output;
  if (const std::string found = obstacle(output); !found.empty())
    throw_usage(made.what + " is made from an uncompressed PLY file",
                {.file = output.mesh,
                 .place = setting_name(job, made.key),
                 .found = found,
                 .expected = "the name of a .ply file as output.mesh",
                 .advice = "Name a .ply file, or make " + made.what + " later: " + made.command});
  const std::uint64_t leaf = LevelOptions{}.leaf_triangles;
  if (job.partition.memory_bytes >= least_level_memory(leaf)) return;
  throw_usage("the memory budget has no room for a tile of " + std::to_string(leaf) + " triangles",
              {.file = made.place,
               .place = setting_name(job, made.key),
               .found = "partition.memory = " + format_bytes(job.partition.memory_bytes),
               .expected = "at least " + format_bytes(least_level_memory(leaf)),
               .advice = "Give it more memory, or make smaller tiles later: " + made.command +
                         " --leaf-triangles"});
}

MeshFileState state_of_mesh_file(const std::string& mesh) {
  struct stat facts {};
  const std::optional<FileSample> sample = sample_file(mesh, kSampleBlocks);
  if (!sample || ::stat(mesh.c_str(), &facts) != 0) return {};
  return {facts.st_ino, std::to_string(facts.st_size) + " bytes, sample " + sample->fingerprint};
}

void make_of_mesh_file(const std::string& mesh, const MeshFileState& written,
                       const std::function<void()>& make) {
  const MeshFileState before = state_of_mesh_file(mesh);
  // It may have gone before it was looked at.
  if (written.content.empty() || before.content != written.content) throw_other_mesh(mesh, before);
  try {
    make();
  } catch (const Error& error) {
    const MeshFileState now = state_of_mesh_file(mesh);
    if (error.kind() == ErrorKind::kBadInput && now.content != written.content)
      throw_other_mesh(mesh, now);
    throw;
  }
  // A file that took the place of the one that was open was not read.
  const MeshFileState after = state_of_mesh_file(mesh);
  if (after.inode == before.inode && after.content != before.content) throw_other_mesh(mesh, after);
}

}  // namespace orbweave
