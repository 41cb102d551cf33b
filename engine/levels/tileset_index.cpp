#include "engine/levels/tileset_index.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "io/hex_digits.h"
#include "io/meshes/tile_directory.h"
#include "io/system/atomic_file.h"

namespace orbweave {

namespace fs = std::filesystem;

void write_text_file(const fs::path& file, std::string_view text) {
  AtomicFile written(file);
  written.write(text);
  written.commit();
}

std::uint64_t write_tileset_index(const fs::path& directory, std::uint64_t vertices,
                                  std::uint64_t triangles, const std::vector<std::string>& names) {
  std::uint64_t bytes = 0;
  nlohmann::json files = nlohmann::json::array();
  for (const std::string& name : names) {
    const std::uint64_t size = fs::file_size(directory / name);
    bytes += size;
    files.push_back(
        {{"file", name}, {"bytes", size}, {"xxh3", hex_digits(file_checksum(directory / name))}});
  }
  const nlohmann::json index = {{"format", kTileFormat},
                                {"version", 1},
                                {"vertices", vertices},
                                {"triangles", triangles},
                                {"tiles", std::move(files)}};
  const std::string text = index.dump(1) + "\n";
  write_text_file(directory / kTileIndex, text);
  return bytes + text.size();
}

}  // namespace orbweave
