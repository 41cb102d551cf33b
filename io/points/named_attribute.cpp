#include "io/points/named_attribute.h"

#include <string>

#include "io/text/lower_case.h"

namespace orbweave {
namespace {

/// What names of an attribute have in common, from format to format.
std::string common_name(std::string_view name) {
  std::string common = lower_case(std::string(name));
  std::erase(common, '_');
  return common;
}

}  // namespace

bool have_same_name(std::string_view a, std::string_view b) {
  return common_name(a) == common_name(b);
}

std::optional<NamedAttribute> find_attribute(const PointSchema& schema, std::string_view name) {
  const std::string wanted = common_name(name);
  std::size_t offset = 0;
  for (const AttributeField& field : schema.attributes) {
    if (common_name(field.name) == wanted) return NamedAttribute(offset, field.type);
    offset += size_of(field.type);
  }
  return std::nullopt;
}

}  // namespace orbweave
