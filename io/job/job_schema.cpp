#include "io/job/job_schema.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "io/job/job_keys.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

/// As io/text/quantity.h reads them.
constexpr const char* kQuantity =
    "^[ \\t]*([0-9]+\\.?[0-9]*|\\.[0-9]+)([eE][+-]?[0-9]+)?[ \\t]*([kKmMgGtT]([iI]?[bB])?|[bB])?[ "
    "\\t]*$";
constexpr const char* kColor = "^#[0-9a-fA-F]{6}$";
/// As io/simplify_target.h reads it; limits aside.
constexpr const char* kSimplification =
    "^[ \\t]*\\{?[ \\t]*(ratio|triangles|error)[ \\t]*=[ \\t]*[0-9.]+([eE][+-]?[0-9]+)?[ "
    "\\t]*\\}?[ \\t]*$|^$";

/// An integer where it is one, so that limits read as they are written.
Json limit(double number) {
  constexpr double kExact = 9007199254740992.0;
  if (std::floor(number) == number && std::abs(number) < kExact)
    return static_cast<std::int64_t>(number);
  return number;
}

Json number_schema(const JobKeyLimits& limits, bool is_integer) {
  if (!limits.values.empty()) return {{"enum", limits.values}};
  Json schema = {{"type", is_integer ? "integer" : "number"}};
  if (std::isfinite(limits.least))
    schema[limits.is_above ? "exclusiveMinimum" : "minimum"] = limit(limits.least);
  if (std::isfinite(limits.most)) schema["maximum"] = limit(limits.most);
  return schema;
}

Json text_schema() { return {{"type", "string"}}; }
Json name_schema() { return {{"type", "string"}, {"minLength", 1}}; }

/// A list, and what the program takes for a list of one.
void add_lists(Json& forms, const Json& item, const JobKeyLimits& limits) {
  const auto list = [&](int least, int most) {
    Json schema = {{"type", "array"}, {"items", item}};
    if (least > 0) schema["minItems"] = least;
    if (most >= 0) schema["maxItems"] = most;
    return schema;
  };
  for (const int length : limits.lengths) forms.push_back(list(length, length));
  if (!limits.lengths.empty()) return;
  forms.push_back(list(limits.least_length, -1));
  forms.push_back(item);
}

/// What a key accepts, each in a form of its own.
Json forms_of(const JobKey& key) {
  Json forms = Json::array();
  switch (key.type) {
    case JobKeyType::kTexts:
    case JobKeyType::kPaths:
      add_lists(forms, name_schema(), key.limits);
      break;
    case JobKeyType::kPath:
    case JobKeyType::kDirectory:
      forms.push_back(text_schema());
      break;
    case JobKeyType::kFlag:
      forms.push_back({{"type", "boolean"}});
      break;
    case JobKeyType::kChoice:
      forms.push_back({{"enum", key.choices}});
      break;
    case JobKeyType::kInteger:
      forms.push_back(number_schema(key.limits, true));
      break;
    case JobKeyType::kBytes:
      forms.push_back(number_schema(key.limits, true));
      forms.push_back({{"type", "string"}, {"pattern", kQuantity}});
      break;
    case JobKeyType::kNumber:
      forms.push_back(number_schema(key.limits, false));
      break;
    case JobKeyType::kNumbers:
      add_lists(forms, number_schema(key.limits, key.limits.is_whole), key.limits);
      break;
    case JobKeyType::kColor:
      forms.push_back({{"type", "string"}, {"pattern", kColor}});
      break;
    case JobKeyType::kSimplification:
      forms.push_back({{"type", "string"}, {"pattern", kSimplification}});
      forms.push_back({{"type", "object"},
                       {"additionalProperties", false},
                       {"minProperties", 1},
                       {"maxProperties", 1},
                       {"properties",
                        {{"ratio", {{"type", "number"}, {"exclusiveMinimum", 0}, {"maximum", 1}}},
                         {"triangles", {{"type", "integer"}, {"minimum", 1}}},
                         {"error", {{"type", "number"}, {"exclusiveMinimum", 0}}}}}});
      break;
  }
  if (key.limits.has_zero) forms.push_back({{"enum", {0}}});
  if (!key.limits.words.empty()) forms.push_back({{"enum", key.limits.words}});
  return forms;
}

/// JSON has no infinity; the description says it in words.
Json default_of(const JobKey& key) {
  return std::visit(
      [](const auto& value) -> Json {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
          if (!std::isfinite(value)) return nullptr;
        return value;
      },
      key.get(Job{}));
}

Json key_schema(const JobKey& key) {
  Json schema = {{"description", std::string(key.help) + ". Accepted: " + key.expected()}};
  if (const Json usual = default_of(key); !usual.is_null()) schema["default"] = usual;
  const Json forms = forms_of(key);
  if (forms.size() == 1)
    schema.update(forms.front());
  else
    schema["anyOf"] = forms;
  return schema;
}

Json section_schema() {
  return {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
}

}  // namespace

nlohmann::ordered_json job_schema() {
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                 {"title", "A job of orbweave"},
                 {"description", "What orbweave run does, as its job file (TOML) says it."}};
  schema.update(section_schema());
  Json& sections = schema["properties"];
  for (const JobKey& key : job_keys()) {
    if (!sections.contains(key.section)) sections[key.section] = section_schema();
    sections[key.section]["properties"][key.key] = key_schema(key);
  }
  for (const FormerSection& known : former_sections()) {
    const std::string former(known.former), section(known.section);
    sections[former] = {{"$ref", "#/properties/" + section}, {"deprecated", true}};
    schema["not"] = {{"required", {former, section}}};
  }
  return schema;
}

}  // namespace orbweave
