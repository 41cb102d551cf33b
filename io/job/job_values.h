// Checks and conversions that the job file's keys share.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/job/written_value.h"
#include "io/vec3.h"

namespace orbweave {

// Each throws UnsuitableValue where the value does not fit.
bool flag_value(const WrittenValue& value);
std::int64_t integer_value(const WrittenValue& value, std::int64_t least, std::int64_t most);
/// One of the choices, by index.
std::size_t choice_value(const WrittenValue& value, Choices choices);
/// From `least` to `most`, which may be infinite.
double number_value(const WrittenValue& value, double least, double most);
/// Above 0; infinity is one.
double limit_value(const WrittenValue& value);
std::uint64_t bytes_value(const WrittenValue& value, std::uint64_t least);
std::string text_value(const WrittenValue& value);
/// A list, or one text that stands for a list of one.
std::vector<std::string> texts_value(const WrittenValue& value);
/// Positive and ascending, at least one; a single number stands for a list of one.
std::vector<double> ascending_value(const WrittenValue& value);
/// Finite numbers; a single one stands for a list of one.
std::vector<double> numbers_value(const WrittenValue& value);
/// Three finite numbers.
Vec3 vector_value(const WrittenValue& value);
/// Red, green and blue of "#4477cc".
std::array<std::uint8_t, 3> color_value(const WrittenValue& value);
/// True for the text "auto".
bool is_auto(const WrittenValue& value);

/// A path, relative to the value's base directory; "" and "-" stay as they are.
std::string path_value(const WrittenValue& value);
/// Paths and patterns, likewise.
std::vector<std::string> patterns_value(const WrittenValue& value);

}  // namespace orbweave
