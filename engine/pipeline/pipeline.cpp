#include "engine/pipeline/pipeline.h"

#include <oneapi/tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/cut_exchange.h"
#include "engine/pipeline/disk_plan.h"
#include "engine/pipeline/export_stage.h"
#include "engine/pipeline/hole_stage.h"
#include "engine/pipeline/memory_forecast.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/pipeline/prepare_stage.h"
#include "engine/pipeline/radii_choice.h"
#include "engine/pipeline/reconstruct_stage.h"
#include "engine/pipeline/stage_keys.h"
#include "engine/pipeline/stitch_stage.h"
#include "engine/pipeline/tile_export.h"
#include "engine/pipeline/time_forecast.h"
#include "engine/pipeline/used_vertices.h"
#include "io/atomic_file.h"
#include "io/chunk_points.h"
#include "io/glob.h"
#include "io/logged_progress.h"
#include "io/quantity.h"
#include "io/store_lock.h"

namespace orbweave {
namespace {

/// Finds out before the work whether its end can be written.
void check_output(const Job& job) {
  if (job.output.tiles) check_tiles(job.output);
  if (job.output.mesh == "-") return;
  const std::filesystem::path target(job.output.mesh);
  const std::filesystem::path directory =
      target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
  std::error_code ignored;
  const bool is_directory = std::filesystem::is_directory(target, ignored);
  const bool in_directory = std::filesystem::is_directory(directory, ignored);
  if (!is_directory && in_directory && access(directory.c_str(), W_OK) == 0) return;
  throw_resource("the mesh cannot be written there",
                 {.file = job.output.mesh,
                  .place = {},
                  .found = is_directory   ? "a directory of that name"
                           : in_directory ? std::strerror(errno)
                                          : directory.string() + ", which is no directory",
                  .expected = "a directory that exists and may be written",
                  .advice = "Create " + directory.string() + " or choose another place"});
}

void require_a_triangle(const JobContext& context, const Partition& partition) {
  if (partition.points() >= 3) return;
  throw_bad_input("no triangle can be formed",
                  {.file = context.files.front(),
                   .place = {},
                   .found = std::to_string(partition.points()) +
                            (partition.points() == 1 ? " distinct point" : " distinct points"),
                   .expected = "at least three",
                   .advice = {}});
}

void describe_partition(RunReport& report, const Partition& partition,
                        const std::vector<double>& radii) {
  report.points_read = partition.points_read;
  report.points_dropped = partition.dropped;
  report.prepare = partition.prepare;
  report.normals = partition.normals;
  report.coordinate_system = partition.coordinate_system;
  report.bounds = partition.bounds;
  report.chunks = partition.octree.chunks().size();
  report.halo_width = halo_width(radii);
  report.largest_chunk_points = 0;
  for (ChunkId c = 0; c < report.chunks; ++c) {
    report.largest_chunk_points = std::max(report.largest_chunk_points, partition.points_in(c));
  }
}

/// Nobody scans atoms or continents: then the unit is another one.
void warn_of_units(JobContext& context, const Partition& partition) {
  constexpr double kLeastMeters = 1e-7;
  constexpr double kMostMeters = 1e3;
  const double units_per_meter = context.job.input.units_per_meter;
  const double meters = partition.spacing / units_per_meter;
  if (!(partition.spacing > 0.0) || (meters >= kLeastMeters && meters <= kMostMeters)) return;
  context.warn("the points lie " + format_number(meters) + " m apart, as input.units_per_meter = " +
               format_number(units_per_meter) + " has it; that is hardly meant");
}

/// A surface full of holes: says so, and why where that can be told.
void warn_of_holes(JobContext& context, const Partition& partition) {
  const MeshFacts& mesh = context.report.mesh;
  const bool riddled = mesh.boundary_edges * 5 > mesh.triangles;
  const bool sparse = context.report.points_unused * 2 > partition.points();
  if (!riddled && !sparse) return;
  context.warn("the mesh is riddled with holes: " + std::to_string(mesh.boundary_edges) +
               " boundary edges on " + std::to_string(mesh.triangles) + " triangles, " +
               std::to_string(context.report.points_unused) + " points unused; " +
               compare_with_spacing(context.report.radii, partition.spacing));
}

/// Loops with their first vertices as the mesh file numbers them.
std::vector<HoleFacts> in_output_numbers(std::vector<HoleFacts> holes, const UsedVertices& used) {
  VertexRanks ranks(used);
  for (HoleFacts& hole : holes) hole.first_vertex = ranks.of(hole.first_vertex);
  return holes;
}

/// What is still to come, and what it took until the points were cut.
void predict_memory(JobContext& context, const Partition& partition,
                    const std::vector<double>& radii) {
  const std::uint64_t so_far = std::min(peak_memory_bytes(), context.job.partition.memory_bytes);
  context.report.predicted.peak_memory_bytes =
      std::max(predicted_peak_bytes(context, partition, radii), so_far);
}

/// The pipeline: one line per stage.
void run_stages(JobContext& context) {
  const Partition partition = partition_points(context);
  require_a_triangle(context, partition);
  check_format_holds(context.job.output, partition.points());
  const std::vector<double> radii = radii_of_job(context, partition);
  describe_partition(context.report, partition, radii);
  predict_memory(context, partition, radii);
  context.report.predicted.seconds = predicted_seconds(context, partition, radii);
  predict_room(context, partition);
  warn_of_units(context, partition);
  reconstruct_chunks(context, partition, radii);
  Stitched stitched = stitch(context, partition, radii);
  MeshFacts facts = stitched.facts;
  FilledHoles holes;
  if (context.job.fill.enabled) {
    holes = fill_holes(context, partition, radii, std::move(stitched.boundary), facts);
  }
  const UsedVertices used(context.store, partition, stitched.used, holes.freed);
  export_mesh(context, partition, stitched.triangles, used, holes, facts);
  if (!context.team.leads()) return;
  if (context.job.output.mesh != "-")
    context.store.disk().add(context.report.stages.back().bytes_written);
  if (!context.job.output.picture.empty()) draw_picture(context, partition, holes);
  context.report.points_unused += holes.freed.size();
  context.report.mesh = facts;
  context.report.holes = in_output_numbers(std::move(holes.holes), used);
  warn_of_holes(context, partition);
}

/// A chunk's mesh is made anew alone; points are bound to come out as they were only together.
void drop_damaged(ChunkStore& store, const std::filesystem::path& file) {
  const std::string name = file.stem().string();
  ChunkId chunk = 0;
  const auto parsed = std::from_chars(name.data(), name.data() + name.size(), chunk);
  const std::string stage = file.parent_path().filename().string();
  if ((stage == kMeshStage || stage == kHoleStage) && parsed.ec == std::errc()) {
    store.discard(stage, chunk);
  } else if (stage.ends_with(cut_stage_of(""))) {
    store.discard_stage(stage);  // bins are made again; what was sorted of them stays
  } else if (stage.starts_with("raw")) {
    discard_raw_stages(store);  // what a pass was made from is removed when it is complete
  } else {
    const std::string points = stage.empty() ? kPointsStage : stage;
    store.discard_stage(points);
    store.discard_stage(cut_stage_of(points));  // bins go as chunks are sorted
  }
}

/// Runs the stages; a stored result that turns out to be damaged is dropped and made anew.
void run_until_sound(JobContext& context) {
  constexpr int kMostRepairs = 8;
  for (int repairs = 0;; ++repairs) {
    try {
      return run_stages(context);
    } catch (const CorruptResult& damage) {
      if (context.team.size() > 1) {
        // The others are somewhere else in the job, which ends for all of them; the next run makes
        // it anew.
        drop_damaged(context.store, damage.path());
        throw;
      }
      if (repairs == kMostRepairs) throw;
      context.warn(std::string(damage.what()) + "; computing it again");
      context.report.stages.clear();
      context.store.finish_commits();
      drop_damaged(context.store, damage.path());
    }
  }
}

/// For want of better: what else went wrong is what the user has to know.
void remove_if_possible(ChunkStore& store) {
  try {
    store.remove_all();
  } catch (const Error&) {
    // The next run with this work directory says what is wrong with it.
  }
}

/// Work that ended in bad input is of no use to anybody; everything else can be resumed. Where
/// others may still be at work it stays: they would fail first, for want of it.
void run_or_clean_up(JobContext& context) {
  try {
    run_until_sound(context);
  } catch (const Error& error) {
    const bool keep = context.job.run.keep_work_dir || context.team.size() > 1;
    if (error.status() == ExitStatus::kBadInput && !keep) remove_if_possible(context.store);
    throw;
  }
}

/// What a run that was killed left beside the outputs.
void remove_abandoned_outputs(const OutputOptions& output) {
  for (const std::string& file : {output.mesh, output.report, output.picture})
    if (!file.empty() && file != "-") remove_abandoned(file);
}

/// Whether an earlier run of this very job wrote all outputs, and only its work directory was left;
/// removes it then.
bool was_ended_before(JobContext& context) {
  const bool is_told = context.team.leads() && !context.job.run.keep_work_dir &&
                       context.store.has_ended(outputs_key(context));
  // The leader's word: a member may see files as they were a moment ago.
  const bool ended = context.team.leaders_word(is_told ? 1 : 0, context.stop) != 0;
  if (!context.team.leads()) return ended;
  if (ended)
    context.store.remove_all();
  else
    context.store.clear_ended();
  return ended;
}

/// All outputs are written: the work directory goes, unless it is wanted. Whoever is killed
/// meanwhile finds that nothing is left to do.
void end_job(const JobContext& context) {
  context.store.finish_commits();
  try {
    if (context.job.output.mesh != "-") context.store.set_ended(outputs_key(context));
  } catch (const Error&) {
    // A full disk may have no room for it; what follows makes room.
  }
  if (!context.job.run.keep_work_dir) context.store.remove_all();
}

/// What tells the work directory of this run from others of that name.
std::uint64_t mark_of_run() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(now.count()) * 4194304 + static_cast<std::uint64_t>(getpid());
}

bool holds(const std::filesystem::path& file, const std::string& text) {
  std::ifstream stream(file);
  std::string found;
  return std::getline(stream, found) && found == text;
}

/// Returns whether the file holds `text`, or does some seconds later: file systems over a network
/// remember for a while what was there before.
bool will_hold(const std::filesystem::path& file, const std::string& text, const StopToken& stop) {
  constexpr int kTries = 50;
  for (int i = 0; i < kTries; ++i) {
    if (holds(file, text)) return true;
    stop.check();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return false;
}

[[noreturn]] void throw_not_shared(const std::filesystem::path& directory) {
  throw_resource("the work directory is not the one that the leader of the job uses",
                 {.file = directory.string(),
                  .expected = "a directory that all processes share",
                  .advice = "Name one on a shared file system with run.work_dir or --work-dir"});
}

/// A member's store, where the directory is the leader's own.
std::unique_ptr<ChunkStore> join_leader(const std::filesystem::path& directory, Team& team,
                                        const StopToken& stop) {
  const std::string mark = std::to_string(team.leaders_word(0, stop));
  if (!will_hold(directory / kTeamMark, mark, stop)) throw_not_shared(directory);
  auto store = ChunkStore::join(directory, team.rank());
  // The leader may have died by now, and another run be at work, whose member wants this place.
  if (!holds(directory / kTeamMark, mark)) throw_not_shared(directory);
  return store;
}

std::unique_ptr<ChunkStore> open_as_leader(const RunOptions& run, Team& team,
                                           const StopToken& stop) {
  auto store = std::make_unique<ChunkStore>(run.work_dir);
  if (run.fresh) {
    store->clear_ended();
    discard_raw_stages(*store);
    for (const char* stage : {kPointsStage, kMeshStage, kStitchStage, kHoleStage}) {
      store->discard_stage(stage);
    }
    store->discard_stage(cut_stage_of(kPointsStage));
  }
  if (team.size() == 1) return store;
  const std::uint64_t mine = mark_of_run();
  AtomicFile mark(store->directory() / kTeamMark);
  mark.write(std::to_string(mine) + "\n");
  mark.commit();
  team.leaders_word(mine, stop);
  return store;
}

/// The leader's store, and where that is ready, the others'.
std::unique_ptr<ChunkStore> open_store(const RunOptions& run, Team& team, const StopToken& stop) {
  return team.leads() ? open_as_leader(run, team, stop) : join_leader(run.work_dir, team, stop);
}

std::string log_name(const Team& team) {
  return team.leads() ? "orbweave.log" : "orbweave.rank" + std::to_string(team.rank()) + ".log";
}

void note_share(JobContext& context, bool chosen_here) {
  const Team& team = context.team;
  if (team.size() == 1) return;
  const int threads = context.threads();
  context.note("rank " + std::to_string(team.rank()) + " of " + std::to_string(team.size()) + ": " +
               std::to_string(threads) + (threads == 1 ? " thread" : " threads") +
               (chosen_here ? ", its share of the cores that it may run on" : ""));
}

}  // namespace

std::string work_dir_of(const Job& job) {
  if (!job.run.work_dir.empty()) return job.run.work_dir;
  if (job.output.mesh == "-") return "orbweave.work";
  return std::filesystem::path(job.output.mesh).replace_extension(".work").string();
}

RunReport run_job(const Job& job, const std::vector<std::string>& command, Progress& progress,
                  const StopToken& stop) {
  Team alone;
  return run_job(job, command, progress, stop, alone);
}

RunReport run_job(const Job& wanted, const std::vector<std::string>& command, Progress& progress,
                  const StopToken& stop, Team& team) {
  const auto begin = std::chrono::steady_clock::now();
  RunReport report;
  report.version = ORBWEAVE_VERSION;
  report.command = command;
  report.options = wanted;
  report.options.run.work_dir = work_dir_of(wanted);
  if (wanted.run.threads == 0) report.options.run.threads = team.threads();
  const Job job = report.options;
  report.files = expand_globs(job.input.files);
  report.ranks = team.size();
  if (team.leads()) check_output(job);
  std::unique_ptr<ChunkStore> store = open_store(report.options.run, team, stop);
  store->set_compression(job.run.compress);
  // More threads than cores are used when they are asked for.
  const tbb::global_control threads(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(job.run.threads, available_threads())));
  auto logged = make_logged_progress(progress, store->directory() / log_name(team));
  JobContext context{{job, report.files, *logged, stop}, *store, report, team};
  report.ended_before = was_ended_before(context);
  if (report.ended_before) return report;
  note_share(context, wanted.run.threads == 0);
  if (team.leads()) remove_abandoned_outputs(job.output);
  run_or_clean_up(context);
  if (!team.leads()) {
    // File systems over a network keep what is removed while somebody has it open.
    logged.reset();
    store.reset();
  }
  team.meet(stop);
  if (!team.leads()) return report;
  report.peak_memory_bytes = peak_memory_bytes();
  report.measured.peak_memory_bytes = report.peak_memory_bytes;
  report.measured.disk_bytes = store->disk().most();
  report.measured.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  release_freed_memory();  // the text of many holes is as large as what is known of them
  if (!job.output.report.empty()) write_report(job.output.report, report);
  end_job(context);
  return report;
}

}  // namespace orbweave
