#include "io/meshes/shift_file.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "io/byte_order_mark.h"
#include "io/error.h"
#include "io/json_nesting.h"
#include "io/meshes/tile_directory.h"
#include "io/ply/ply_vertices.h"
#include "io/streams/byte_reader.h"
#include "io/streams/byte_source.h"
#include "io/system/atomic_file.h"
#include "io/text/file_format.h"
#include "io/text/quantity.h"
#include "io/text/text_fields.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

constexpr std::string_view kExtension = ".shift.txt";
constexpr const char* kHeading =
    "// name; x; y; z; scale: coordinates of the file are (world + x, y, z) times scale\n";

/// A name that neither ends its column nor its line.
std::string name_text(const std::filesystem::path& file) {
  std::string name = file.filename().string();
  for (char& c : name)
    if (c == ';' || static_cast<unsigned char>(c) < ' ') c = '_';
  return name;
}

std::string component_text(double origin) { return origin == 0.0 ? "0" : format_exact(-origin); }

bool is_blank(char c) { return static_cast<unsigned char>(c) <= ' '; }

/// The text between semicolons, without the blanks around.
std::vector<std::string> columns_of(const std::string& line) {
  std::vector<std::string> columns(1);
  for (const char c : line) {
    if (c == ';')
      columns.emplace_back();
    else if (!is_blank(c) || !columns.back().empty())
      columns.back() += c;
  }
  for (std::string& column : columns)
    while (!column.empty() && is_blank(column.back())) column.pop_back();
  return columns;
}

/// A line of a list of shifts.
struct NamedShift {
  std::string name;
  Vec3 shift;
  std::string line;  ///< as it stands in the file
};

/// A shift at scale 1; nothing where the line is none.
std::optional<NamedShift> shift_of(const std::string& line) {
  const std::vector<std::string> columns = columns_of(line);
  if (columns.size() < 5) return std::nullopt;
  try {
    if (finite_number(columns[4]) != 1.0) return std::nullopt;
    return NamedShift{
        columns[0],
        {finite_number(columns[1]), finite_number(columns[2]), finite_number(columns[3])},
        line};
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

/// All lines but comments. Throws Error (bad input) where one is no shift, and where there is none.
std::vector<NamedShift> listed_shifts(const std::filesystem::path& list) {
  std::vector<NamedShift> shifts;
  std::ifstream stream(list);
  if (!stream)
    throw_bad_input("cannot open the shift of a mesh's coordinates", {.file = list.string()});
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    const std::string line(trimmed(number == 1 ? without_byte_order_mark(text) : text));
    if (line.empty() || line.starts_with("//")) continue;
    const std::optional<NamedShift> shift = shift_of(line);
    if (!shift)
      throw_bad_input("does not hold the shift of a mesh's coordinates",
                      {.file = list.string(),
                       .place = "line " + std::to_string(number),
                       .found = excerpt(line),
                       .expected = "name; x; y; z; 1;"});
    shifts.push_back(*shift);
  }
  if (shifts.empty())
    throw_bad_input("does not hold the shift of a mesh's coordinates",
                    {.file = list.string(), .expected = "name; x; y; z; 1;"});
  return shifts;
}

/// "1 2 3.5"; nothing where the text is something else.
std::optional<Vec3> vector_of(const std::string& text) {
  const std::vector<std::string_view> words = words_of(text);
  if (words.size() != 3) return std::nullopt;
  try {
    return Vec3{finite_number(words[0]), finite_number(words[1]), finite_number(words[2])};
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

/// The origin of the tiles in a folder, by their index (tile_directory.h); nothing where they have
/// none, or the folder is another one. The list of the tiles, which may be long, is not looked at.
std::optional<Vec3> origin_of_tiles(const std::filesystem::path& folder) {
  constexpr std::size_t kFront = 4096;
  std::ifstream stream(folder / kTileIndex);
  std::string text(kFront, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  const std::size_t list = text.find("\"tiles\"");
  const std::size_t comma = list == text.npos ? list : text.rfind(',', list);
  if (comma == text.npos) return std::nullopt;
  const nlohmann::json index = json_of(text.substr(0, comma) + "}");
  if (!index.is_object() || index.value("format", nlohmann::json()) != kTileFormat)
    return std::nullopt;
  const nlohmann::json origin = index.value("origin", nlohmann::json());
  if (!origin.is_array() || origin.size() != 3 ||
      !std::ranges::all_of(origin, [](const nlohmann::json& x) { return x.is_number(); }))
    return std::nullopt;
  return Vec3{origin[0], origin[1], origin[2]};
}

/// Of a tile among the others of its mesh, whose index has the origin that its header names; zero:
/// of any other file.
Vec3 origin_of_tile(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::path folder = file.parent_path();
  if (!std::filesystem::is_regular_file(folder / kTileIndex, ignored) ||
      !std::filesystem::is_regular_file(file, ignored))
    return {};
  const std::optional<Vec3> origin = vector_of(origin_in_header(file));
  return origin && origin_of_tiles(folder) == origin ? *origin : Vec3{};
}

/// Whether the file is one that was written here.
bool is_shift_file(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  return std::getline(stream, line) && line + "\n" == kHeading;
}

}  // namespace

std::filesystem::path shift_file(const std::filesystem::path& file) {
  std::error_code ignored;
  const auto status = std::filesystem::status(file, ignored);
  const bool is_device = std::filesystem::exists(status) && std::filesystem::is_other(status);
  if (file.empty() || file == "-" || is_device || holds_origin(file)) return {};
  std::filesystem::path beside = file;
  return beside += kExtension;
}

bool is_name_of_shift(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with(kExtension) &&
         format_of_name(name.substr(0, name.size() - kExtension.size()));
}

std::filesystem::path write_shift(const std::filesystem::path& file, Vec3 origin) {
  std::filesystem::path beside = shift_file(file);
  if (beside.empty() || (origin == Vec3{} && !is_shift_file(beside))) return {};
  AtomicFile written(beside);
  written.write(kHeading + name_text(file) + "; " + component_text(origin.x) + "; " +
                component_text(origin.y) + "; " + component_text(origin.z) + "; 1;\n");
  written.commit();
  return beside;
}

Vec3 origin_beside(const std::filesystem::path& file) {
  const std::filesystem::path beside = shift_file(file);
  std::error_code ignored;
  if (beside.empty()) return {};
  if (!std::filesystem::exists(beside, ignored)) return origin_of_tile(file);
  std::vector<NamedShift> shifts = listed_shifts(beside);
  // A list of several files has one line for this one; a file that was renamed is in no list.
  const std::string name = name_text(file);
  const auto is_another = [&](const NamedShift& shift) { return shift.name != name; };
  if (!std::ranges::all_of(shifts, is_another)) std::erase_if(shifts, is_another);
  for (const NamedShift& shift : shifts)
    if (shift.shift != shifts.front().shift)
      throw_bad_input("holds several shifts, and which is that of " + name + " is not said",
                      {.file = beside.string(),
                       .found = excerpt(shifts.front().line) + " and " + excerpt(shift.line),
                       .expected = "one line of that name",
                       .advice = "Leave the line of the file alone."});
  return -shifts.front().shift;
}

std::string origin_in_header(const std::filesystem::path& file) {
  constexpr std::string_view kOrigin = "comment origin ";
  constexpr int kMostLines = 100;
  try {
    ByteReader reader(open_byte_source(file));
    if (!looks_like_ply(reader)) return {};
    std::string_view line;
    for (int i = 0; i < kMostLines && reader.next_line(line); ++i) {
      if (line.starts_with(kOrigin)) return std::string(line.substr(kOrigin.size()));
      if (line.starts_with("end_header")) break;
    }
  } catch (const Error&) {
    // What is wrong with the file is told where it is read.
  }
  return {};
}

void add_origin(Vec3 origin, PointCloud& points) {
  if (origin == Vec3{}) return;
  points.schema.position_type = ScalarType::kFloat64;
  for (Vec3& point : points.positions) point = point + origin;
}

}  // namespace orbweave
