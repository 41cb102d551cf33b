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

/// The name that an attribute had before CloudCompare wrote it to a PLY file: its "Return Number"
/// is scalar_Return_Number there.
std::string_view without_prefix(std::string_view name) {
  constexpr std::string_view kPrefix = "scalar_";
  const bool has_prefix = lower_case(std::string(name.substr(0, kPrefix.size()))) == kPrefix;
  return has_prefix ? name.substr(kPrefix.size()) : name;
}

}  // namespace

bool have_same_name(std::string_view a, std::string_view b) {
  return common_name(without_prefix(a)) == common_name(without_prefix(b));
}

std::optional<NamedAttribute> find_attribute(const PointSchema& schema, std::string_view name) {
  std::optional<NamedAttribute> with_prefix;
  std::size_t offset = 0;
  for (const AttributeField& field : schema.attributes) {
    if (common_name(field.name) == common_name(name)) return NamedAttribute(offset, field.type);
    if (!with_prefix && have_same_name(field.name, name))
      with_prefix = NamedAttribute(offset, field.type);
    offset += size_of(field.type);
  }
  return with_prefix;
}

}  // namespace orbweave
