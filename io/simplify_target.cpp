#include "io/simplify_target.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace orbweave {
namespace {

using Kind = SimplifyTarget::Kind;

constexpr std::array<std::string_view, 3> kNames = {"ratio", "triangles", "error"};
/// The largest integer below which a double tells all integers apart.
constexpr double kMostTriangles = 9007199254740992.0;

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string_view without_braces(std::string_view text) {
  const bool has_braces = text.size() >= 2 && text.front() == '{' && text.back() == '}';
  return has_braces ? text.substr(1, text.size() - 2) : text;
}

std::optional<double> number_of(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// The shortest text that reads back as the number.
std::string text_of(double number) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

}  // namespace

const char* accepted_by(Kind kind) {
  switch (kind) {
    case Kind::kRatio:
      return "a number above 0 and at most 1";
    case Kind::kTriangles:
      return "an integer of at least 1";
    case Kind::kError:
      return "a positive finite number";
  }
  return "";
}

bool is_accepted(const SimplifyTarget& target) {
  const double value = target.value;
  if (target.kind == Kind::kRatio) return value > 0.0 && value <= 1.0;
  if (target.kind == Kind::kTriangles)
    return value >= 1.0 && value <= kMostTriangles && value == std::floor(value);
  return value > 0.0 && value <= std::numeric_limits<double>::max();
}

std::optional<SimplifyTarget> parse_simplify_target(std::string_view text) {
  text = without_braces(without_blanks(text));
  const std::size_t equals = std::min(text.find('='), text.size());
  const std::string_view name = without_blanks(text.substr(0, equals));
  const auto known = std::find(kNames.begin(), kNames.end(), name);
  if (known == kNames.end() || equals == text.size()) return std::nullopt;
  const std::optional<double> number = number_of(without_blanks(text.substr(equals + 1)));
  if (!number) return std::nullopt;
  const SimplifyTarget target{static_cast<Kind>(known - kNames.begin()), *number};
  return is_accepted(target) ? std::optional(target) : std::nullopt;
}

std::string simplify_target_text(const SimplifyTarget& target) {
  const std::string number = target.kind == Kind::kTriangles
                                 ? std::to_string(static_cast<std::uint64_t>(target.value))
                                 : text_of(target.value);
  return std::string(kNames[static_cast<std::size_t>(target.kind)]) + "=" + number;
}

std::uint64_t most_triangles(const SimplifyTarget& target, std::uint64_t triangles) {
  const double most = target.kind == Kind::kRatio
                          ? std::floor(target.value * static_cast<double>(triangles))
                          : target.value;
  return std::max<std::uint64_t>(1, std::min(static_cast<std::uint64_t>(most), triangles));
}

}  // namespace orbweave
