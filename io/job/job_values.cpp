#include "io/job/job_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "io/system/glob.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

template <class T>
const T* scalar(const WrittenValue& value) {
  const bool is_scalar = value.shape == WrittenValue::Shape::kScalar && value.items.size() == 1;
  return is_scalar ? std::get_if<T>(&value.items.front()) : nullptr;
}

[[noreturn]] void reject() { throw UnsuitableValue{}; }

/// System calls would take such a path for its beginning.
const std::string& checked_path(const std::string& path) {
  if (path.find('\0') != std::string::npos) throw UnsuitableValue{"a path has no zero bytes", ""};
  return path;
}

bool keeps_its_name(const std::string& path, const WrittenValue& value) {
  return path.empty() || path == "-" || value.base_directory.empty() ||
         std::filesystem::path(path).is_absolute();
}

std::string from_base(const std::string& path, const WrittenValue& value) {
  if (keeps_its_name(checked_path(path), value)) return path;
  return (value.base_directory / path).string();
}

std::string pattern_from_base(const std::string& pattern, const WrittenValue& value) {
  if (!is_glob(pattern) || keeps_its_name(pattern, value)) return from_base(pattern, value);
  return escape_glob((value.base_directory / "").string()) + checked_path(pattern);
}

double number_of(const WrittenValue::Scalar& item) {
  if (const auto* integer = std::get_if<std::int64_t>(&item)) return static_cast<double>(*integer);
  if (const auto* number = std::get_if<double>(&item)) return *number;
  reject();
}

}  // namespace

bool flag_value(const WrittenValue& value) {
  const bool* flag = scalar<bool>(value);
  if (flag == nullptr) reject();
  return *flag;
}

std::int64_t integer_value(const WrittenValue& value, std::int64_t least, std::int64_t most) {
  const std::int64_t* integer = scalar<std::int64_t>(value);
  if (integer == nullptr || *integer < least || *integer > most) reject();
  return *integer;
}

double number_value(const WrittenValue& value, double least, double most) {
  if (value.shape != WrittenValue::Shape::kScalar || value.items.size() != 1) reject();
  const double number = number_of(value.items.front());
  if (!(number >= least && number <= most)) reject();
  return number;
}

double limit_value(const WrittenValue& value) {
  return number_value(value, std::numeric_limits<double>::denorm_min(),
                      std::numeric_limits<double>::infinity());
}

std::size_t choice_value(const WrittenValue& value, Choices choices) {
  const std::string* text = scalar<std::string>(value);
  const auto chosen = text == nullptr ? choices.end() : std::ranges::find(choices, *text);
  if (chosen == choices.end()) reject();
  return static_cast<std::size_t>(chosen - choices.begin());
}

std::uint64_t bytes_value(const WrittenValue& value, std::uint64_t least) {
  std::optional<std::uint64_t> bytes;
  if (const std::string* text = scalar<std::string>(value)) bytes = parse_bytes(*text);
  if (const std::int64_t* integer = scalar<std::int64_t>(value); integer && *integer >= 0)
    bytes = static_cast<std::uint64_t>(*integer);
  if (!bytes || *bytes < least) reject();
  return *bytes;
}

std::string text_value(const WrittenValue& value) {
  const std::string* text = scalar<std::string>(value);
  if (text == nullptr) reject();
  return *text;
}

std::vector<std::string> texts_value(const WrittenValue& value) {
  if (value.shape == WrittenValue::Shape::kOther) reject();
  std::vector<std::string> texts;
  for (const auto& item : value.items) {
    const std::string* text = std::get_if<std::string>(&item);
    if (text == nullptr || text->empty()) reject();
    texts.push_back(*text);
  }
  return texts;
}

std::vector<double> ascending_value(const WrittenValue& value) {
  if (value.shape == WrittenValue::Shape::kOther || value.items.empty()) reject();
  std::vector<double> numbers;
  for (const auto& item : value.items) {
    const double number = number_of(item);
    if (!std::isfinite(number) || number <= (numbers.empty() ? 0.0 : numbers.back())) reject();
    numbers.push_back(number);
  }
  return numbers;
}

std::vector<double> numbers_value(const WrittenValue& value) {
  if (value.shape == WrittenValue::Shape::kOther) reject();
  std::vector<double> numbers;
  for (const auto& item : value.items) {
    numbers.push_back(number_of(item));
    if (!std::isfinite(numbers.back())) reject();
  }
  return numbers;
}

Vec3 vector_value(const WrittenValue& value) {
  const std::vector<double> numbers = numbers_value(value);
  if (numbers.size() != 3) reject();
  return {numbers[0], numbers[1], numbers[2]};
}

std::array<std::uint8_t, 3> color_value(const WrittenValue& value) {
  const std::string text = text_value(value);
  if (text.size() != 7 || text.front() != '#') reject();
  std::array<std::uint8_t, 3> color{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const char* digits = text.data() + 1 + 2 * channel;
    if (std::from_chars(digits, digits + 2, color[channel], 16).ptr != digits + 2) reject();
  }
  return color;
}

bool is_auto(const WrittenValue& value) {
  const std::string* text = scalar<std::string>(value);
  return text != nullptr && *text == "auto";
}

std::string path_value(const WrittenValue& value) { return from_base(text_value(value), value); }

std::vector<std::string> patterns_value(const WrittenValue& value) {
  std::vector<std::string> patterns = texts_value(value);
  for (std::string& pattern : patterns) pattern = pattern_from_base(pattern, value);
  return patterns;
}

}  // namespace orbweave
