// The schema of job files and the file of defaults, held against the program that reads job files.
#include "io/job/job_schema.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "io/error.h"
#include "io/job/job_defaults.h"
#include "io/job/job_file.h"
#include "io/job/job_reference.h"
#include "io/job/toml_document.h"

namespace orbweave {
namespace {

using nlohmann::ordered_json;
using Strings = std::vector<std::string>;

bool has_type(const ordered_json& value, const std::string& type) {
  if (type == "integer")
    return value.is_number_integer() ||
           (value.is_number_float() && std::floor(value.get<double>()) == value.get<double>());
  if (type == "number") return value.is_number();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  return type == "array" && value.is_array();
}

bool accepts(const ordered_json& schema, const ordered_json& value);

/// One keyword of a schema; those of the program's schema and no others.
bool keeps(const std::string& keyword, const ordered_json& rule, const ordered_json& value) {
  if (keyword == "description" || keyword == "default") return true;
  if (keyword == "type") return has_type(value, rule);
  if (keyword == "enum") return std::find(rule.begin(), rule.end(), value) != rule.end();
  if (keyword == "minimum") return value >= rule;
  if (keyword == "maximum") return value <= rule;
  if (keyword == "exclusiveMinimum") return value > rule;
  if (keyword == "minLength") return value.get<std::string>().size() >= rule.get<std::size_t>();
  if (keyword == "minItems") return value.size() >= rule.get<std::size_t>();
  if (keyword == "maxItems") return value.size() <= rule.get<std::size_t>();
  if (keyword == "pattern")
    return std::regex_search(value.get<std::string>(), std::regex(rule.get<std::string>()));
  if (keyword == "items")
    return std::all_of(value.begin(), value.end(),
                       [&](const ordered_json& item) { return accepts(rule, item); });
  if (keyword == "anyOf")
    return std::any_of(rule.begin(), rule.end(),
                       [&](const ordered_json& form) { return accepts(form, value); });
  FAIL("the schema has the keyword " << keyword << ", which this test does not know");
  return false;
}

bool accepts(const ordered_json& schema, const ordered_json& value) {
  if (schema.contains("type") && !has_type(value, schema["type"])) return false;
  for (const auto& [keyword, rule] : schema.items())
    if (!keeps(keyword, rule, value)) return false;
  return true;
}

/// Values of all types, at and beside the limits of every key. JSON and TOML write them alike.
Strings sample_values() {
  Strings values = {"true",
                    "false",
                    "-1",
                    "0",
                    "1",
                    "2",
                    "3",
                    "4",
                    "8",
                    "9",
                    "16",
                    "255",
                    "256",
                    "257",
                    "4096",
                    "4097",
                    "1e5",
                    "100000",
                    "100001",
                    "67108863",
                    "67108864",
                    "-0.5",
                    "0.0",
                    "0.15",
                    "1.0",
                    "1.5",
                    "2.5e300",
                    "1e-76",
                    "[]",
                    "[1]",
                    "[0]",
                    "[-1]",
                    "[255]",
                    "[256]",
                    "[2.5]",
                    "[1, 2]",
                    "[\"a\"]",
                    "[\"\"]",
                    "[true]",
                    "[1, 2, 3]",
                    "[0, 0, 1, 2]",
                    "[1, 2, 3, 0]",
                    "[1, 2, 3, 4, 5]",
                    "[0, 0, 0, 1, 1, 1]",
                    "[0, 0, 0, 1, 1, 1, 1]",
                    "[1e-80]",
                    "[1e80]",
                    "[[1]]",
                    "{}",
                    "\"\"",
                    "\"a.ply\"",
                    "\"auto\"",
                    "\"none\"",
                    "\",\"",
                    "\"\\t\"",
                    "\"4GiB\"",
                    "\"1.5 gb\"",
                    "\"4 apples\"",
                    "\"1e9\"",
                    "\"#4477cc\"",
                    "\"#4477c\"",
                    "\"4477cc\""};
  for (const JobKey& key : job_keys())
    for (const char* const choice : key.choices) values.push_back('"' + std::string(choice) + '"');
  return values;
}

bool program_accepts(const JobKey& key, const std::string& value) {
  try {
    parse_job("[" + std::string(key.section) + "]\n" + key.key + " = " + value + "\n", "job.toml");
    return true;
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    return false;
  }
}

/// What no schema can tell of these keys: the syntax of a text, and relations between numbers.
const std::set<std::string> kOnlyTheProgramKnows = {
    "input.pose",      "input.scanner", "input.scanners",         "input.crop",
    "input.crop_area", "normals.up",    "reconstruct.ball_radii", "partition.memory"};

/// JSON has one type of numbers: 1.0 is the integer 1 there, and none in TOML.
bool is_integer_with_a_point(const JobKey& key, const ordered_json& value) {
  const bool takes_integers = key.type == JobKeyType::kInteger || key.type == JobKeyType::kBytes;
  return takes_integers && value.is_number_float();
}

TEST_CASE("TheSchemaRefusesWhatTheProgramRefuses") {
  const ordered_json schema = job_schema();
  std::set<std::string> differing;
  for (const JobKey& key : job_keys()) {
    const ordered_json& rule = schema["properties"][key.section]["properties"][key.key];
    for (const std::string& value : sample_values()) {
      CAPTURE(key.name(), value);
      const ordered_json parsed = ordered_json::parse(value);
      const bool fits_schema = accepts(rule, parsed);
      const bool fits_program = program_accepts(key, value);
      if (fits_program) CHECK(fits_schema);
      if (fits_schema && !fits_program && !is_integer_with_a_point(key, parsed))
        differing.insert(key.name());
    }
  }
  // A key that is missing here and found there lacks its JobKeyLimits in the table of keys.
  for (const std::string& name : differing) {
    CAPTURE(name);
    CHECK(kOnlyTheProgramKnows.count(name) == 1);
  }
}

TEST_CASE("EveryDefaultFitsTheSchema") {
  const ordered_json schema = job_schema();
  for (const JobKey& key : job_keys()) {
    CAPTURE(key.name());
    const ordered_json& rule = schema["properties"][key.section]["properties"][key.key];
    REQUIRE(rule.contains("description"));
    if (rule.contains("default")) CHECK(accepts(rule, rule["default"]));
  }
}

TEST_CASE("TheSchemaKnowsNoOtherSectionAndNoOtherKey") {
  const ordered_json schema = job_schema();
  CHECK(schema["$schema"] == "https://json-schema.org/draft/2020-12/schema");
  CHECK(schema["additionalProperties"] == false);
  std::size_t keys = 0;
  for (const auto& [name, section] : schema["properties"].items()) {
    if (section.contains("$ref")) continue;
    CHECK(section["additionalProperties"] == false);
    keys += section["properties"].size();
  }
  CHECK(keys == job_keys().size());
}

TEST_CASE("AFormerNameOfASectionIsRefusedBesideTheNewOne") {
  const ordered_json schema = job_schema();
  CHECK(schema["properties"]["prepare"]["$ref"] == "#/properties/cleaning");
  CHECK(schema["not"]["required"] == ordered_json({"prepare", "cleaning"}));
}

TEST_CASE("TheCommentedJobFileIsTheDefaultJob") {
  const Job job = parse_job(commented_job_file(), "job.toml");
  CHECK(job_toml(job) == job_toml(Job{}));
}

TEST_CASE("TheCommentedJobFileSetsAndExplainsEveryKey") {
  const std::string text = commented_job_file();
  std::set<std::string> set_keys;
  for (const TomlEntry& entry : read_toml(text, "job.toml"))
    if (!entry.key.empty()) set_keys.insert(entry.section + "." + entry.key);
  CHECK(set_keys.size() == job_keys().size());
  for (const JobKey& key : job_keys()) CHECK(set_keys.count(key.name()) == 1);
  std::istringstream lines(text);
  for (std::string line, before; std::getline(lines, line); before = line) {
    CAPTURE(line);
    CHECK(line.size() <= 140);
    const bool is_key = !line.empty() && line[0] >= 'a' && line[0] <= 'z';
    if (is_key) CHECK(before.starts_with("#"));
  }
}

TEST_CASE("TheReferenceHasAHeadingForEveryKey") {
  const std::string page = job_key_reference();
  for (const JobKey& key : job_keys()) {
    CAPTURE(key.name());
    CHECK(page.find("\n### `" + key.name() + "`\n") != std::string::npos);
    CHECK(page.find("\n- Default: `" + key.default_text() + "`\n") != std::string::npos);
  }
}

}  // namespace
}  // namespace orbweave
