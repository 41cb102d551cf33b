#include "io/text/text_number.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace orbweave {
namespace {

// Short decimals are exact: an integer up to 2^53 and a power of ten up to 10^22 are doubles, so
// one rounding, that of the division, gives the nearest double. Clinger, How to Read Floating
// Point Numbers Accurately, 1990, section 5.
constexpr std::uint64_t kExactInteger = std::uint64_t{1} << 53;
constexpr int kExactPower = 22;
constexpr std::array<double, kExactPower + 1> kPowersOfTen = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
constexpr int kMaxDigits = 18;  // of any value: they fit 64 bits

/// The end of a short decimal without exponent, or nullptr where this is not one.
inline const char* parse_short_decimal(const char* first, const char* last, double& value) {
  const char* at = first;
  const bool negative = at != last && *at == '-';
  if (negative) ++at;
  std::uint64_t mantissa = 0;
  const char* const whole = at;
  for (; at != last && static_cast<unsigned char>(*at - '0') < 10; ++at)
    mantissa = mantissa * 10 + static_cast<std::uint64_t>(*at - '0');
  std::ptrdiff_t digits = at - whole;
  std::ptrdiff_t decimals = 0;
  if (at != last && *at == '.') {
    const char* const fraction = ++at;
    for (; at != last && static_cast<unsigned char>(*at - '0') < 10; ++at)
      mantissa = mantissa * 10 + static_cast<std::uint64_t>(*at - '0');
    decimals = at - fraction;
    digits += decimals;
  }
  // Beyond kMaxDigits the mantissa has wrapped and means nothing.
  if (digits == 0 || digits > kMaxDigits || mantissa > kExactInteger) return nullptr;
  if (at != last && (*at == 'e' || *at == 'E')) return nullptr;
  const double magnitude =
      static_cast<double>(mantissa) / kPowersOfTen[static_cast<std::size_t>(decimals)];
  value = negative ? -magnitude : magnitude;
  return at;
}

/// A double that was rounded to nearest may be rounded on to float unless it lies exactly half
/// way between two floats (the first rounding may have put it there) or below the normal floats.
inline bool rounds_safely_to_float(double value) {
  constexpr std::uint64_t kDropped = (std::uint64_t{1} << 29) - 1;
  constexpr std::uint64_t kHalfWay = std::uint64_t{1} << 28;
  const double magnitude = std::fabs(value);
  if (magnitude == 0.0) return true;
  return magnitude >= static_cast<double>(std::numeric_limits<float>::min()) &&
         magnitude < static_cast<double>(std::numeric_limits<float>::max()) &&
         (std::bit_cast<std::uint64_t>(value) & kDropped) != kHalfWay;
}

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

/// The sign of the exponent of a decimal, normalised to one digit before the point. Asked of
/// decimals far from 1 alone: what an exponent does not hold decides as well.
bool has_negative_exponent(const char* first, const char* last) {
  std::int64_t digits_before = 0, zeros_behind = 0;  // up to the first digit that is not 0
  bool is_significant = false, is_behind_point = false;
  for (; first != last && *first != 'e' && *first != 'E'; ++first) {
    if (*first == '.') is_behind_point = true;
    if (!is_digit(*first)) continue;
    is_significant = is_significant || *first != '0';
    if (is_significant && !is_behind_point) ++digits_before;
    if (!is_significant && is_behind_point) ++zeros_behind;
  }
  const std::int64_t of_digits = digits_before > 0 ? digits_before - 1 : -1 - zeros_behind;
  if (first == last) return of_digits < 0;
  ++first;
  if (first != last && *first == '+') ++first;
  std::int64_t written = 0;
  const auto [end, error] = std::from_chars(first, last, written);
  if (error != std::errc{}) return *first == '-';
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max() / 2;
  return std::clamp(written, -kMost, kMost) + of_digits < 0;
}

template <class T>
const char* parse_any(const char* first, const char* last, T& value) {
  if (last - first > 1 && *first == '+' && first[1] != '-') ++first;
  const auto [end, error] = std::from_chars(first, last, value);
  if (error == std::errc{}) return end;
  if (error != std::errc::result_out_of_range || !has_negative_exponent(first, end)) return nullptr;
  value = *first == '-' ? T{-0.0} : T{0.0};
  return end;
}

/// Whether the token is a decimal that is too large for a double.
bool is_beyond_doubles(std::string_view token) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
  double ignored = 0.0;
  const char* const last = token.data() + token.size();
  const auto [end, error] = std::from_chars(token.data(), last, ignored);
  return error == std::errc::result_out_of_range && end == last;
}

template <class T>
ParseOutcome parse_as(std::string_view token, std::byte* out) {
  if (token.empty()) return ParseOutcome::kNoNumber;
  const char* const last = token.data() + token.size();
  T value{};
  bool whole = false;
  if constexpr (std::is_floating_point_v<T>) {
    whole = parse_number(token.data(), last, value) == last;
  } else {
    const auto [end, error] = std::from_chars(token.data(), last, value);
    whole = error == std::errc{} && end == last;
  }
  if (!whole) {
    double number = 0.0;
    if (parse_number(token.data(), last, number) != last)
      return is_beyond_doubles(token) ? ParseOutcome::kOutOfRange : ParseOutcome::kNoNumber;
    if constexpr (std::is_floating_point_v<T>) return ParseOutcome::kOutOfRange;
    // The upper bound of a 64-bit type is no double; the power of two above it is.
    constexpr auto kHalfOfEnd = std::numeric_limits<T>::max() / 2 + 1;
    constexpr double kEnd = 2.0 * static_cast<double>(kHalfOfEnd);
    if (!(number >= static_cast<double>(std::numeric_limits<T>::min()) && number < kEnd) ||
        number != std::floor(number))
      return ParseOutcome::kOutOfRange;
    value = static_cast<T>(number);
  }
  std::memcpy(out, &value, sizeof value);
  return ParseOutcome::kNumber;
}

}  // namespace

const char* parse_number(const char* first, const char* last, double& value) {
  const char* const end = parse_short_decimal(first, last, value);
  return end != nullptr ? end : parse_any(first, last, value);
}

const char* parse_number(const char* first, const char* last, float& value) {
  double wide = 0.0;
  const char* const end = parse_short_decimal(first, last, wide);
  if (end == nullptr || !rounds_safely_to_float(wide)) return parse_any(first, last, value);
  value = static_cast<float>(wide);
  return end;
}

ParseOutcome parse_value(std::string_view token, ScalarType type, std::byte* out) {
  switch (type) {
    case ScalarType::kInt8:
      return parse_as<std::int8_t>(token, out);
    case ScalarType::kUint8:
      return parse_as<std::uint8_t>(token, out);
    case ScalarType::kInt16:
      return parse_as<std::int16_t>(token, out);
    case ScalarType::kUint16:
      return parse_as<std::uint16_t>(token, out);
    case ScalarType::kInt32:
      return parse_as<std::int32_t>(token, out);
    case ScalarType::kUint32:
      return parse_as<std::uint32_t>(token, out);
    case ScalarType::kInt64:
      return parse_as<std::int64_t>(token, out);
    case ScalarType::kUint64:
      return parse_as<std::uint64_t>(token, out);
    case ScalarType::kFloat32:
      return parse_as<float>(token, out);
    case ScalarType::kFloat64:
      return parse_as<double>(token, out);
  }
  return ParseOutcome::kNoNumber;
}

const char* expected_value(ScalarType type) {
  constexpr std::array<const char*, 10> kExpected = {"an integer from -128 to 127",
                                                     "an integer from 0 to 255",
                                                     "an integer from -32768 to 32767",
                                                     "an integer from 0 to 65535",
                                                     "an integer of 32 bits",
                                                     "an unsigned integer of 32 bits",
                                                     "an integer of 64 bits",
                                                     "an unsigned integer of 64 bits",
                                                     "a number of 32 bits",
                                                     "a number"};
  return kExpected[static_cast<std::size_t>(type)];
}

}  // namespace orbweave
