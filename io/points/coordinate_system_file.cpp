#include "io/points/coordinate_system_file.h"

#include <fstream>
#include <iterator>
#include <optional>

#include "io/points/coordinate_system.h"
#include "io/system/atomic_file.h"

namespace orbweave {
namespace {

constexpr const char* kBlanks = " \t\r\n";

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

}  // namespace

std::filesystem::path coordinate_system_file(const std::filesystem::path& file) {
  std::error_code ignored;
  const auto status = std::filesystem::status(file, ignored);
  const bool is_device = std::filesystem::exists(status) && std::filesystem::is_other(status);
  if (file.empty() || file == "-" || is_device) return {};
  return std::filesystem::path(file).replace_extension(".prj");
}

std::string coordinate_system_beside(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMostBytes = 1 << 20;
  const std::filesystem::path beside = coordinate_system_file(file);
  std::error_code none;
  const std::uintmax_t bytes = beside.empty() ? 0 : std::filesystem::file_size(beside, none);
  if (none || bytes == 0 || bytes > kMostBytes) return {};
  std::ifstream stream(beside, std::ios::binary);
  const std::string text =
      trimmed({std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()});
  return is_wkt(text) || text.starts_with("EPSG:") ? text : std::string();
}

WrittenSystem written_system(const std::string& system) {
  if (system.empty() || is_wkt(system)) return {system, {}};
  const std::optional<CoordinateSystem> known = known_coordinate_system(system);
  if (known && !known->wkt.empty()) return {known->wkt, {}};
  if (has_coordinate_database() || !system.starts_with("EPSG:"))
    return {{}, "PROJ does not know it, so no file of it is written"};
  return {system,
          "PROJ finds no database (proj.db) to look it up in, so its code is written instead of "
          "WKT; install proj-data, or name the folder in PROJ_DATA (PROJ_LIB before PROJ 9.1)"};
}

std::filesystem::path write_coordinate_system(const std::filesystem::path& file,
                                              const std::string& system) {
  std::filesystem::path beside = coordinate_system_file(file);
  const std::string text = beside.empty() ? std::string() : written_system(system).text;
  if (text.empty()) return {};
  AtomicFile written(beside);
  written.write(text + "\n");
  written.commit();
  return beside;
}

}  // namespace orbweave
