#include "io/text/quantity.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "io/text/lower_case.h"

namespace orbweave {
namespace {

constexpr std::array<const char*, 4> kBinaryUnits = {"KiB", "MiB", "GiB", "TiB"};

/// Bytes of one unit; 0 for an unknown one.
double unit_bytes(std::string_view written) {
  const std::string unit = lower_case(std::string(written));
  if (unit.empty() || unit == "b") return 1.0;
  constexpr std::string_view kPrefixes = "kmgt";
  const std::size_t power = kPrefixes.find(unit[0]);
  if (power == std::string_view::npos) return 0.0;
  const std::string_view rest = std::string_view(unit).substr(1);
  if (rest == "b") return std::pow(1000.0, static_cast<double>(power + 1));
  if (rest.empty() || rest == "ib") return std::pow(1024.0, static_cast<double>(power + 1));
  return 0.0;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

std::string fixed(double value, int decimals) {
  std::array<char, 400> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals);
  return {text.data(), end.ptr};
}

std::string two_units(std::uint64_t amount, std::uint64_t factor, const char* large,
                      const char* small) {
  return std::to_string(amount / factor) + " " + large + " " + std::to_string(amount % factor) +
         " " + small;
}

/// Three significant digits, without an exponent below 1000.
std::string three_digits(double value) {
  return fixed(value, value < 9.995 ? 2 : value < 99.95 ? 1 : 0);
}

}  // namespace

std::optional<std::uint64_t> parse_bytes(std::string_view text) {
  text = trimmed(text);
  const char* const last = text.data() + text.size();
  std::uint64_t whole = 0;
  const auto integer = std::from_chars(text.data(), last, whole);
  constexpr std::uint64_t kLimit = std::uint64_t{1} << 63;
  if (integer.ec == std::errc() && integer.ptr == last)
    return whole < kLimit ? std::optional(whole) : std::nullopt;
  double number = 0.0;
  const auto decimal = std::from_chars(text.data(), last, number);
  if (decimal.ec != std::errc()) return std::nullopt;
  const std::string_view unit(decimal.ptr, static_cast<std::size_t>(last - decimal.ptr));
  const double bytes = number * unit_bytes(trimmed(unit));
  if (unit_bytes(trimmed(unit)) == 0.0 || !(bytes >= 0.0) || !(bytes < 0x1p63)) return std::nullopt;
  return static_cast<std::uint64_t>(bytes);
}

std::string format_bytes(std::uint64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " B";
  double value = static_cast<double>(bytes) / 1024.0;
  std::size_t unit = 0;
  for (; value >= 1023.95 && unit + 1 < kBinaryUnits.size(); ++unit) value /= 1024.0;
  return fixed(value, 1) + " " + kBinaryUnits[unit];
}

std::string exact_bytes(std::uint64_t bytes) {
  int unit = -1;
  while (bytes != 0 && bytes % 1024 == 0 && unit + 1 < static_cast<int>(kBinaryUnits.size())) {
    bytes /= 1024;
    ++unit;
  }
  return std::to_string(bytes) + (unit < 0 ? "" : kBinaryUnits[static_cast<std::size_t>(unit)]);
}

std::string format_percent(double share) {
  const double value = 100.0 * share;
  return (value < 1.0 ? "under 1" : format_number(std::round(value))) + " %";
}

std::string format_count(std::uint64_t count) {
  const std::string digits = std::to_string(count);
  std::string text;
  for (std::size_t at = 0; at < digits.size(); ++at) {
    if (at > 0 && (digits.size() - at) % 3 == 0) text += ',';
    text += digits[at];
  }
  return text;
}

std::string format_rate(double per_second) {
  if (!(per_second >= 0.0) || !std::isfinite(per_second)) return "0";
  if (per_second < 999.5) return fixed(per_second, 0);
  constexpr std::array<const char*, 4> kPrefixes = {"k", "M", "G", "T"};
  double value = per_second / 1e3;
  std::size_t prefix = 0;
  for (; value >= 999.5 && prefix + 1 < kPrefixes.size(); ++prefix) value /= 1e3;
  return three_digits(value) + kPrefixes[prefix];
}

std::string format_duration(double seconds) {
  if (!(seconds >= 0.0) || seconds > 1e15) return "unknown";
  if (seconds < 9.95) return fixed(seconds, 1) + " s";
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 3600) return two_units(whole, 60, "min", "s");
  return two_units(whole / 60, 60, "h", "min");
}

namespace {

std::string with_digits(double value, int digits) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, digits);
  return {text.data(), end.ptr};
}

}  // namespace

std::string format_coordinate(double value) {
  return with_digits(value + 0.0, 10);  // "0" for -0 as well
}

std::string format_position(Vec3 position) {
  return "(" + format_coordinate(position.x) + ", " + format_coordinate(position.y) + ", " +
         format_coordinate(position.z) + ")";
}

std::string format_number(double value) { return with_digits(value, 6); }

std::string format_exact(double value) {
  std::array<char, 64> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

}  // namespace orbweave
