// The tileset of a mesh, as commands make it.
#pragma once

#include <filesystem>
#include <string>

#include "engine/levels/tileset.h"
#include "io/job/job.h"
#include "io/report/progress.h"
#include "io/stop_token.h"

namespace orbweave {

/// What the settings and the files beside the mesh say of its tileset. Reads the mesh's vertices
/// where nothing else says which axis is upright.
TilesetOptions tileset_options(const std::string& mesh, const std::filesystem::path& work_directory,
                               const Job& job);

/// Throws Error as write_tileset() does.
TilesetFacts make_tileset(const std::string& mesh, const std::filesystem::path& directory,
                          const TilesetOptions& options, Progress& progress, const StopToken& stop);

}  // namespace orbweave
