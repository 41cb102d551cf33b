#include "io/text/column_name.h"

#include <array>
#include <utility>

#include "io/text/lower_case.h"
#include "io/text/text_fields.h"

namespace orbweave {
std::string_view without_unit(std::string_view name) {
  const bool has_unit = name.ends_with(']') || name.ends_with(')');
  const std::size_t open = name.find(name.ends_with(']') ? '[' : '(');
  return has_unit && open != name.npos ? trimmed(name.substr(0, open)) : name;
}

std::string canonical_column_name(std::string_view name) {
  const std::string lower = lower_case(std::string(without_unit(name)));
  constexpr std::array<std::pair<std::string_view, const char*>, 21> kSynonyms = {
      {{"x", "x"},         {"y", "y"},         {"z", "z"},
       {"nx", "nx"},       {"ny", "ny"},       {"nz", "nz"},
       {"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"},
       {"normalx", "nx"},  {"normaly", "ny"},  {"normalz", "nz"},
       {"r", "red"},       {"g", "green"},     {"b", "blue"},
       {"red", "red"},     {"green", "green"}, {"blue", "blue"},
       {"a", "alpha"},     {"alpha", "alpha"}, {"intensity", "intensity"}}};
  for (const auto& [synonym, canonical] : kSynonyms)
    if (lower == synonym) return canonical;
  return std::string(name);
}

}  // namespace orbweave
