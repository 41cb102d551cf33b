// A point source from a file of any supported format.
#pragma once

#include <filesystem>
#include <memory>

#include "io/clouds/text_layout.h"
#include "io/points/point_source.h"
#include "io/stop_token.h"

namespace orbweave {

struct PointSourceOptions {
  TextOptions text;
  /// Opening and reading throw Error (interrupted) where it asks for that, whatever a format looks
  /// for in its file; null: nothing does. Outlives the source.
  const StopToken* stop = nullptr;
};

/// Opens any supported cloud by extension (.ply .xyz .xyzn .xyzrgb .asc .txt .csv .pts .ptx .pcd,
/// each also with .gz; .las .laz .e57) and by content; docs/formats.md says what each reader takes.
/// A mesh file is read as the cloud of its vertices. A coordinate system (.prj) and a shift of the
/// coordinates
/// (.shift.txt) beside the file belong to it. Throws Error: usage for an unsupported extension (the
/// message lists those that are), bad input for missing, unreadable and damaged files.
std::unique_ptr<PointSource> open_point_source(const std::filesystem::path& path,
                                               const PointSourceOptions& options = {});

/// The coordinate system beside a scan, where it counts: a file that names one itself belongs to
/// that. Throws as open_point_source() where there is one beside it.
std::string system_from_beside(const std::filesystem::path& path,
                               const PointSourceOptions& options = {});

/// Throws Error (usage) where no reader takes a file of this name.
void check_scan_name(const std::filesystem::path& path);

}  // namespace orbweave
