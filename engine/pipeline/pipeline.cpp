#include "engine/pipeline/pipeline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "engine/pipeline/budget/disk_plan.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/budget/time_forecast.h"
#include "engine/pipeline/damage_repair.h"
#include "engine/pipeline/job_paths.h"
#include "engine/pipeline/mesh_doubts.h"
#include "engine/pipeline/output/export_stage.h"
#include "engine/pipeline/output/map_tiles.h"
#include "engine/pipeline/output/mesh_for_levels.h"
#include "engine/pipeline/output/mesh_name.h"
#include "engine/pipeline/output/output_files.h"
#include "engine/pipeline/output/picture_stage.h"
#include "engine/pipeline/output/power_crust_files.h"
#include "engine/pipeline/output/report_viewer.h"
#include "engine/pipeline/output/simplify_stage.h"
#include "engine/pipeline/output/tile_export.h"
#include "engine/pipeline/output/tileset_stage.h"
#include "engine/pipeline/points/cleaning_stage.h"
#include "engine/pipeline/points/missed_scans.h"
#include "engine/pipeline/points/missing_poses.h"
#include "engine/pipeline/points/placeholder_normals.h"
#include "engine/pipeline/points/point_doubts.h"
#include "engine/pipeline/run_results.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/stage/scan_units.h"
#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "engine/pipeline/surface/hole_stage.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/pipeline/surface/power_crust_stage.h"
#include "engine/pipeline/surface/radii_choice.h"
#include "engine/pipeline/surface/reconstruct_stage.h"
#include "engine/pipeline/surface/stitch_stage.h"
#include "engine/pipeline/surface/used_vertices.h"
#include "engine/pipeline/team_job.h"
#include "engine/pipeline/team_traffic.h"
#include "engine/pipeline/work_store.h"
#include "io/clouds/open_point_source.h"
#include "io/job/job_keys.h"
#include "io/job/setting.h"
#include "io/points/coordinate_system.h"
#include "io/points/coordinate_system_file.h"
#include "io/shown_text.h"
#include "io/store/store_identity.h"
#include "io/streams/byte_sink.h"
#include "io/system/file_descriptor.h"
#include "io/system/glob.h"
#include "io/system/memory_limit.h"
#include "io/system/owned_files.h"
#include "io/text/file_format.h"
#include "io/text/quantity.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

/// Finds out before the work whether all scans are there.
void check_scans(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    check_readable(file);
    check_scan_name(file);
  }
}

/// Finds out before the work whether its end can be written.
void check_output(const Job& job, const std::vector<std::string>& files) {
  check_tile_size(job);
  if (job.output.tiles) check_tile_format(job.output);
  check_job_paths(job, files);
  check_mesh_name(job.output);
  check_tileset(job);
  check_simplification(job);
  check_power_crust_files(job);
  if (job.output.tiles) check_tile_place(job.output);
}

/// Sides, and with them the surface, follow from normals that tell nothing.
void warn_of_placeholder_normals(StageRunner& runner, const Partition& partition) {
  if (is_in_core(runner.job.reconstruct.method) || partition.normals.source != NormalSource::kFile)
    return;
  const std::optional<Vec3> normal = placeholder_normal(runner.store, partition, runner.stop);
  if (!normal) return;
  runner.warn("the normals of the scan are all " + format_position(*normal) +
              ", but its points lie in no plane across that direction: such normals are probably "
              "placeholders, or other columns, and the mesh is right only where the surface faces "
              "that way; try " +
              setting(runner.job, "normals.source", "estimate"));
}

void note_what_is_left_out(StageRunner& runner, const std::vector<std::string>& left_out) {
  if (left_out.empty()) return;
  runner.note(runner.job.output.mesh + " has no place for " + joined(left_out) +
              "; a .ply file has");
}

/// What the vertices carry and the mesh file does not hold.
void note_vertices_left_out(StageRunner& runner, const Partition& partition) {
  const OutputOptions& output = runner.job.output;
  note_what_is_left_out(runner,
                        columns_without_place(output.mesh, vertex_schema(output, partition)));
}

/// What the faces of patches carry and the mesh file does not hold.
void note_patches_left_out(StageRunner& runner, const std::vector<HoleFacts>& holes) {
  const OutputOptions& output = runner.job.output;
  if (std::ranges::any_of(holes, &HoleFacts::filled))
    note_what_is_left_out(runner, patches_without_place(output.mesh, output.confidence));
}

void warn_of_missed_scans(StageRunner& runner) {
  const std::string objection = objection_to_missed_scans(runner.job);
  if (!objection.empty()) runner.warn(objection);
}

void warn_of_missing_poses(StageRunner& runner) {
  const std::string objection = objection_to_missing_poses(runner.job);
  if (!objection.empty()) runner.warn(objection);
}

/// The origin of the mesh file's coordinates, or an end to the job where they would lose too much,
/// there or in the simplified mesh.
Vec3 checked_origin(StageRunner& runner, const Partition& partition) {
  const OutputOrigin chosen = mesh_origin(runner.job.output, partition);
  const std::string warning = check_output_origin(runner.job, chosen);
  check_simplified_origin(runner.job, partition);
  if (!runner.communicator.is_root()) return chosen.origin;
  if (!warning.empty()) runner.warn(warning);
  if (chosen.origin != Vec3{})
    runner.note("coordinates of " + runner.job.output.mesh + " are counted from " +
                origin_text(chosen.origin) +
                (holds_origin(runner.job.output.mesh) ? "; its node adds that"
                                                      : "; add that to each vertex"));
  return chosen.origin;
}

/// Loops with their first vertices as the mesh file numbers them.
std::vector<HoleFacts> in_output_numbers(std::vector<HoleFacts> holes, const UsedVertices& used) {
  VertexRanks ranks(used);
  for (HoleFacts& hole : holes) hole.first_vertex = value_of(ranks.of(hole.first_vertex));
  return holes;
}

/// Of the levels of detail that an earlier run left.
std::uint64_t stored_node_bytes(const StageRunner& runner) {
  std::uint64_t bytes = 0;
  for (const Stage stage : {Stage::kTileset, Stage::kSimplify})
    bytes += room_of_directory(runner.store.directory() / directory_of(stage));
  return bytes;
}

/// What is still to come, and what it took until the points were cut. The first prediction of the
/// disk counts.
void predict(StageRunner& runner, std::uint64_t disk_bytes, RunResults& results) {
  const ResolvedJob& job = runner.job;
  const Partition& partition = results.partition;
  const std::vector<double>& radii = results.radii.values;
  const std::uint64_t so_far = std::min(peak_memory_bytes(), job.partition.memory_bytes);
  ResourceFacts& predicted = results.predicted;
  predicted.peak_memory_bytes = std::max(predicted_peak_bytes(job, partition, radii), so_far);
  if (runner.communicator.is_root()) {
    const std::string objection =
        objection_to_peak(job, predicted.peak_memory_bytes, memory_limit_bytes());
    if (!objection.empty()) runner.warn(objection);
  }
  const std::vector<ExpectedStage> stages =
      expected_stages(job, size_of_job(partition, radii, runner.communicator.size()));
  predicted.seconds = sum_of_seconds(stages);
  runner.progress.expect(stages);
  if (predicted.disk_bytes == 0) predicted.disk_bytes = disk_bytes;
  if (predicted.disk_bytes == 0)
    predicted.disk_bytes = predicted_disk_bytes(job, partition, stored_node_bytes(runner));
}

/// How a method of the Voronoi family takes the cloud.
void note_method(StageRunner& runner, const Partition& partition) {
  const std::string method = "method: " + method_name(runner.job);
  const std::size_t chunks = partition.octree.chunks().size();
  if (!is_super_cocone(runner.job, partition))
    return runner.note(method + ", the whole cloud at once");
  const std::string in_chunks = method + ", in " + format_count(chunks) + " chunks";
  if (runner.job.reconstruct.method == ReconstructionMethod::kSuperCocone)
    return runner.note(in_chunks);
  runner.warn(in_chunks + ", which the memory budget asks for; the mesh depends on the chunks");
}

/// Points in chunks, and what follows from them alone.
void run_points(StageRunner& runner, RunResults& results) {
  if (runner.communicator.is_root()) warn_of_missed_scans(runner);
  if (runner.communicator.is_root()) warn_of_missing_poses(runner);
  CutPoints points = partition_points(runner.job, runner);
  results.partition = std::move(points.partition);
  require_a_triangle(runner.job.files.front(), results.partition.points(),
                     results.partition.points_read, results.partition.dropped);
  check_format_holds(runner.job.output, results.partition.points(),
                     vertex_schema(runner.job.output, results.partition));
  results.origin = checked_origin(runner, results.partition);
  if (runner.communicator.is_root()) note_vertices_left_out(runner, results.partition);
  results.radii = radii_of_job(runner.job, results.partition);
  if (is_in_core(runner.job.reconstruct.method))
    note_method(runner, results.partition);
  else
    runner.note(short_radii(runner.job, results.partition, results.radii.values),
                "ball radii: " + results.radii.reason);
  predict(runner, points.predicted_disk_bytes, results);
  if (!runner.communicator.is_root()) return;
  for (const std::string& objection : objections_to_points(runner.job, results.partition))
    runner.warn(objection);
  const std::string chunks = objection_to_chunks(runner.job, results.partition.points());
  if (!chunks.empty()) runner.warn(chunks);
  warn_of_placeholder_normals(runner, results.partition);
}

/// The vertices of a surface that are not the points; empty where they are.
std::optional<Partition> own_vertices_of(StageRunner& runner, const Partition& points) {
  if (!has_own_vertices(runner.job.reconstruct.method)) return std::nullopt;
  Partition vertices = make_power_crust(points, runner);
  check_format_holds(runner.job.output, vertices.points(),
                     vertex_schema(runner.job.output, vertices));
  return vertices;
}

/// The pipeline: one line per stage. Predictions of an attempt before stay in `results`.
void run_stages(StageRunner& runner, const RunWatch& watch, RunResults& results) {
  run_points(runner, results);
  const std::optional<Partition> own_vertices = own_vertices_of(runner, results.partition);
  const Partition& vertices = own_vertices ? *own_vertices : results.partition;
  const SurfaceInputs inputs{vertices, results.radii};
  reconstruct_chunks(inputs, runner);
  Stitched stitched = stitch(inputs, runner);
  HoleResult holes{{}, stitched.facts, 0};
  if (runner.job.fill.enabled)
    holes = fill_holes({inputs, std::move(stitched.boundary), stitched.facts}, runner);
  else if (runner.job.output.check_surface)
    holes.facts.crossing_pairs = count_crossings_unfilled(inputs, runner);
  if (runner.communicator.is_root()) note_patches_left_out(runner, holes.filled.holes);
  const UsedVertices used(runner.store, vertices, stitched.used, holes.filled.freed);
  const ExportInputs mesh{vertices, stitched.triangles, used, holes.filled, holes.facts};
  ExportResult exported = export_mesh(mesh, runner);
  if (!runner.communicator.is_root()) return;
  const OutputOptions& output = runner.job.output;
  if (!output.tileset.empty() || output.simplify)
    results.mesh_file = state_of_mesh_file(output.mesh);
  if (watch.at_mesh_written) watch.at_mesh_written();
  if (runner.job.output.mesh != "-") runner.store.disk().add(exported.bytes_written);
  if (!runner.job.output.picture.empty()) draw_picture(mesh, exported.bounds, runner);
  ResourceFacts& predicted = results.predicted;
  predicted.peak_memory_bytes = std::max(predicted.peak_memory_bytes, holes.predicted_peak_bytes);
  results.conflicts_lost = stitched.conflicts_lost;
  if (tells_undersampling(runner.job.reconstruct.method)) results.voronoi = stitched.voronoi;
  results.sides = stitched.sides;
  results.pieces_removed = holes.filled.pieces_removed;
  results.triangles_removed = holes.filled.removed.size() - holes.facts.mended_triangles;
  results.points_unused = stitched.unused_points + holes.filled.freed.size();
  results.mesh = std::move(holes.facts);
  results.mesh.checksum = std::move(exported.checksum);
  results.mesh.bounds = exported.bounds;
  results.holes = in_output_numbers(std::move(holes.filled.holes), used);
  warn_of_doubtful_mesh(runner, results);
}

/// What is made of the finished mesh file.
void make_levels(const RunResults& results, StageRunner& runner) {
  const OutputOptions& output = runner.job.output;
  const std::uint64_t triangles = results.mesh.triangles;
  if (!output.tileset.empty())
    make_of_mesh_file(output.mesh, results.mesh_file, [&] {
      make_tileset({results.partition, triangles}, runner);
    });
  if (output.simplify)
    make_of_mesh_file(output.mesh, results.mesh_file, [&] {
      make_simplified({results.partition, triangles}, runner);
    });
}

/// Runs the stages; a stored result that turns out to be damaged is dropped and made anew.
RunResults run_until_sound(StageRunner& runner, const RunWatch& watch) {
  Repairs repairs;
  RunResults results;
  while (true) {
    try {
      run_stages(runner, watch, results);
      if (runner.communicator.is_root()) make_levels(results, runner);
      return results;
    } catch (const CorruptResult& damage) {
      if (runner.communicator.size() > 1) {
        // The others are somewhere else in the job, which ends for all of them; the next run makes
        // it anew.
        drop_damaged(runner.store, damage.path());
        throw;
      }
      if (!repairs.allow(damage.path())) throw;
      runner.warn(std::string(damage.what()) + "; computing it again");
      runner.measured.clear();
      runner.store.finish_commits();
      drop_damaged(runner.store, damage.path());
    }
  }
}

/// Clears the work directory away and says what of it stays.
void remove_work(StageRunner& runner) {
  const std::vector<std::string> strangers = runner.store.remove_all();
  if (strangers.empty()) return;
  constexpr std::size_t kShown = 5;
  std::string names;
  for (std::size_t i = 0; i < std::min(kShown, strangers.size()); ++i)
    names += (i == 0 ? "" : ", ") + strangers[i];
  if (strangers.size() > kShown)
    names += " and " + std::to_string(strangers.size() - kShown) + " more";
  runner.warn(runner.store.directory().string() + " stays: it holds " + names +
              ", which this program did not write");
}

/// The job is done, whatever is in the way of the removal. Resources alone are: a folder above that
/// is for reading only, a device that fails.
void remove_work_of_ended_job(StageRunner& runner) {
  try {
    remove_work(runner);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kResource) throw;
    const ErrorParts& parts = error.parts();
    runner.warn("all outputs are written, but " + runner.store.directory().string() +
                " stays: " + parts.file + ": " + error.problem() + "; found " + parts.found +
                ". It is not needed any more, remove it");
  }
}

/// For want of better: what else went wrong is what the user has to know.
void remove_if_possible(StageRunner& runner) {
  try {
    remove_work(runner);
  } catch (const Error&) {
    // The next run with this work directory says what is wrong with it.
  }
}

/// Whether no stage has left anything to resume from: their folders hold keys at most.
bool holds_no_work(const std::filesystem::path& directory) {
  namespace fs = std::filesystem;
  std::error_code failed;
  for (fs::recursive_directory_iterator entry(directory, failed), end; !failed && entry != end;
       entry.increment(failed))
    if (entry.depth() > 0 && entry->path().filename() != kKeyFile) return false;
  return !failed;
}

/// Whether the error is about a key of the job: the job asks for what cannot be done.
bool is_about_a_key(const Job& job, const Error& error) {
  return std::ranges::any_of(job_keys(), [&](const JobKey& key) {
    return setting_name(job, key.name()) == error.parts().place;
  });
}

/// Algorithms know no files: what they refuse is the scans. Throws the error with the first of
/// them.
void name_scans(const ResolvedJob& job, const Error& error) {
  if (error.kind() != ErrorKind::kBadInput || !error.parts().file.empty()) return;
  ErrorParts parts = error.parts();
  parts.file = job.files.front();
  throw Error(error.kind(), error.problem(), std::move(parts));
}

/// The work directory goes where the job ended in bad input, and where the job was refused before
/// there was any work, and where the reader of the mesh has gone; everything else can be resumed.
/// Of several processes others may still be at
/// work: the directory stays, or they would fail first for want of it.
RunResults run_or_clean_up(StageRunner& runner, const RunWatch& watch) {
  try {
    return run_until_sound(runner, watch);
  } catch (const Error& error) {
    const bool keep = runner.job.run.keep_work_dir || runner.communicator.size() > 1;
    const bool is_useless =
        error.kind() == ErrorKind::kBadInput ||
        (is_about_a_key(runner.job, error) && holds_no_work(runner.store.directory()));
    const bool has_no_reader = dynamic_cast<const ClosedOutput*>(&error) != nullptr;
    if ((is_useless || has_no_reader) && !keep) remove_if_possible(runner);
    tell_of_changed_input(runner.job, error);
    name_scans(runner.job, error);
    throw;
  }
}

/// Whether an earlier run of this very job wrote all outputs, and only its work directory was left;
/// removes it then.
bool was_ended_before(StageRunner& runner) {
  const bool is_told =
      runner.communicator.is_root() && !runner.job.run.keep_work_dir &&
      runner.store.has_ended(outputs_key(runner.job, stamps_of_outputs(runner.job)));
  // The root decides: another process may see files as they were a moment ago.
  const bool ended = runner.communicator.broadcast(is_told ? 1 : 0, runner.stop) != 0;
  if (!runner.communicator.is_root()) return ended;
  if (ended)
    remove_work_of_ended_job(runner);
  else
    runner.store.clear_ended();
  return ended;
}

/// All outputs are written: the work directory goes, unless it is wanted. A run that is
/// killed meanwhile finds nothing left to do when it is repeated.
void end_job(StageRunner& runner) {
  runner.store.finish_commits();
  try {
    if (runner.job.output.mesh != "-")
      runner.store.set_ended(outputs_key(runner.job, stamps_of_outputs(runner.job)));
  } catch (const Error&) {
    // A full disk may have no room for it; what follows makes room.
  }
  if (!runner.job.run.keep_work_dir) remove_work_of_ended_job(runner);
}

void note_share(StageRunner& runner, bool chosen_here) {
  const Communicator& communicator = runner.communicator;
  if (communicator.size() == 1) return;
  const int threads = runner.threads();
  runner.note("rank " + std::to_string(communicator.rank()) + " of " +
              std::to_string(communicator.size()) + ": " + std::to_string(threads) +
              (threads == 1 ? " thread" : " threads") +
              (chosen_here ? ", its share of the cores that it may run on" : ""));
}

/// The job as it is run: work directory and threads filled in.
Job completed(const Job& wanted, const Communicator& communicator) {
  Job job = wanted;
  job.run.work_dir = work_dir_of(wanted);
  if (wanted.run.threads == 0) job.run.threads = communicator.threads();
  return job;
}

/// Looks at everything that the job reads and writes, before a work directory is made.
ResolvedJob resolve_and_check(const Job& job, const Communicator& communicator) {
  require_method(job);
  std::vector<std::string> files = expand_globs(job.input.files);
  check_scans(files);
  if (communicator.is_root()) check_output(job, files);
  ResolvedJob resolved = resolve(job, std::move(files));
  check_viewpoint(resolved);
  return resolved;
}

ResourceFacts measured_resources(const ChunkStore& store,
                                 std::chrono::steady_clock::time_point begin) {
  ResourceFacts measured;
  measured.peak_memory_bytes = peak_memory_bytes();
  measured.disk_bytes = store.disk().most();
  measured.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return measured;
}

}  // namespace

RunReport run_job(const Job& job, const std::vector<std::string>& command, Progress& progress,
                  const StopToken& stop) {
  Communicator alone;
  return run_job(job, command, progress, stop, alone);
}

RunReport run_job(const Job& wanted, const std::vector<std::string>& command, Progress& progress,
                  const StopToken& stop, Communicator& communicator, RunWatch* watch) {
  const auto begin = std::chrono::steady_clock::now();
  const ResolvedJob job = resolve_and_check(completed(wanted, communicator), communicator);
  require_same_job(wanted, communicator, stop);
  std::unique_ptr<ChunkStore> store = open_work_store(job.run, communicator, stop);
  if (watch != nullptr) watch->work_dir_is_opened = true;
  if (watch != nullptr) watch->work_dir_is_made = store->is_made();
  store->set_compression(job.run.compress);
  std::optional<RecordScope> on_record(store->record());
  auto logged = open_log(progress, *store, communicator);
  StageRunner runner{{job, *logged, stop}, *store, communicator};
  if (!store->note().empty()) runner.warn(store->note());
  if (was_ended_before(runner)) {
    RunReport report = report_of_job(job, command, communicator.size());
    report.ended_before = true;
    return report;
  }
  runner.root_threads =
      static_cast<int>(communicator.broadcast(static_cast<std::uint64_t>(job.threads()), stop));
  note_share(runner, wanted.run.threads == 0);
  RunResults results = run_or_clean_up(runner, watch != nullptr ? *watch : RunWatch{});
  gather_traffic(runner);
  if (!communicator.is_root()) {
    // File systems over a network keep what is removed while a process has it open.
    logged.reset();
    on_record.reset();
    store.reset();
  }
  communicator.barrier(stop);
  if (!communicator.is_root()) return report_of_job(job, command, communicator.size());
  const ResourceFacts measured = measured_resources(*store, begin);
  clear_older_outputs(runner, !results.partition.coordinate_system.empty());
  const std::string coordinate_system = results.partition.coordinate_system;
  RunReport report = report_of(runner, command, std::move(results), measured);
  // The text of many holes is as large as what is known of them.
  release_freed_memory(job.partition.memory_bytes);
  if (!job.output.report.empty())
    write_report(job.output.report, report, report_viewer(job, coordinate_system));
  if (watch != nullptr && watch->at_outputs_written) watch->at_outputs_written();
  end_job(runner);
  return report;
}

}  // namespace orbweave
