#include "engine/cli/file_kind.h"

#include <optional>

#include "io/meshes/mesh_reader.h"
#include "io/text/file_format.h"

namespace orbweave {

bool is_mesh_file(const std::string& name) {
  const std::optional<NamedFormat> named = format_of_name(name);
  return named && named->facts.holds_faces && named->facts.is_read && holds_faces(name);
}

bool is_mesh_only_format(const std::string& name) {
  const std::optional<NamedFormat> named = format_of_name(name);
  return named && named->facts.holds_faces && !named->facts.writes_cloud;
}

bool is_cloud_only_format(const std::string& name) {
  const std::optional<NamedFormat> named = format_of_name(name);
  return named && !named->facts.holds_faces;
}

bool is_scan_format(const std::string& name) {
  const std::optional<NamedFormat> named = format_of_name(name);
  return named && named->facts.is_read;
}

}  // namespace orbweave
