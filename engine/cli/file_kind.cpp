#include "engine/cli/file_kind.h"

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "io/lower_case.h"
#include "io/mesh_reader.h"

namespace orbweave {
namespace {

bool ends_with_any(const std::string& name, std::initializer_list<std::string_view> extensions) {
  const std::string lower = lower_case(name);
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](std::string_view extension) { return lower.ends_with(extension); });
}

}  // namespace

bool is_mesh_format(const std::string& name) {
  return ends_with_any(name, {".ply", ".ply.gz", ".obj", ".stl"});
}

bool is_mesh_file(const std::string& name) { return is_mesh_format(name) && holds_faces(name); }

bool is_mesh_only_format(const std::string& name) { return ends_with_any(name, {".obj", ".stl"}); }

bool is_cloud_only_format(const std::string& name) {
  return ends_with_any(name, {".xyz", ".txt", ".csv", ".pts", ".ptx", ".pcd", ".xyz.gz", ".txt.gz",
                              ".csv.gz", ".pts.gz", ".ptx.gz", ".pcd.gz", ".las", ".laz", ".e57"});
}

}  // namespace orbweave
