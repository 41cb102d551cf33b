// A folder for web servers that shows a mesh or a tileset.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "io/job/job.h"
#include "io/report/progress.h"
#include "io/stop_token.h"

namespace orbweave {

/// The folder that a path to a tileset leads to: itself, or that of a tileset.json. Empty: the path
/// is to something else, a mesh.
std::optional<std::filesystem::path> tileset_folder(const std::string& result);

struct ViewFolder {
  std::string result;  ///< a mesh, or a tileset as tileset_folder() knows it
  std::string folder;  ///< that is written
  std::string report;  ///< its text; empty: none
};

/// Makes the folder; says on standard output what it made.
void make_view_folder(const ViewFolder& view, const Job& job, Progress& progress,
                      const StopToken& stop);

/// Throws Error (usage) where a folder has no viewer.
void check_view_folder(const std::filesystem::path& folder);

}  // namespace orbweave
