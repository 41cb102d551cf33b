#include "io/points/area_text.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "io/byte_order_mark.h"
#include "io/error.h"
#include "io/json_nesting.h"
#include "io/system/file_descriptor.h"
#include "io/system/small_file.h"
#include "io/text/lower_case.h"
#include "io/text/quantity.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;
using Ring = std::vector<AreaPoint>;

/// Beyond that the sign of a determinant may overflow.
constexpr double kLargestCoordinate = 1e75;
constexpr std::size_t kLeastCorners = 3;
/// A value of the tree takes some 64 bytes with what it costs to allocate.
constexpr std::size_t kMostJsonValues = kMostAreaBytes / 8;
constexpr std::size_t kShownBytes = 24;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Corners without one that repeats the first.
std::size_t corners_of(const Ring& ring) {
  return ring.size() > 1 && ring.front() == ring.back() ? ring.size() - 1 : ring.size();
}

bool is_usable(double coordinate) { return std::abs(coordinate) <= kLargestCoordinate; }

/// A text of geometries, from front to back.
class WktReader {
 public:
  WktReader(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  std::vector<AreaPolygon> read() {
    do {
      skip_srid();
      read_geometry();
      while (at_ < text_.size() && (is_blank(text_[at_]) || text_[at_] == ';')) ++at_;
    } while (at_ < text_.size());
    return std::move(polygons_);
  }

 private:
  [[noreturn]] void refuse(const std::string& problem, const std::string& expected) const {
    const std::string_view before = text_.substr(0, at_);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t begin = before.rfind('\n') + 1;  // npos + 1 is 0
    const std::string_view rest = text_.substr(at_, kShownBytes);
    throw_bad_input(problem, {.file = name_,
                              .place = "line " + std::to_string(line) + ", column " +
                                       std::to_string(at_ - begin + 1),
                              .found = rest.empty() ? "the end" : "\"" + std::string(rest) + "\"",
                              .expected = expected});
  }

  void skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  }
  bool take(char c) {
    skip_blanks();
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void need(char c) {
    if (!take(c)) refuse("this is no WKT of polygons", std::string("'") + c + "'");
  }
  std::string word() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_letter(text_[at_])) ++at_;
    return lower_case(std::string(text_.substr(begin, at_ - begin)));
  }

  void skip_srid() {
    const std::size_t begin = at_;
    if (word() != "srid") {
      at_ = begin;
      return;
    }
    at_ = std::min(text_.find(';', at_), text_.size() - 1) + 1;
  }

  void read_geometry() {
    skip_blanks();
    const std::size_t begin = at_;
    const std::string kind = word();
    if (kind != "polygon" && kind != "multipolygon") {
      at_ = begin;
      refuse("this is no WKT of polygons", "POLYGON or MULTIPOLYGON");
    }
    skip_blanks();
    const std::size_t dimensions = at_;
    if (const std::string more = word();
        !more.empty() && more != "z" && more != "m" && more != "zm") {
      at_ = dimensions;
      refuse(more == "empty" ? "an area without polygons holds no points"
                             : "this is no WKT of polygons",
             "'('");
    }
    need('(');
    if (kind == "polygon") return read_polygon();
    do {
      need('(');
      read_polygon();
    } while (take(','));
    need(')');
  }

  /// Behind its bracket.
  void read_polygon() {
    AreaPolygon polygon;
    polygon.outer = read_ring();
    while (take(',')) polygon.holes.push_back(read_ring());
    need(')');
    polygons_.push_back(std::move(polygon));
  }

  Ring read_ring() {
    need('(');
    const std::size_t begin = at_;
    Ring ring;
    do ring.push_back(read_corner());
    while (take(','));
    need(')');
    if (corners_of(ring) >= kLeastCorners) return ring;
    at_ = begin;
    refuse("a ring has too few corners", "at least three corners");
  }

  AreaPoint read_corner() {
    AreaPoint corner{};
    for (double& coordinate : corner)
      if (!take_number(coordinate))
        refuse("this is no corner of a polygon", "two numbers up to 1e75");
    double further = 0.0;
    while (take_number(further)) {
    }
    return corner;
  }

  bool take_number(double& number) {
    skip_blanks();
    const char* const end = parse_number(text_.data() + at_, text_.data() + text_.size(), number);
    if (end == nullptr || !is_usable(number)) return false;
    at_ = static_cast<std::size_t>(end - text_.data());
    return true;
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
  std::vector<AreaPolygon> polygons_;
};

/// A tree of GeoJSON.
class GeoJsonReader {
 public:
  explicit GeoJsonReader(const std::string& name) : name_(name) {}

  std::vector<AreaPolygon> read(const Json& document) {
    read_object(document, "the document", 0);
    if (polygons_.empty())
      refuse("an area without polygons holds no points", "the document", "none", "a Polygon");
    return std::move(polygons_);
  }

 private:
  [[noreturn]] void refuse(const std::string& problem, const std::string& place,
                           const std::string& found, const std::string& expected) const {
    throw_bad_input(problem, {.file = name_, .place = place, .found = found, .expected = expected});
  }

  static std::string shown_json(const Json& value) {
    const std::string text =
        value.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, kShownBytes);
    return value.is_structured() ? value.type_name() : text;
  }

  const Json& member(const Json& object, const char* key, const std::string& place) const {
    static const Json kNothing;
    if (!object.is_object())
      refuse("this is no GeoJSON of polygons", place, shown_json(object), "an object");
    const auto found = object.find(key);
    return found == object.end() ? kNothing : *found;
  }

  const Json& list(const Json& value, const std::string& place) const {
    if (!value.is_array())
      refuse("this is no GeoJSON of polygons", place, shown_json(value), "a list");
    return value;
  }

  /// `depth`: of collections within collections.
  void read_object(const Json& object, const std::string& place, int depth) {
    constexpr int kDeepest = 16;
    const Json& kind = member(object, "type", place);
    const std::string type = kind.is_string() ? kind.get<std::string>() : "";
    const char* const members = type == "FeatureCollection"    ? "features"
                                : type == "GeometryCollection" ? "geometries"
                                                               : nullptr;
    if (members != nullptr && depth < kDeepest) {
      const Json& parts = list(member(object, members, place), std::string(members));
      for (std::size_t i = 0; i < parts.size(); ++i)
        read_object(parts[i], std::string(members) + "[" + std::to_string(i) + "]", depth + 1);
    } else if (type == "Feature" && depth < kDeepest) {
      const auto geometry = object.find("geometry");
      // A row of a table that is nowhere: RFC 7946, section 3.2.
      if (depth > 0 && geometry != object.end() && geometry->is_null()) return;
      read_object(member(object, "geometry", place), "geometry of " + place, depth + 1);
    } else if (type == "Polygon") {
      read_polygon(member(object, "coordinates", place), place);
    } else if (type == "MultiPolygon") {
      const Json& parts = list(member(object, "coordinates", place), place);
      for (std::size_t i = 0; i < parts.size(); ++i)
        read_polygon(parts[i], place + ", polygon " + std::to_string(i + 1));
    } else {
      refuse("this is no GeoJSON of polygons", place, "type " + shown_json(kind),
             "a Polygon or MultiPolygon, a Feature or a collection of them");
    }
  }

  void read_polygon(const Json& rings, const std::string& place) {
    list(rings, place);
    if (rings.empty()) refuse("a polygon has no ring", place, "[]", "a ring");
    AreaPolygon polygon;
    for (std::size_t i = 0; i < rings.size(); ++i) {
      Ring ring = read_ring(rings[i], place + ", ring " + std::to_string(i + 1));
      if (i == 0)
        polygon.outer = std::move(ring);
      else
        polygon.holes.push_back(std::move(ring));
    }
    polygons_.push_back(std::move(polygon));
  }

  Ring read_ring(const Json& corners, const std::string& place) const {
    Ring ring;
    for (const Json& corner : list(corners, place)) {
      const bool is_corner = corner.is_array() && corner.size() >= 2 && corner[0].is_number() &&
                             corner[1].is_number() && is_usable(corner[0].get<double>()) &&
                             is_usable(corner[1].get<double>());
      if (!is_corner)
        refuse("this is no corner of a polygon",
               place + ", corner " + std::to_string(ring.size() + 1), shown_json(corner),
               "a list of two numbers up to 1e75");
      ring.push_back({corner[0].get<double>(), corner[1].get<double>()});
    }
    if (corners_of(ring) < kLeastCorners)
      refuse("a ring has too few corners", place, std::to_string(corners_of(ring)),
             "at least three corners");
    return ring;
  }

  const std::string& name_;
  std::vector<AreaPolygon> polygons_;
};

[[noreturn]] void refuse_long(const std::string& name, const std::string& found) {
  throw_bad_input("the area is too large",
                  {.file = name,
                   .found = found,
                   .expected = "at most " + format_bytes(kMostAreaBytes) + ", " +
                               format_count(kMostAreaCorners) + " corners and " +
                               format_count(kMostJsonValues) + " values of GeoJSON",
                   .advice = "Simplify the polygons, as 'ogr2ogr -simplify' does."});
}

void check_length(std::string_view text, bool is_json, const std::string& name) {
  if (text.size() > kMostAreaBytes) refuse_long(name, "more than " + format_bytes(kMostAreaBytes));
  if (!is_json) return;
  const auto values = std::count_if(text.begin(), text.end(),
                                    [](char c) { return c == ',' || c == '[' || c == '{'; });
  if (static_cast<std::size_t>(values) > kMostJsonValues)
    refuse_long(name, format_count(static_cast<std::uint64_t>(values)) + " values");
}

void check_corners(const std::vector<AreaPolygon>& polygons, const std::string& name) {
  std::size_t corners = 0;
  for (const AreaPolygon& polygon : polygons) {
    corners += polygon.outer.size();
    for (const Ring& hole : polygon.holes) corners += hole.size();
  }
  if (corners > kMostAreaCorners) refuse_long(name, format_count(corners) + " corners");
}

std::vector<AreaPolygon> parse_geojson(std::string_view text, const std::string& name) {
  if (nests_too_deeply(text))
    throw_bad_input("the area is nested too deeply",
                    {.file = name, .expected = expected_json_levels()});
  Json document;
  try {
    document = Json::parse(text);
  } catch (const Json::exception& problem) {
    const auto* const at = dynamic_cast<const Json::parse_error*>(&problem);
    throw_bad_input("this is no JSON",
                    {.file = name,
                     .place = at != nullptr ? "byte " + std::to_string(at->byte) : "",
                     .found = "a text that does not parse",
                     .expected = "GeoJSON"});
  }
  return GeoJsonReader(name).read(document);
}

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  return text;
}

/// The letters in front, as small ones.
std::string first_word(std::string_view text) {
  const auto* const end = std::find_if_not(text.begin(), text.end(), is_letter);
  return lower_case(std::string(text.begin(), end));
}

}  // namespace

bool is_area_text(std::string_view text) {
  text = without_blanks(text);
  const std::size_t end = text.find(';');
  if (first_word(text) == "srid" && end != text.npos) text = without_blanks(text.substr(end + 1));
  const std::string kind = first_word(text);
  if (kind != "polygon" && kind != "multipolygon") return false;
  return kind.size() < text.size() && (text[kind.size()] == '(' || is_blank(text[kind.size()]));
}

std::vector<AreaPolygon> parse_area(std::string_view text, const std::string& name) {
  text = without_byte_order_mark(text);
  const std::size_t first = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  const bool is_json = first < text.size() && text[first] == '{';
  check_length(text, is_json, name);
  std::vector<AreaPolygon> polygons =
      is_json ? parse_geojson(text, name) : WktReader(text, name).read();
  check_corners(polygons, name);
  return polygons;
}

std::vector<AreaPolygon> read_area(const std::filesystem::path& path) {
  const std::optional<std::string> text = small_file_text(path, kMostAreaBytes + 1);
  if (!text)
    throw_unread("cannot open the file of the area",
                 {.file = path.string(),
                  .expected = "a WKT or GeoJSON file, or POLYGON or MULTIPOLYGON as text"},
                 errno);
  return parse_area(*text, path.string());
}

}  // namespace orbweave
