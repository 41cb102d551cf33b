#include "io/text/json_dump.h"

#include <nlohmann/json.hpp>

#include "io/json_nesting.h"
#include "io/shown_text.h"

namespace orbweave {
namespace {

/// Whether any string in it, names of members included, has to be changed: then it is copied.
template <class Json, class HasTo>
bool any_text(const Json& json, const HasTo& has_to) {
  if (json.is_string()) return has_to(json.template get_ref<const std::string&>());
  if (!json.is_structured()) return false;
  for (const auto& [name, value] : json.items()) {
    if (json.is_object() && has_to(name)) return true;
    if (any_text(value, has_to)) return true;
  }
  return false;
}

bool is_no_utf8(const std::string& text) { return !is_utf8(text); }
bool has_backslash(const std::string& text) { return text.find('\\') != std::string::npos; }

/// A copy with change(string) for every string, names of members included.
template <class Json, class Change>
Json changed(const Json& json, const Change& change) {
  if (json.is_string()) return change(json.template get_ref<const std::string&>());
  if (!json.is_structured()) return json;
  Json result = json.is_array() ? Json::array() : Json::object();
  for (const auto& [name, value] : json.items()) {
    if (json.is_array())
      result.push_back(changed(value, change));
    else
      result[change(name)] = changed(value, change);
  }
  return result;
}

}  // namespace

std::string json_dump(const nlohmann::ordered_json& json, int indent) {
  if (!any_text(json, is_no_utf8)) return json.dump(indent);
  return changed(json, as_utf8).dump(indent);
}

std::string document_text(const nlohmann::json& json) {
  const auto needs_escape = [](const std::string& text) {
    return is_no_utf8(text) || has_backslash(text);
  };
  if (!any_text(json, needs_escape)) return json.dump();
  return changed(json, escaped_text).dump();
}

nlohmann::json document_from(std::string_view text) {
  if (nests_too_deeply(text)) text = {};  // which is no JSON, either
  nlohmann::json json = nlohmann::json::parse(text);
  if (!any_text(json, has_backslash)) return json;
  return changed(json, unescaped_text);
}

}  // namespace orbweave
