#include "engine/cli/view_folder.h"

#include <iostream>
#include <system_error>
#include <vector>

#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/cli/tileset_making.h"
#include "engine/levels/tileset_copy.h"
#include "engine/levels/tileset_work.h"
#include "engine/view/view_page.h"
#include "io/error.h"
#include "io/meshes/tile_directory.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// Of what is shown: the mesh's file, or the tileset's folder.
std::string name_of(const fs::path& result) {
  const fs::path whole = fs::absolute(result).lexically_normal();
  const std::string name = whole.filename().string();
  return name.empty() ? whole.parent_path().filename().string() : name;
}

}  // namespace

std::optional<fs::path> tileset_folder(const std::string& result) {
  std::error_code absent;
  const fs::path path = result;
  if (fs::is_directory(path, absent)) return path;
  if (path.filename() != kTilesetName) return std::nullopt;
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

void make_view_folder(const ViewFolder& view, const Job& job, Progress& progress,
                      const StopToken& stop) {
  const fs::path work_directory = view.folder + ".work";
  const std::optional<fs::path> tileset = tileset_folder(view.result);
  const std::vector<NamedText> files =
      view_folder_files(name_of(tileset ? *tileset : fs::path(view.result)), view.report);
  Facts facts = {{"page", (fs::path(view.folder) / kFolderPage).string()}};
  const TilesetWork work(work_directory);
  TilesetCopy made;
  if (tileset) {
    made = copy_tileset(*tileset, view.folder, files, stop);
  } else {
    TilesetOptions options = tileset_options(view.result, work_directory, job);
    options.beside = files;
    const TilesetFacts tiles = make_tileset(view.result, view.folder, options, progress, stop);
    made = {tiles.vertices, tiles.triangles, tiles.bytes};
  }
  note_written(view.folder);
  facts.emplace_back("mesh", show_counts(made.vertices, made.triangles));
  facts.emplace_back("bytes", format_bytes(made.bytes));
  std::cout << facts_table(facts);
}

void check_view_folder(const fs::path& folder) {
  const auto index = read_tile_index(folder);
  if (index && index->files.contains(kFolderPage)) return;
  throw_usage("nothing to serve",
              {.file = folder.string(),
               .found = "no " + std::string(kFolderPage) + " of 'orbweave view'",
               .expected = "a folder that 'orbweave view RESULT --folder DIR' made",
               .advice = "Name a folder to make: --folder DIR"});
}

}  // namespace orbweave
