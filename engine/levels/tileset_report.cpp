#include "engine/levels/tileset_report.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "io/system/atomic_file.h"
#include "io/text/json_dump.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

Json measured_json(const LevelDistance& measured) {
  Json json = {{"distance", measured.distance},
               {"mean_distance", measured.mean_distance},
               {"color_error", nullptr},
               {"samples", measured.samples}};
  if (measured.has_colors) json["color_error"] = measured.color_error;
  return json;
}

Json level_json(std::size_t number, const TilesetLevel& level) {
  return {{"level", number},
          {"tiles", level.tiles},
          {"triangles", level.triangles},
          {"border_triangles", level.border_triangles},
          {"stated_error", level.error},
          {"measured", level.measured ? measured_json(*level.measured) : Json()}};
}

}  // namespace

std::string tileset_report_json(const TilesetReport& report) {
  const TilesetFacts& facts = report.facts;
  Json levels = Json::array();
  for (std::size_t i = 0; i < facts.levels.size(); ++i)
    levels.push_back(level_json(i, facts.levels[i]));
  const Json json = {{"version", ORBWEAVE_VERSION},
                     {"mesh", report.mesh},
                     {"tileset", report.tileset},
                     {"vertices", facts.vertices},
                     {"triangles", facts.triangles},
                     {"bytes", facts.bytes},
                     {"on_earth", facts.is_on_earth},
                     {"levels", std::move(levels)},
                     {"peak_memory_bytes", report.peak_memory_bytes}};
  return json_dump(json, 1) + "\n";
}

void write_tileset_report(const std::filesystem::path& path, const TilesetReport& report) {
  AtomicFile file(path);
  file.write(tileset_report_json(report));
  file.commit();
}

}  // namespace orbweave
