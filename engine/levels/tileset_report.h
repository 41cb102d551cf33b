// What is told of a tileset to programs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/levels/tileset.h"

namespace orbweave {

struct TilesetReport {
  std::string mesh;  ///< that was read
  std::string tileset;
  TilesetFacts facts;
  std::uint64_t peak_memory_bytes = 0;  ///< of the process
};

/// JSON with stable keys; docs/levels.md has them.
std::string tileset_report_json(const TilesetReport& report);
/// Writes the JSON. Atomic.
void write_tileset_report(const std::filesystem::path& path, const TilesetReport& report);

}  // namespace orbweave
