#include "engine/cli/files_beside.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system.h"
#include "io/points/coordinate_system_file.h"
#include "io/shown_text.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

void write_system(const std::string& file, const std::string& in, const std::string& system) {
  const fs::path written = write_coordinate_system(file, system);
  if (!written.empty()) note_written(written.string());
  for (const std::string& doubt : doubts_of_written_system(file, in, system, written))
    print_warning(doubt);
}

}  // namespace

void write_files_beside(const std::string& file, const std::string& in, const std::string& system,
                        Vec3 origin) {
  const fs::path shift = write_shift(file, origin);
  if (!shift.empty()) note_written(shift.string());
  write_system(file, in, system);
}

void name_in_errors(const std::string& file, const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput || !error.parts().file.empty()) throw;
    ErrorParts parts = error.parts();
    parts.file = file;
    throw Error(error.kind(), error.problem(), std::move(parts));
  }
}

bool fills_holes(const TriangleMesh& mesh) {
  return std::ranges::any_of(mesh.hole, [](std::int32_t hole) { return hole != 0; });
}

std::string left_out_of(const std::string& file, const PointSchema& schema,
                        const std::vector<std::string>& patches) {
  std::vector<std::string> names;
  for (const std::string& name : columns_without_place(file, schema)) names.push_back(shown(name));
  names.insert(names.end(), patches.begin(), patches.end());
  return names.empty() ? std::string()
                       : joined(names) + ": the format has no place for them; a .ply file has";
}

void warn_of_unknown_systems(std::span<const std::string> files) {
  for (const std::string& file : files) {
    const std::string words = unknown_system_beside(file);
    if (!words.empty())
      print_warning(coordinate_system_file(file).string() +
                    ": no coordinate system that is known, so it is passed over: " + shown(words));
  }
}

void warn_of_two_systems(const std::string& file, const std::string& system,
                         const std::string& other_file, const std::string& other_system) {
  if (system.empty() || other_system.empty()) return;
  if (systems_differ(system, other_system) != SystemsDiffer::kYes) return;
  print_warning(other_file + ": its coordinates are of another system than those of " + file +
                "; found " + shown(words_of_system(other_system)) + ", expected " +
                shown(words_of_system(system)) +
                ". The distances tell nothing before one of them is reprojected");
}

std::string left_out_of_input(const std::string& file, const std::vector<std::string>& left_out) {
  std::string text;
  for (const std::string& what : left_out) text += (text.empty() ? "" : "; ") + shown(what);
  return text.empty() ? text : file + ": not carried over: " + text;
}

void warn_of_left_out(const std::string& file, const std::vector<std::string>& left_out) {
  const std::string text = left_out_of_input(file, left_out);
  if (!text.empty()) print_warning(text);
}

void warn_of_lost_origins(std::span<const std::string> files) {
  for (const std::string& file : files) {
    std::error_code ignored;
    const fs::path beside = shift_file(file);
    if (beside.empty() || !fs::is_regular_file(file, ignored) || fs::exists(beside, ignored))
      continue;
    const std::string origin = origin_in_header(file);
    if (!origin.empty() && origin_beside(file) == Vec3{})
      print_warning(file + ": its header says that coordinates are counted from " + shown(origin) +
                    ", but " + beside.filename().string() +
                    " is not beside it: they are taken as they are. Move that file along with it");
  }
}

}  // namespace orbweave
