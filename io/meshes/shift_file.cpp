#include "io/meshes/shift_file.h"

#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/error.h"
#include "io/system/atomic_file.h"
#include "io/text/file_format.h"
#include "io/text/quantity.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

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

/// A shift at scale 1; nothing where the line is none.
std::optional<Vec3> shift_of(const std::string& line) {
  const std::vector<std::string> columns = columns_of(line);
  if (columns.size() < 5) return std::nullopt;
  try {
    if (finite_number(columns[4]) != 1.0) return std::nullopt;
    return Vec3{finite_number(columns[1]), finite_number(columns[2]), finite_number(columns[3])};
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
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
  return beside += ".shift.txt";
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
  std::ifstream stream(beside);
  if (beside.empty() || !stream) return {};
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.starts_with("//")) continue;
    if (const std::optional<Vec3> shift = shift_of(line)) return -*shift;
    break;
  }
  throw_bad_input("does not hold the shift of a mesh's coordinates",
                  {.file = beside.string(), .expected = "name; x; y; z; 1;"});
}

void add_origin(Vec3 origin, PointCloud& points) {
  if (origin == Vec3{}) return;
  points.schema.position_type = ScalarType::kFloat64;
  for (Vec3& point : points.positions) point = point + origin;
}

}  // namespace orbweave
