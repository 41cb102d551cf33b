#include "io/clouds/e57/e57_left_out.h"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>

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

/// Attributes that some of the scans with points lack, those that the same scans lack together.
void add_lacks(const std::vector<E57Scan>& scans, const E57Layout& layout,
               std::vector<std::string>& lost) {
  const auto with_points = static_cast<std::size_t>(
      std::ranges::count_if(scans, [](const E57Scan& scan) { return scan.records != 0; }));
  std::vector<std::pair<std::vector<std::size_t>, std::vector<std::string>>> lacks;
  for (std::size_t a = 0; a < layout.schema.attributes.size(); ++a) {
    std::vector<std::size_t> lacking;
    for (std::size_t i = 0; i < scans.size(); ++i)
      if (scans[i].records != 0 && !layout.scans[i].attributes[a].field) lacking.push_back(i);
    if (lacking.empty()) continue;
    if (lacks.empty() || lacks.back().first != lacking) lacks.push_back({lacking, {}});
    lacks.back().second.push_back(layout.schema.attributes[a].name);
  }
  for (const auto& [lacking, names] : lacks)
    lost.push_back("which points have " + joined(names) + ": " + std::to_string(lacking.size()) +
                   " of " + std::to_string(with_points) + " scans " +
                   (lacking.size() == 1 ? "has none, and its" : "have none, and their") +
                   " points get 0");
}

}  // namespace

std::vector<std::string> lost_values_of_e57(const std::vector<E57Scan>& scans,
                                            const E57Layout& layout) {
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
  if (any_normal && !layout.schema.has_normals)
    lost.emplace_back("normals, which not all scans of the file have");
  if (!names.empty())
    lost.push_back((names.size() == 1 ? "field " : "fields ") +
                   joined({names.begin(), names.end()}));
  add_lacks(scans, layout, lost);
  return lost;
}

}  // namespace orbweave
