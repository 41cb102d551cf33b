#include "io/text/column_name.h"

#include <array>
#include <utility>

#include "io/text/lower_case.h"

namespace orbweave {

std::string canonical_column_name(std::string_view name) {
  const std::string lower = lower_case(std::string(name));
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
