#include "engine/pipeline/output/simplify_stage.h"

#include <filesystem>
#include <string>

#include "engine/levels/simplified_mesh.h"
#include "engine/pipeline/output/export_stage.h"
#include "engine/pipeline/output/mesh_for_levels.h"
#include "engine/pipeline/output/stored_nodes.h"
#include "engine/pipeline/stage/writer_options.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/job/simplified_file.h"
#include "io/meshes/file_with_places.h"
#include "io/meshes/heavy_data.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/system/memory_watch.h"
#include "io/text/file_format.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// The job as if the simplified mesh were its mesh.
Job job_of_simplified(const Job& job) {
  Job changed = job;
  changed.output.mesh = simplified_file(job.output).string();
  return changed;
}

MeshWriterOptions written_options(const Job& job, const Partition& partition, StageRunner& runner) {
  const OutputOrigin chosen = mesh_origin(job.output, partition);
  const std::string warning = check_output_origin(job, chosen);
  if (!warning.empty()) runner.warn(warning);
  MeshWriterOptions options = writer_options(job.output, {}, chosen.origin);
  options.up_axis = upright_axis(picture_up(job, runner.job.files, partition.coordinate_system),
                                 partition.bounds);
  return options;
}

void note_result(const SimplifiedFacts& facts, const fs::path& file, StageRunner& runner) {
  if (const std::string missed = missed_limit(facts); !missed.empty()) runner.warn(missed);
  runner.note(file.string() + ": " + format_count(facts.triangles) + " of " +
              format_count(facts.triangles_read) + " triangles, at most " +
              format_number(facts.error) + " from the mesh");
}

}  // namespace

void check_simplification(const Job& job) {
  const OutputOptions& output = job.output;
  if (!output.simplify) {
    if (output.simplified.empty()) return;
    throw_usage("how far the mesh is to be simplified is not said",
                {.file = output.simplified,
                 .place = setting_name(job, "output.simplified"),
                 .expected = setting(job, "output.simplify", "ratio=0.1") + " or another limit"});
  }
  const fs::path file = simplified_file(output);
  check_mesh_for_levels(job, {"a simplified mesh", "output.simplify", file.string(),
                              "orbweave simplify MESH -o " + file.string()});
  const std::optional<NamedFormat> named = format_of_name(file);
  if (!named || !named->facts.writes_mesh || (named->is_gzipped && !named->facts.writes_gzip))
    throw_usage("no mesh is written under this name",
                {.file = file.string(),
                 .place = setting_name(job, "output.simplified"),
                 .expected = extensions_of_written_meshes()});
  check_heavy_data(file);
  check_file_with_places(file);
}

void check_simplified_origin(const Job& job, const Partition& partition) {
  if (!job.output.simplify) return;
  const Job simplified = job_of_simplified(job);
  check_output_origin(simplified, mesh_origin(simplified.output, partition));
}

void make_simplified(const SimplifyInputs& inputs, StageRunner& runner) {
  if (inputs.triangles == 0) {
    runner.warn("no simplified mesh is made: the mesh has no triangle");
    return;
  }
  release_freed_memory(runner.job.partition.memory_bytes);
  const Job job = job_of_simplified(runner.job);
  const fs::path file = job.output.mesh;
  StageClock clock(runner, Stage::kSimplify, inputs.triangles, "triangles");
  StoredNodes nodes(runner.store, directory_of(Stage::kSimplify));
  SimplifyOptions options;
  options.levels.nodes = &nodes;
  options.target = *job.output.simplify;
  options.levels.memory_bytes = job.partition.memory_bytes;
  options.levels.threads = runner.threads();
  options.levels.directory = runner.store.directory();
  options.written = [&](const Box&) { return written_options(job, inputs.partition, runner); };
  SimplifyEvents events;
  events.read = [&](std::uint64_t triangles) { runner.progress.advance(triangles); };
  const SimplifiedFacts facts =
      write_simplified(runner.job.output.mesh, file, options, events, runner.stop);
  write_coordinate_system(file, inputs.partition.coordinate_system);
  write_shift(file, facts.origin);
  runner.store.finish_commits();
  clock.facts().bytes_written = facts.bytes;
  clock.facts().chunks = facts.nodes;
  clock.facts().chunks_reused = facts.nodes_reused;
  runner.store.disk().add(facts.bytes + facts.work_bytes);
  runner.store.disk().remove(facts.work_bytes);
  note_result(facts, file, runner);
}

}  // namespace orbweave
