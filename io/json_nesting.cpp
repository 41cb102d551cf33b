#include "io/json_nesting.h"

#include <nlohmann/json.hpp>

namespace orbweave {

bool nests_too_deeply(std::string_view text) {
  std::size_t levels = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') in_string = !in_string;
    if (in_string) {
      if (c == '\\') ++i;
    } else if (c == '[' || c == '{') {
      if (++levels > kMostJsonLevels) return true;
    } else if ((c == ']' || c == '}') && levels > 0) {
      --levels;
    }
  }
  return false;
}

std::string expected_json_levels() {
  return "at most " + std::to_string(kMostJsonLevels) + " levels";
}

nlohmann::json json_of(std::string_view text) {
  if (nests_too_deeply(text)) return nlohmann::json::value_t::discarded;
  return nlohmann::json::parse(text, nullptr, false);
}

}  // namespace orbweave
