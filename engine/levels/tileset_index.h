// The index of a tileset's files (tiles.json).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace orbweave {

/// Writes a whole file or none. Throws Error (resource).
void write_text_file(const std::filesystem::path& file, std::string_view text);

/// Writes the index of the files of these names, which are there, and returns the bytes of all and
/// of the index together. `vertices`, `triangles`: of the mesh. Throws Error (resource).
std::uint64_t write_tileset_index(const std::filesystem::path& directory, std::uint64_t vertices,
                                  std::uint64_t triangles, const std::vector<std::string>& names);

}  // namespace orbweave
