#include "io/store/json_member.h"

#include <nlohmann/json.hpp>

namespace orbweave {

std::string string_member(const nlohmann::json& json, const char* name) {
  if (!json.is_object() || !json.contains(name) || !json[name].is_string()) return {};
  return json[name].get<std::string>();
}

}  // namespace orbweave
