#include "io/meshes/attribute_names.h"

#include <cstddef>
#include <set>
#include <utility>

namespace orbweave {

std::vector<std::string> attribute_names(const PointSchema& schema,
                                         const std::function<std::string(std::string)>& plain,
                                         DistinctNames::Meaning meaning) {
  std::set<std::string> fixed = {"x", "y", "z"};
  if (schema.has_normals) fixed.insert({"nx", "ny", "nz"});
  DistinctNames distinct(std::move(fixed), std::move(meaning));
  std::vector<std::string> names;
  std::vector<bool> stays;
  for (const AttributeField& field : schema.attributes) {
    names.push_back(plain(field.name));
    stays.push_back(names.back() == field.name && distinct.take(field.name));
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!stays[i]) names[i] = distinct.give(names[i]);
  return names;
}

}  // namespace orbweave
