#include "io/clouds/pcd_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

#include "io/clouds/text_layout.h"
#include "io/error.h"
#include "io/points/column_roles.h"
#include "io/text/counted_noun.h"
#include "io/text/lower_case.h"
#include "io/text/text_fields.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

constexpr std::size_t kMostValues = 4096;  // the longest descriptor in use has 1,353
constexpr std::array<std::string_view, 10> kKeys = {
    "VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};

struct HeaderLine {
  std::vector<std::string> values;
  std::string place;
};

class HeaderParser {
 public:
  explicit HeaderParser(ByteReader& reader) : reader_(reader) { read_lines(); }

  PcdHeader header() const {
    PcdHeader header;
    header.version = version();
    header.fields = fields();
    for (const PcdField& field : header.fields) {
      header.row_bytes += field.bytes();
      header.row_values += field.count;
    }
    header.points = points();
    header.viewpoint = viewpoint();
    header.data = data();
    return header;
  }

 private:
  void read_lines() {
    skip_byte_order_mark(reader_);
    std::string_view line;
    while (reader_.next_line(line)) {
      const auto key = take_field(line, ' ');
      if (!key || key->substr(0, 1) == "#") continue;
      // The oldest files say COLUMNS.
      const std::string_view name = *key == "COLUMNS" ? "FIELDS" : *key;
      if (std::find(kKeys.begin(), kKeys.end(), name) == kKeys.end())
        throw_bad_input("this is no line of a PCD header",
                        {.file = reader_.name(),
                         .place = reader_.line_place(),
                         .found = excerpt(*key),
                         .expected = "VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, "
                                     "VIEWPOINT, POINTS or DATA"});
      HeaderLine& entry = lines_[std::string(name)];
      const bool is_second = !entry.place.empty();
      entry.place = reader_.line_place();
      if (is_second) refuse(entry, "the header has two lines " + std::string(name), "");
      while (const auto value = take_field(line, ' ')) entry.values.emplace_back(*value);
      if (entry.values.empty()) refuse(entry, std::string(name) + " has no value", "");
      if (name == "DATA") return;
    }
    throw_bad_input("the PCD header has no end", {.file = reader_.name(),
                                                  .place = reader_.line_place(),
                                                  .found = "the end of the file",
                                                  .expected = "a line DATA"});
  }

  [[noreturn]] void refuse(const HeaderLine& line, const std::string& problem,
                           const std::string& found, const std::string& expected = "") const {
    throw_bad_input(
        problem,
        {.file = reader_.name(), .place = line.place, .found = found, .expected = expected});
  }

  const HeaderLine* find(const std::string& key) const {
    const auto at = lines_.find(key);
    return at == lines_.end() ? nullptr : &at->second;
  }

  std::uint64_t parse_count(const HeaderLine& line, const std::string& text) const {
    std::uint64_t value = 0;
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, value);
    if (error != std::errc{} || end != last)
      refuse(line, "this is no count", excerpt(text), "an integer from 0 to 2^64 - 1");
    return value;
  }

  std::optional<std::uint64_t> single_count(const std::string& key) const {
    const HeaderLine* line = find(key);
    if (line == nullptr) return std::nullopt;
    if (line->values.size() != 1)
      refuse(*line, key + " has several values",
             counted_noun(line->values.size(), "value", "values"), "one");
    return parse_count(*line, line->values[0]);
  }

  /// "0.7"; empty where the header does not say.
  std::string version() const {
    const HeaderLine* line = find("VERSION");
    if (line == nullptr) return "";
    const std::string& text = line->values[0];
    for (const char* known : {"0.5", "0.6", "0.7"})
      if (text == known || text == known + 1) return known;
    refuse(*line, "this version of PCD is unknown", excerpt(line->values[0]), "0.5, 0.6 or 0.7");
  }

  /// A line with one value per field, where the header has it.
  const HeaderLine* per_field(const std::string& key, std::size_t fields) const {
    const HeaderLine* line = find(key);
    if (line != nullptr && line->values.size() != fields)
      refuse(*line, key + " does not match FIELDS",
             counted_noun(line->values.size(), "value", "values"), std::to_string(fields));
    return line;
  }

  std::vector<PcdField> fields() const {
    const HeaderLine* names = find("FIELDS");
    if (names == nullptr)
      throw_bad_input("the PCD header has no line FIELDS", {.file = reader_.name()});
    const std::size_t count = names->values.size();
    const HeaderLine* sizes = per_field("SIZE", count);
    const HeaderLine* types = per_field("TYPE", count);
    const HeaderLine* counts = per_field("COUNT", count);
    std::vector<PcdField> fields;
    std::size_t values = 0;
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < count; ++i) {
      PcdField field{names->values[i]};
      field.type = scalar_type(sizes, types, i);
      if (counts != nullptr) field.count = value_count(*counts, i);
      bytes += field.bytes();
      if (!field.is_padding()) values += field.count;
      if (values > kMostValues || bytes > ByteReader::kBlockBytes)
        refuse(counts != nullptr ? *counts : *names, "a point has too many values",
               "more than " + std::to_string(kMostValues) + " values or " +
                   std::to_string(ByteReader::kBlockBytes) + " bytes");
      fields.push_back(std::move(field));
    }
    return fields;
  }

  std::size_t value_count(const HeaderLine& counts, std::size_t i) const {
    const std::uint64_t count = parse_count(counts, counts.values[i]);
    if (count == 0 || count > ByteReader::kBlockBytes)
      refuse(counts, "a field has no sensible number of values", excerpt(counts.values[i]),
             "1 to " + std::to_string(ByteReader::kBlockBytes));
    return static_cast<std::size_t>(count);
  }

  ScalarType scalar_type(const HeaderLine* sizes, const HeaderLine* types, std::size_t i) const {
    const std::string size = sizes != nullptr ? sizes->values[i] : "4";
    const std::string type = types != nullptr ? types->values[i] : "F";
    constexpr std::array<std::pair<std::string_view, ScalarType>, 10> kTypes = {
        {{"I1", ScalarType::kInt8},
         {"U1", ScalarType::kUint8},
         {"I2", ScalarType::kInt16},
         {"U2", ScalarType::kUint16},
         {"I4", ScalarType::kInt32},
         {"U4", ScalarType::kUint32},
         {"I8", ScalarType::kInt64},
         {"U8", ScalarType::kUint64},
         {"F4", ScalarType::kFloat32},
         {"F8", ScalarType::kFloat64}}};
    for (const auto& [name, scalar] : kTypes)
      if (name == type + size) return scalar;
    refuse(types != nullptr ? *types : *sizes, "a field has an unknown type",
           "TYPE " + excerpt(type) + " of SIZE " + excerpt(size),
           "I or U of 1, 2, 4 or 8 bytes, or F of 4 or 8");
  }

  std::uint64_t points() const {
    const auto points = single_count("POINTS");
    const auto width = single_count("WIDTH");
    const auto height = single_count("HEIGHT");
    if (!points && !width)
      throw_bad_input("the PCD header does not say how many points there are",
                      {.file = reader_.name(), .expected = "a line POINTS"});
    if (!width) return *points;
    const std::uint64_t rows = height.value_or(1);
    const bool overflows = rows != 0 && *width > std::numeric_limits<std::uint64_t>::max() / rows;
    if (overflows || (points && *points != *width * rows))
      refuse(*find(points ? "POINTS" : "WIDTH"), "POINTS is not WIDTH times HEIGHT",
             points ? std::to_string(*points) : "more than 2^64 points",
             std::to_string(*width) + " x " + std::to_string(rows));
    return *width * rows;
  }

  std::optional<Vec3> viewpoint() const {
    constexpr std::array<double, 7> kDefault = {0, 0, 0, 1, 0, 0, 0};
    const HeaderLine* line = find("VIEWPOINT");
    if (line == nullptr) return std::nullopt;
    std::array<double, 7> values{};
    bool is_good = line->values.size() == values.size();
    for (std::size_t i = 0; is_good && i < values.size(); ++i)
      is_good = parse_value(line->values[i], ScalarType::kFloat64,
                            reinterpret_cast<std::byte*>(&values[i])) == ParseOutcome::kNumber &&
                std::isfinite(values[i]);
    if (!is_good)
      refuse(*line, "this is no viewpoint", excerpt(line->values[0]),
             "7 numbers: a translation and a quaternion");
    if (values == kDefault) return std::nullopt;
    return Vec3{values[0], values[1], values[2]};
  }

  PcdData data() const {
    const HeaderLine& line = *find("DATA");
    const std::string& name = line.values[0];
    if (name == "ascii") return PcdData::kAscii;
    if (name == "binary") return PcdData::kBinary;
    if (name == "binary_compressed") return PcdData::kCompressed;
    refuse(line, "this way of storing points is unknown", excerpt(name),
           "ascii, binary or binary_compressed");
  }

  ByteReader& reader_;
  std::map<std::string, HeaderLine> lines_;
};

/// The name that a role goes by; any other name as it stands.
std::string role_name(const std::string& name) {
  constexpr std::array<std::pair<std::string_view, const char*>, 13> kRoles = {
      {{"x", "x"},
       {"y", "y"},
       {"z", "z"},
       {"nx", "nx"},
       {"ny", "ny"},
       {"nz", "nz"},
       {"normal_x", "nx"},
       {"normal_y", "ny"},
       {"normal_z", "nz"},
       {"red", "red"},
       {"green", "green"},
       {"blue", "blue"},
       {"intensity", "intensity"}}};
  const std::string lower = lower_case(name);
  for (const auto& [role, canonical] : kRoles)
    if (lower == role) return canonical;
  return name;
}

void add_packed_color(const PcdField& field, std::size_t offset, std::vector<RowColumn>& columns) {
  // The number 0xAARRGGBB, lowest byte first.
  columns.push_back({"red", ScalarType::kUint8, offset + 2});
  columns.push_back({"green", ScalarType::kUint8, offset + 1});
  columns.push_back({"blue", ScalarType::kUint8, offset});
  if (lower_case(field.name) == "rgba")
    columns.push_back({"alpha", ScalarType::kUint8, offset + 3});
}

void refuse_twice(std::vector<RowColumn> columns, const std::string& file) {
  const auto by_name = [](const RowColumn& a, const RowColumn& b) { return a.name < b.name; };
  std::sort(columns.begin(), columns.end(), by_name);
  const auto twice =
      std::adjacent_find(columns.begin(), columns.end(),
                         [](const RowColumn& a, const RowColumn& b) { return a.name == b.name; });
  if (twice != columns.end())
    throw_bad_input("two fields have one name",
                    {.file = file, .place = "FIELDS", .found = excerpt(twice->name)});
}

}  // namespace

bool PcdField::is_packed_color() const {
  const std::string lower = lower_case(name);
  return (lower == "rgb" || lower == "rgba") && count == 1 && size_of(type) == 4;
}

PcdHeader read_pcd_header(ByteReader& reader) { return HeaderParser(reader).header(); }

std::vector<RowColumn> pcd_columns(const PcdHeader& header, const std::string& file) {
  std::vector<RowColumn> columns;
  std::size_t offset = 0;
  for (const PcdField& field : header.fields) {
    if (field.is_packed_color()) {
      add_packed_color(field, offset, columns);
    } else if (!field.is_padding()) {
      for (std::size_t i = 0; i < field.count; ++i)
        columns.push_back(
            {field.count == 1 ? role_name(field.name) : field.name + "_" + std::to_string(i),
             field.type, offset + i * size_of(field.type)});
    }
    offset += field.bytes();
  }
  name_by_roles(columns);
  refuse_twice(columns, file);
  return columns;
}

}  // namespace orbweave
