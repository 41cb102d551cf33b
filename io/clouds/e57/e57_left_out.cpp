#include "io/clouds/e57/e57_left_out.h"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "io/text/words.h"

namespace orbweave {
namespace {

/// Fields of the standard have no prefix.
bool is_of_extension(const E57Field& field) {
  return field.name.find(':') != std::string::npos || field.name.starts_with('/');
}

bool is_normal(const E57Field& field) {
  constexpr std::array<std::string_view, 3> kNormal = {"nor:normalX", "nor:normalY", "nor:normalZ"};
  return std::ranges::find(kNormal, field.name) != kNormal.end();
}

}  // namespace

std::vector<std::string> lost_values_of_e57(const std::vector<E57Scan>& scans, bool has_normals) {
  std::set<std::string> names;
  bool any_normal = false;
  for (const E57Scan& scan : scans) {
    if (scan.records == 0) continue;
    for (const E57Field& field : scan.fields) {
      any_normal = any_normal || is_normal(field);
      const bool is_read = is_normal(field) || field.name == "las:classification";
      if (is_of_extension(field) && !is_read) names.insert(field.name);
    }
  }
  std::vector<std::string> lost;
  if (any_normal && !has_normals)
    lost.emplace_back("normals, which not all scans of the file have");
  if (!names.empty())
    lost.push_back((names.size() == 1 ? "field " : "fields ") +
                   joined({names.begin(), names.end()}));
  return lost;
}

}  // namespace orbweave
