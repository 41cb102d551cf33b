#include "tests/cli/survey_tiles.h"

#include <fstream>
#include <utility>

#include "tests/io/las_files.h"
#include "tests/support/clouds.h"

namespace orbweave::test {
namespace {

/// GeoTIFF keys of shorts.
std::string keys_record(const std::vector<std::pair<unsigned, unsigned>>& keys) {
  const auto u16 = [](std::size_t v) { return raw(static_cast<std::uint16_t>(v)); };
  std::string payload = u16(1) + u16(1) + u16(0) + u16(keys.size());
  for (const auto& [id, value] : keys) payload += u16(id) + u16(0) + u16(1) + u16(value);
  return variable_record("LASF_Projection", 34735, payload);
}

}  // namespace

void write_tile(const std::filesystem::path& path, const SurveyTile& tile) {
  LasFile file{.minor = 2, .format = tile.format};
  if (tile.epsg == 4326)
    file.variable_records = {keys_record({{1024, 2}, {2048, 4326}})};
  else if (tile.epsg != 0)
    file.variable_records = {keys_record({{1024, 1}, {3072, tile.epsg}})};
  file.scale = {0.001, 0.001, 0.001};
  file.offset = tile.place;
  Random random(11);
  for (int i = 0; i < 576; ++i) {
    LasPoint point;
    point.xyz = {500 * (i % 24) + static_cast<int>(random.below(60)),
                 500 * (i / 24) + static_cast<int>(random.below(60)),
                 static_cast<int>(random.below(100))};
    point.return_number = point.number_of_returns = 1;
    point.classification = i % 2 == 0 ? 2 : 6;
    point.intensity = static_cast<std::uint16_t>(i);
    point.gps_time = 1000.0 + i;
    const auto value = static_cast<std::uint16_t>(i * tile.brightest / 575);
    point.rgb_nir = {value, static_cast<std::uint16_t>(tile.brightest - value), 0, 0};
    file.add(point);
  }
  std::ofstream(path, std::ios::binary) << file.bytes();
}

ProgramResult reconstruct(const ScratchDirectory& in, const std::vector<std::string>& scans,
                          const std::string& mesh, const std::vector<std::string>& more,
                          const std::vector<std::string>& environment) {
  std::vector<std::string> all = {"reconstruct", "--up", "0,0,1", "-o", mesh};
  all.insert(all.end(), scans.begin(), scans.end());
  all.insert(all.end(), more.begin(), more.end());
  return run_program(all, {.directory = in.path(), .environment = environment});
}

nlohmann::json report_of(const ScratchDirectory& in) {
  return nlohmann::json::parse(file_text(in / "r.json"));
}

}  // namespace orbweave::test
