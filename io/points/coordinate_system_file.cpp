#include "io/points/coordinate_system_file.h"

#include <algorithm>
#include <cerrno>
#include <optional>
#include <string_view>
#include <system_error>

#include "io/byte_order_mark.h"
#include "io/points/coordinate_system.h"
#include "io/shown_text.h"
#include "io/system/atomic_file.h"
#include "io/system/file_descriptor.h"
#include "io/system/small_file.h"
#include "io/system/system_advice.h"
#include "io/text/file_format.h"
#include "io/text/tile_names.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

constexpr const char* kBlanks = " \t\r\n";

std::string trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin));
}

/// A text that may be a system in a user's words, on one line; empty for a document of another
/// program that names its projects so.
std::string words_on_one_line(std::string text) {
  constexpr std::size_t kMostBytes = 1024;
  if (text.size() > kMostBytes || text.starts_with('<') || text.starts_with('{')) return {};
  std::ranges::replace(text, '\n', ' ');
  std::string line;
  for (const std::string_view word : words_of(text)) {
    if (std::ranges::any_of(word, [](char c) { return static_cast<unsigned char>(c) < ' '; }))
      return {};
    line += (line.empty() ? "" : " ") + std::string(word);
  }
  return line;
}

/// WKT, or what may be a system in other words; empty where no file lies beside, or another one.
std::string text_beside(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMostBytes = 1 << 20;
  const std::filesystem::path beside = coordinate_system_file(file);
  std::error_code none;
  const std::uintmax_t bytes = beside.empty() ? 0 : std::filesystem::file_size(beside, none);
  if (none || bytes == 0 || bytes > kMostBytes) return {};
  const std::optional<std::string> whole = small_file_text(beside);
  if (!whole && is_failure(errno))
    throw_unread("cannot read the coordinate system", {.file = beside.string()}, errno);
  const std::string text = trimmed(without_byte_order_mark(whole.value_or("")));
  return is_wkt(text) ? text : words_on_one_line(text);
}

/// The directory of tiles that a file is a tile of, by its name and index; empty where it is none.
/// The system of the mesh lies beside that directory.
std::filesystem::path directory_of_tile(const std::filesystem::path& file) {
  std::error_code ignored;
  std::filesystem::path directory = std::filesystem::absolute(file, ignored).parent_path();
  const bool is_of_tiles = directory.extension() == kTilesExtension &&
                           std::filesystem::is_regular_file(directory / kTileIndex, ignored);
  return is_of_tiles ? directory : std::filesystem::path();
}

}  // namespace

std::filesystem::path coordinate_system_file(const std::filesystem::path& file) {
  std::error_code ignored;
  const auto status = std::filesystem::status(file, ignored);
  const bool is_device = std::filesystem::exists(status) && std::filesystem::is_other(status);
  if (file.empty() || file == "-" || is_device) return {};
  std::filesystem::path beside = file;
  // A file has the system that it has without its compression.
  const std::optional<NamedFormat> named = format_of_name(file);
  if (named && named->is_gzipped) beside.replace_extension();
  return beside.replace_extension(".prj");
}

std::string coordinate_system_beside(const std::filesystem::path& file) {
  const std::filesystem::path beside = coordinate_system_file(file);
  std::error_code ignored;
  if (beside.empty() || std::filesystem::exists(beside, ignored))
    return system_of_text(text_beside(file));
  return system_of_text(text_beside(directory_of_tile(file)));
}

std::string unknown_system_beside(const std::filesystem::path& file) {
  const std::string text = text_beside(file);
  return text.empty() || !system_of_text(text).empty() ? std::string() : text;
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

std::vector<std::string> doubts_of_written_system(const std::filesystem::path& file,
                                                  const std::string& in, const std::string& system,
                                                  const std::filesystem::path& written) {
  std::vector<std::string> doubts;
  const std::string problem = written_system(system).problem;
  if (!problem.empty())
    doubts.push_back("the coordinate system of " + in + ", " + shown(system) + ": " + problem);
  const std::filesystem::path beside = coordinate_system_file(file);
  std::error_code ignored;
  if (!written.empty() || beside.empty() || !std::filesystem::exists(beside, ignored))
    return doubts;
  doubts.push_back(beside.string() +
                   " was there before and is taken for the coordinate system of " + file.string() +
                   "; " + in + (system.empty() ? " tells of none" : " tells of another") +
                   ". Remove it if an earlier command has left it");
  return doubts;
}

}  // namespace orbweave
