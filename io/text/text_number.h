// Numbers from text, fast and exact, independent of the locale.
#pragma once

#include <cstdint>
#include <string_view>

#include "io/point_cloud.h"

namespace orbweave {

/// Parses the number at the front of [first, last); the nearest double or float, bit for bit
/// what std::from_chars gives, also for "nan" and "inf"; a leading '+' is accepted. What is too
/// small for the type is 0 of its sign, the nearest there is. Returns the end of the number, or
/// nullptr where there is none or it is too large.
const char* parse_number(const char* first, const char* last, double& value);
const char* parse_number(const char* first, const char* last, float& value);

/// How parse_value went.
enum class ParseOutcome { kNumber, kNoNumber, kOutOfRange };

/// Parses a whole token as a value of `type` and stores it, in native byte order, at `out`
/// (size_of(type) bytes). Integer types also accept integral decimals such as "255.0".
ParseOutcome parse_value(std::string_view token, ScalarType type, std::byte* out);

/// "a number", "an integer from 0 to 255": what parse_value would have accepted.
const char* expected_value(ScalarType type);

}  // namespace orbweave
