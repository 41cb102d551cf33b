#include "engine/cli/numbers.h"

#include <cmath>

#include "io/error.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

[[noreturn]] void reject(const std::string& option, const std::string& text, const char* expected) {
  throw_usage("wrong value of " + option, {.found = "\"" + text + "\"", .expected = expected});
}

double parsed(const std::string& option, const std::string& text, const char* expected) {
  const char* last = text.data() + text.size();
  double value = 0.0;
  if (parse_number(text.data(), last, value) != last || !std::isfinite(value))
    reject(option, text, expected);
  return value;
}

}  // namespace

double number_argument(const std::string& option, const std::string& text) {
  return parsed(option, text, "a number");
}

double positive_argument(const std::string& option, const std::string& text) {
  constexpr const char* kExpected = "a finite number above 0";
  const double value = parsed(option, text, kExpected);
  if (!(value > 0.0)) reject(option, text, kExpected);
  return value;
}

std::uint64_t count_argument(const std::string& option, const std::string& text) {
  constexpr const char* kExpected = "a whole number, such as 10000 or 2e6";
  constexpr double kLargest = 9007199254740992.0;  // doubles count exactly up to here
  const double value = parsed(option, text, kExpected);
  if (value < 0.0 || value > kLargest || value != std::floor(value))
    reject(option, text, kExpected);
  return static_cast<std::uint64_t>(value);
}

}  // namespace orbweave
