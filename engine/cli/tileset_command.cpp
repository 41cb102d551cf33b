// orbweave tileset: levels of detail of a mesh, as 3D Tiles.
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <span>

#include "engine/cli/commands.h"
#include "engine/cli/files_beside.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/cli/tileset_making.h"
#include "engine/levels/tileset.h"
#include "engine/levels/tileset_report.h"
#include "engine/levels/tileset_work.h"
#include "io/error.h"
#include "io/report/machine.h"
#include "io/report/output_names.h"
#include "io/system/path_roles.h"
#include "io/text/quantity.h"
#include "partition/executor.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kKeys = {
    "partition.memory", "run.threads", "output.picture_up", "output.tileset_compression"};
constexpr std::uint64_t kMostLeafTriangles = std::uint64_t{1} << 22;

struct TilesetArguments {
  std::string mesh;
  std::string directory;
  std::uint64_t leaf_triangles = LevelOptions{}.leaf_triangles;
  bool measures = false;
  std::string report;
  JobArguments keys;
};

void check_places(const TilesetArguments& arguments, const fs::path& work) {
  const std::vector<PathRole> paths = {
      {"the mesh that is read", arguments.mesh, PathUse::kReadFile},
      {"the folder of the tiles", arguments.directory, PathUse::kWrittenDirectory},
      {"the report", arguments.report, PathUse::kWrittenFile},
      {"the work directory", work, PathUse::kWorkDirectory}};
  check_paths(paths);
  check_report_name(arguments.report, "--report");
}

std::string summary(const TilesetArguments& arguments, const TilesetFacts& facts) {
  std::string text = facts_table(
      {{"tileset", (fs::path(arguments.directory) / kTilesetName).string()},
       {"mesh", show_counts(facts.vertices, facts.triangles)},
       {"place", facts.is_on_earth ? "on the Earth, by the mesh's coordinate system"
                                   : "local: no coordinate system that PROJ can transform"},
       {"bytes", format_bytes(facts.bytes)}});
  std::vector<std::vector<std::string>> rows = {
      {"level", "tiles", "triangles", "at borders", "error"}};
  const std::optional<LevelDistance>& finest = facts.levels.front().measured;
  if (finest) rows[0].insert(rows[0].end(), {"measured", "mean"});
  if (finest && finest->has_colors) rows[0].push_back("colours");
  for (std::size_t i = 0; i < facts.levels.size(); ++i) {
    const TilesetLevel& level = facts.levels[i];
    rows.push_back({std::to_string(i), format_count(level.tiles), format_count(level.triangles),
                    show_percent(static_cast<double>(level.border_triangles) /
                                 static_cast<double>(std::max<std::uint64_t>(level.triangles, 1))),
                    format_number(level.error)});
    if (!level.measured) continue;
    rows.back().push_back(format_number(level.measured->distance));
    rows.back().push_back(format_number(level.measured->mean_distance));
    if (level.measured->has_colors)
      rows.back().push_back(show_percent(level.measured->color_error));
  }
  return text + "\n" + table(rows);
}

void tileset(const TilesetArguments& arguments, const StopToken& stop) {
  const Job job = settings_of(arguments.keys);
  const fs::path work_directory = arguments.directory + ".work";
  check_places(arguments, work_directory);
  warn_of_lost_origins(std::span(&arguments.mesh, 1));
  warn_of_unknown_systems(std::span(&arguments.mesh, 1));
  TilesetOptions options = tileset_options(arguments.mesh, work_directory, job);
  options.levels.leaf_triangles = arguments.leaf_triangles;
  options.measures = arguments.measures;
  const tbb::global_control limit(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(options.levels.threads, available_threads())));
  const auto progress = make_progress(progress_style(arguments.keys));
  const TilesetWork work(work_directory);
  const TilesetFacts facts =
      make_tileset(arguments.mesh, arguments.directory, options, *progress, stop);
  note_written(arguments.directory);
  if (!arguments.report.empty()) {
    write_tileset_report(arguments.report,
                         {arguments.mesh, arguments.directory, facts, peak_memory_bytes()});
    note_written(arguments.report);
  }
  std::cout << summary(arguments, facts);
}

}  // namespace

void add_tileset_command(CLI::App& program, const CommandContext& context) {
  const auto arguments = std::make_shared<TilesetArguments>();
  CLI::App* command =
      program.add_subcommand("tileset", "Make levels of detail of a mesh, as 3D Tiles 1.1");
  command->add_option("MESH", arguments->mesh, "The mesh to read: PLY, OBJ, STL or GLB")
      ->type_name("")
      ->required();
  command->add_option("-o,--output", arguments->directory, "The folder to write")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--leaf-triangles", arguments->leaf_triangles,
                   "Most triangles of a tile of the finest level (65536)")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, kMostLeafTriangles));
  command->add_flag("--measure", arguments->measures,
                    "Measure how far each level is from the mesh, and its colours");
  command->add_option("--report", arguments->report, "A report to write (JSON)")->type_name("FILE");
  add_key_options(*command, kKeys, arguments->keys);
  add_progress_option(*command, arguments->keys);
  command->footer(
      "Any web server can serve the folder; viewers of 3D Tiles open its tileset.json. The axis\n"
      "that is upright in pictures (--picture-up) is upright there, too.\n\n"
      "Example:\n  orbweave tileset mesh.ply -o mesh.tileset --memory 1GiB\n");
  command->callback([arguments, context] {
    context.then([arguments, &stop = context.stop] { tileset(*arguments, stop); });
  });
}

}  // namespace orbweave
