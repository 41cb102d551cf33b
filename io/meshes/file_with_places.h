// Mesh files whose bytes are written at their places, not from front to back.
#pragma once

#include <filesystem>

namespace orbweave {

/// The path of such a file. Throws Error (usage) for a pipe or a device. `format`: for the message.
std::filesystem::path file_with_places(const std::filesystem::path& path, const char* format);

/// Throws Error (usage) where a mesh of that name needs such a file and cannot have one. Before the
/// work.
void check_file_with_places(const std::filesystem::path& mesh);

}  // namespace orbweave
