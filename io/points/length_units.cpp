#include "io/points/length_units.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <utility>
#include <vector>

namespace orbweave {
namespace {

/// KEYWORD["name",number,CHILD[...],...]
struct WktNode {
  std::string_view keyword;
  std::optional<double> number;  ///< the first one
  std::vector<WktNode> children;
};

/// Well-formed WKT only; every node is read once.
class WktParser {
 public:
  explicit WktParser(std::string_view text) : text_(text) {}

  std::optional<WktNode> node(int depth = 0) {
    constexpr int kMostDepth = 32;
    WktNode node;
    node.keyword = word();
    if (node.keyword.empty() || depth == kMostDepth || !accept("[(")) return std::nullopt;
    while (!accept("])")) {
      if (!argument(node, depth)) return std::nullopt;
      accept(",");
    }
    return node;
  }

 private:
  static bool is_blank(char c) { return static_cast<unsigned char>(c) <= ' '; }
  static bool begins_word(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
  }
  static bool is_of_word(char c) { return begins_word(c) || (c >= '0' && c <= '9'); }

  void skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  }

  bool accept(std::string_view any_of) {
    skip_blanks();
    const bool found = at_ < text_.size() && any_of.find(text_[at_]) != std::string_view::npos;
    at_ += found ? 1 : 0;
    return found;
  }

  std::string_view word() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_of_word(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  /// A doubled quote inside a text ends one text and begins another, which does no harm here.
  bool quoted_text() {
    if (!accept("\"")) return false;
    at_ = text_.find('"', at_);
    if (at_ == std::string_view::npos) at_ = text_.size();
    return accept("\"");
  }

  bool argument(WktNode& node, int depth) {
    skip_blanks();
    if (at_ == text_.size()) return false;
    if (text_[at_] == '"') return quoted_text();
    if (begins_word(text_[at_])) return word_or_child(node, depth);
    double number = 0.0;
    const char* const begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), number);
    if (error != std::errc()) return false;
    at_ += static_cast<std::size_t>(end - begin);
    if (!node.number) node.number = number;
    return true;
  }

  bool word_or_child(WktNode& node, int depth) {
    const std::size_t begin = at_;
    word();
    skip_blanks();
    const bool is_child = at_ < text_.size() && (text_[at_] == '[' || text_[at_] == '(');
    if (!is_child) return true;  // a direction such as NORTH
    at_ = begin;
    std::optional<WktNode> child = this->node(depth + 1);
    if (child) node.children.push_back(std::move(*child));
    return child.has_value();
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

bool is_one_of(std::string_view keyword, std::initializer_list<std::string_view> names) {
  return std::ranges::any_of(names, [&](std::string_view name) {
    return std::ranges::equal(keyword, name, [](char a, char b) {
      return (a >= 'a' && a <= 'z' ? static_cast<char>(a - 'a' + 'A') : a) == b;
    });
  });
}

std::optional<double> own_unit(const WktNode& node) {
  for (const WktNode& child : node.children)
    if (is_one_of(child.keyword, {"UNIT", "LENGTHUNIT"}) && child.number &&
        std::isfinite(*child.number) && *child.number > 0.0)
      return child.number;
  return std::nullopt;
}

/// WKT 2 may name the unit of each axis instead.
std::optional<double> unit_of(const WktNode& system) {
  if (const std::optional<double> unit = own_unit(system)) return unit;
  for (const WktNode& child : system.children)
    if (is_one_of(child.keyword, {"AXIS"}))
      if (const std::optional<double> unit = own_unit(child)) return unit;
  return std::nullopt;
}

/// The unit of the first system of these kinds, looked for in what may hold other systems.
std::optional<double> unit_in(const WktNode& node, std::initializer_list<std::string_view> kinds) {
  if (is_one_of(node.keyword, kinds)) return unit_of(node);
  if (!is_one_of(node.keyword, {"COMPD_CS", "COMPOUNDCRS", "BOUNDCRS", "SOURCECRS"}))
    return std::nullopt;
  for (const WktNode& child : node.children)
    if (const std::optional<double> unit = unit_in(child, kinds)) return unit;
  return std::nullopt;
}

}  // namespace

std::optional<Vec3> meters_per_unit(std::string_view wkt) {
  const std::optional<WktNode> root = WktParser(wkt).node();
  if (!root) return std::nullopt;
  const std::optional<double> level =
      unit_in(*root, {"PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"});
  if (!level) return std::nullopt;
  const double height = unit_in(*root, {"VERT_CS", "VERTCRS", "VERTICALCRS"}).value_or(*level);
  return Vec3{*level, *level, height};
}

std::optional<double> meters_per_epsg_unit(std::uint16_t code) {
  constexpr std::array<std::pair<std::uint16_t, double>, 4> kUnits = {
      {{9001, 1.0}, {9002, 0.3048}, {9003, 12.0 / 39.37}, {9036, 1000.0}}};
  for (const auto& [known, meters] : kUnits)
    if (known == code) return meters;
  return std::nullopt;
}

std::optional<Vec3> meters_per_unit(std::optional<double> units_per_meter,
                                    std::optional<Vec3> of_scan) {
  if (!units_per_meter) return of_scan;
  return Vec3{1.0, 1.0, 1.0} * (1.0 / *units_per_meter);
}

}  // namespace orbweave
