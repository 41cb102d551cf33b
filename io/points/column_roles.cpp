#include "io/points/column_roles.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "io/text/lower_case.h"

namespace orbweave {
namespace {

using Names = std::array<const char*, 3>;
using Places = std::array<std::size_t, 3>;

// The first of each are the names of the role.
constexpr std::array<Names, 1> kPositions = {{{"x", "y", "z"}}};
/// PCL's name is normal_x, PDAL's NormalX or normalx. CloudCompare makes scalar fields of normals.
constexpr std::array<Names, 5> kNormals = {
    {{"nx", "ny", "nz"},
     {"normal_x", "normal_y", "normal_z"},
     {"normalx", "normaly", "normalz"},
     {"scalar_nx", "scalar_ny", "scalar_nz"},
     {"scalar_normalx", "scalar_normaly", "scalar_normalz"}}};
/// PMVS and older scanners write diffuse_red.
constexpr std::array<Names, 3> kColors = {
    {{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}, {"r", "g", "b"}}};

std::optional<Places> find_all(const std::vector<RowColumn>& columns, const Names& names) {
  Places places{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = std::ranges::find_if(
        columns, [&](const RowColumn& column) { return lower_case(column.name) == names[i]; });
    if (at == columns.end()) return std::nullopt;
    places[i] = static_cast<std::size_t>(at - columns.begin());
  }
  return places;
}

void name_by_role(std::vector<RowColumn>& columns, std::span<const Names> notations) {
  const Names& role = notations.front();
  const bool is_taken = std::ranges::any_of(columns, [&](const RowColumn& column) {
    return std::ranges::find(role, column.name) != role.end();
  });
  if (is_taken) return;
  for (const Names& names : notations) {
    const std::optional<Places> places = find_all(columns, names);
    if (!places) continue;
    for (std::size_t i = 0; i < role.size(); ++i) columns[(*places)[i]].name = role[i];
    return;
  }
}

}  // namespace

void name_by_roles(std::vector<RowColumn>& columns) {
  name_by_role(columns, kPositions);
  name_by_role(columns, kNormals);
  name_by_role(columns, kColors);
}

}  // namespace orbweave
