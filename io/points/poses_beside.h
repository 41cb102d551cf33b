// Files of poses that lie beside scans.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace orbweave {

/// A file that may hold poses, and a scan that it names.
struct PosesBeside {
  std::filesystem::path file;
  std::string scan;
};

/// The first .conf or .aln in the folders of the scans that names one of the scans; empty: none
/// does. Files of more than a mebibyte and files that cannot be read are passed over.
std::optional<PosesBeside> poses_beside(std::span<const std::string> scans);

}  // namespace orbweave
