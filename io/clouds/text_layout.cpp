#include "io/clouds/text_layout.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/streams/byte_reader.h"
#include "io/text/column_name.h"
#include "io/text/counted_noun.h"
#include "io/text/lower_case.h"
#include "io/text/text_fields.h"
#include "io/text/text_number.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

/// As in the headers of other formats: what a line of numbers without ends would have is no point.
constexpr std::size_t kMostColumns = 4096;

bool names_position(const std::vector<TextColumn>& columns) {
  for (const char* name : {"x", "y", "z"})
    if (std::none_of(columns.begin(), columns.end(),
                     [&](const TextColumn& column) { return column.name == name; }))
      return false;
  return true;
}

std::string place_name(std::size_t column) {
  return std::string("c").append(std::to_string(column + 1));
}

/// What surveyors and ParaView call columns, the likeliest name first.
struct OtherNames {
  const char* canonical;
  std::array<std::string_view, 4> others;
};
constexpr std::array<OtherNames, 9> kOtherNames = {
    {{"x", {"easting", "east", "points:0", "points_0"}},
     {"y", {"northing", "north", "points:1", "points_1"}},
     {"z", {"elevation", "height", "points:2", "points_2"}},
     {"nx", {"normals:0", "normals_0", "normals:x", "normals_x"}},
     {"ny", {"normals:1", "normals_1", "normals:y", "normals_y"}},
     {"nz", {"normals:2", "normals_2", "normals:z", "normals_z"}},
     {"red", {"rgb:0", "rgb_0", "colors:0", "colors_0"}},
     {"green", {"rgb:1", "rgb_1", "colors:1", "colors_1"}},
     {"blue", {"rgb:2", "rgb_2", "colors:2", "colors_2"}}}};

/// Renames the columns of a table that has no x, y or z by the names above; where one of the three
/// is still missing, the columns stay as they are.
void take_other_names(std::vector<TextColumn>& columns) {
  std::vector<TextColumn> renamed = columns;
  for (const OtherNames& names : kOtherNames) {
    if (std::ranges::find(renamed, names.canonical, &TextColumn::name) != renamed.end()) continue;
    for (const std::string_view other : names.others) {
      const auto at = std::ranges::find_if(renamed, [&](const TextColumn& column) {
        return lower_case(std::string(without_unit(column.name))) == other;
      });
      if (at == renamed.end()) continue;
      at->name = names.canonical;
      break;
    }
  }
  if (names_position(renamed)) columns = std::move(renamed);
}

std::vector<TextColumn> named_columns(const std::vector<std::string_view>& names) {
  std::vector<TextColumn> columns;
  for (const std::string_view name : names)
    columns.push_back({name.empty() ? place_name(columns.size()) : canonical_column_name(name)});
  if (!names_position(columns)) take_other_names(columns);
  return columns;
}

const std::string* find_twice(const std::vector<TextColumn>& columns) {
  for (std::size_t i = 0; i < columns.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!columns[i].name.empty() && columns[i].name == columns[j].name) return &columns[i].name;
  return nullptr;
}

/// "name", "name:type" or "-", maybe with blanks around it, as in "x, y, z".
TextColumn parse_column(const std::string& written) {
  const std::string text(trimmed(written));
  if (text == "-") return {};
  const std::size_t colon = text.find(':');
  TextColumn column{canonical_column_name(text.substr(0, colon))};
  if (column.name.empty()) throw_usage("a column has no name", {.found = excerpt(written)});
  if (colon == text.npos) return column;
  const std::string type = text.substr(colon + 1);
  for (int i = 0; i <= static_cast<int>(ScalarType::kFloat64); ++i) {
    column.type = static_cast<ScalarType>(i);
    if (type == name_of(column.type)) return column;
  }
  throw_usage("a column has an unknown type",
              {.found = excerpt(text), .expected = "int8, uint8, ... float32 or float64"});
}

/// The sample's values, column by column, to guess meanings from.
class SampleValues {
 public:
  SampleValues(const TextSample& sample, std::size_t first, char separator) {
    for (std::size_t i = first; i < sample.lines.size(); ++i)
      rows_.push_back(fields_of(sample.lines[i], separator));
  }
  bool empty() const { return rows_.empty(); }

  /// Integers from 0 to 255 without decimal point.
  bool is_byte(std::size_t column) const {
    return std::all_of(rows_.begin(), rows_.end(), [&](const auto& row) {
      std::array<std::byte, 1> value;
      return column < row.size() && row[column].find('.') == std::string_view::npos &&
             parse_value(row[column], ScalarType::kUint8, value.data()) == ParseOutcome::kNumber;
    });
  }
  /// The same written with a decimal point, as 128.000 or 1.28e+02; 0.0 and 1.0 alone may as well
  /// be fractions or marks.
  bool is_decimal_byte(std::size_t column) const {
    constexpr double kMost = 255.0;
    const std::optional<double> largest = largest_whole(column);
    return largest && *largest > 1.0 && *largest <= kMost && has_decimals(column);
  }
  /// How many columns in a row hold bytes in one notation.
  std::size_t bytes_from(std::size_t column) const {
    std::size_t end = column;
    while (is_byte(end)) ++end;
    if (end == column)
      while (is_decimal_byte(end)) ++end;
    return end - column;
  }
  /// The largest of whole numbers from 0 on, be they written as 128, 128.000 or 1.28e2; nothing
  /// where one is something else.
  std::optional<double> largest_whole(std::size_t column) const {
    double largest = 0.0;
    for (const auto& row : rows_) {
      double value = 0.0;
      const bool is_whole = column < row.size() && to_number(row[column], value) && value >= 0.0 &&
                            value == std::floor(value);
      if (!is_whole) return std::nullopt;
      largest = std::max(largest, value);
    }
    return largest;
  }
  /// Whole numbers from 0 to 99,999, the size of the largest grids.
  bool is_grid_index(std::size_t column) const {
    constexpr std::size_t kMostDigits = 5;
    return std::all_of(rows_.begin(), rows_.end(), [&](const auto& row) {
      return column < row.size() && !row[column].empty() && row[column].size() <= kMostDigits &&
             row[column].find_first_not_of("0123456789") == std::string_view::npos;
    });
  }
  bool has_decimals(std::size_t column) const {
    return std::all_of(rows_.begin(), rows_.end(), [&](const auto& row) {
      return column < row.size() && row[column].find('.') != std::string_view::npos;
    });
  }
  /// Three columns whose vectors have length one (zero vectors, for "no normal", apart).
  bool are_unit_vectors(std::size_t column) const {
    constexpr double kTolerance = 0.02;  // of the length: normals are often given with few digits
    std::size_t units = 0;
    for (const auto& row : rows_) {
      Vec3 v;
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t at = column + static_cast<std::size_t>(axis);
        if (at >= row.size() || !to_number(row[at], v[axis])) return false;
      }
      if (v == Vec3{} || !is_finite(v)) continue;
      if (std::fabs(norm(v) - 1.0) > kTolerance) return false;
      ++units;
    }
    return units != 0;
  }

 private:
  std::vector<std::vector<std::string_view>> rows_;
};

void add_three(std::vector<TextColumn>& columns, const std::array<const char*, 3>& names,
               ScalarType type) {
  for (const char* name : names) columns.push_back({name, type});
}

constexpr std::array<const char*, 3> kNormal = {"nx", "ny", "nz"};
constexpr std::array<const char*, 3> kColor = {"red", "green", "blue"};

/// Named colours have 8 or 16 bits where they are whole numbers of so many; colours from 0 to 1
/// stay as they are, and so does a column "r" or "a" that has no colours beside it.
void narrow_colors(const TextSample& sample, TextLayout& layout) {
  constexpr double kMost8 = 255.0, kMost16 = 65535.0;
  const SampleValues values(sample, layout.has_header_line ? 1 : 0, layout.separator);
  const auto is_there = [&](const char* name) {
    return std::any_of(layout.columns.begin(), layout.columns.end(),
                       [&](const TextColumn& column) { return column.name == name; });
  };
  if (values.empty() || !std::all_of(kColor.begin(), kColor.end(), is_there)) return;
  std::vector<std::size_t> colors;
  for (std::size_t i = 0; i < layout.columns.size(); ++i)
    for (const char* name : {"red", "green", "blue", "alpha"})
      if (layout.columns[i].name == name) colors.push_back(i);
  double largest = 0.0;
  for (const std::size_t i : colors) {
    const std::optional<double> of_column = values.largest_whole(i);
    if (!of_column) return;
    largest = std::max(largest, *of_column);
  }
  // 0.0 and 1.0 may be fractions, 0 and 1 are none.
  const bool may_be_fractions = largest <= 1.0 && !std::ranges::all_of(colors, [&](std::size_t i) {
                                  return values.is_byte(i);
                                });
  if (may_be_fractions || largest > kMost16) return;
  for (const std::size_t i : colors)
    layout.columns[i].type = largest <= kMost8 ? ScalarType::kUint8 : ScalarType::kUint16;
}

void guess_columns(const TextSample& sample, TextLayout& layout) {
  const std::size_t count = fields_of(sample.lines[0], layout.separator).size();
  const SampleValues values(sample, 0, layout.separator);
  bool has_normal = false, has_color = false;
  layout.may_begin_with_grid = values.is_grid_index(0) && values.is_grid_index(1) &&
                               values.has_decimals(2) && values.has_decimals(3) &&
                               values.has_decimals(4);
  std::vector<TextColumn>& columns = layout.columns;
  add_three(columns, {"x", "y", "z"}, ScalarType::kFloat64);
  const bool has_normal_behind_colors = count == 10 && values.are_unit_vectors(7);
  if (sample.kind == TextKind::kPts && (count == 4 || count == 7 || has_normal_behind_colors))
    columns.push_back({"intensity", ScalarType::kFloat32});
  if (sample.kind == TextKind::kNormals && count >= 6) {
    add_three(columns, kNormal, ScalarType::kFloat64);
    has_normal = true;
  }
  if (sample.kind == TextKind::kColors && count >= 6) {
    add_three(columns, kColor, ScalarType::kFloat64);
    narrow_colors(sample, layout);
    has_color = true;
  }
  while (columns.size() < count) {
    const std::size_t at = columns.size();
    const bool three_left = at + 3 <= count;
    if (three_left && !has_normal && values.are_unit_vectors(at)) {
      add_three(columns, kNormal, ScalarType::kFloat64);
      has_normal = true;
    } else if (!has_color && layout.color_candidates == 0 &&
               values.bytes_from(at) >= kColor.size()) {
      layout.first_color = at;
      layout.color_candidates = values.bytes_from(at);
      add_three(columns, kColor, ScalarType::kUint8);
    } else {
      columns.push_back({place_name(at)});
    }
  }
}

/// Position of the first field that is no number; the field count where all are.
std::size_t first_word(const std::vector<std::string_view>& fields) {
  double ignored = 0.0;
  const auto at = std::find_if(fields.begin(), fields.end(),
                               [&](std::string_view field) { return !to_number(field, ignored); });
  return static_cast<std::size_t>(at - fields.begin());
}

std::vector<TextColumn> chosen_columns(const TextOptions& options) {
  std::vector<TextColumn> columns;
  for (const std::string& text : options.columns) columns.push_back(parse_column(text));
  if (!names_position(columns))
    throw_usage("the columns of a text cloud must name x, y and z",
                {.found = excerpt(joined(options.columns))});
  if (const std::string* name = find_twice(columns))
    throw_usage("two columns of a text cloud have one name", {.found = excerpt(*name)});
  return columns;
}

bool only_words(const std::vector<std::string_view>& fields) {
  double ignored = 0.0;
  return std::none_of(fields.begin(), fields.end(),
                      [&](std::string_view field) { return to_number(field, ignored); });
}

/// Whether the field is a whole number of this type that no double is.
template <class Integer>
bool is_rounded(std::string_view field) {
  Integer whole = 0;
  const char* const last = field.data() + field.size();
  const auto [end, error] = std::from_chars(field.data(), last, whole);
  // The largest number of the type is no double; the power of two above it is.
  constexpr Integer kHalf = std::numeric_limits<Integer>::max() / 2 + 1;
  constexpr double kEnd = 2.0 * static_cast<double>(kHalf);
  const auto nearest = static_cast<double>(whole);
  return error == std::errc{} && end == last &&
         (nearest >= kEnd || static_cast<Integer>(nearest) != whole);
}

/// The narrowest type in which a field that a double rounds is whole; a double where none rounds.
ScalarType exact_type(std::string_view field) {
  if (is_rounded<std::int64_t>(field)) return ScalarType::kInt64;
  return is_rounded<std::uint64_t>(field) ? ScalarType::kUint64 : ScalarType::kFloat64;
}

std::string line_place(const TextSample& sample) {
  return "line " + std::to_string(sample.first_line);
}

/// Whether a line is numbers with decimal commas between commas, 1,5, 2,5, 3,5: every other comma
/// has a blank behind it, and the others have none.
bool has_commas_for_both(std::string_view line) {
  constexpr std::size_t kFewest = 5;  // of three such numbers
  std::size_t commas = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    if (line[i] != ',') continue;
    const bool ends_number = line[i + 1] == ' ' || line[i + 1] == '\t';
    if (ends_number != (commas % 2 == 1)) return false;
    ++commas;
  }
  return commas >= kFewest && commas % 2 == 1;
}

/// Whether three digits stand between a mark within a number and its decimal point, as in 1,234.5
/// and 1'234.5, or an apostrophe in a number without one.
bool sets_off_thousands(std::string_view text) {
  constexpr std::size_t kGroup = 3;
  if (text.find('\'') != text.npos) return true;
  for (std::size_t i = text.find(','); i != text.npos; i = text.find(',', i + 1)) {
    const std::size_t end = std::min(text.find_first_not_of("0123456789", i + 1), text.size());
    if (end == i + 1 + kGroup && end < text.size() && text[end] == '.') return true;
  }
  return false;
}

void refuse_commas_for_both(const TextSample& sample) {
  if (!std::ranges::all_of(sample.lines, has_commas_for_both)) return;
  throw_bad_input("commas stand within numbers and between numbers",
                  {.file = sample.file,
                   .place = line_place(sample),
                   .found = excerpt(sample.lines[0]),
                   .expected = "numbers with a decimal point",
                   .advice = kPointsForCommas});
}

std::vector<TextColumn> header_columns(const TextSample& sample,
                                       const std::vector<std::string_view>& fields) {
  std::vector<TextColumn> columns = named_columns(fields);
  if (!names_position(columns)) {
    const std::size_t at = first_word(fields);
    std::string advice = number_advice(sample.lines[0]);
    if (advice.empty() && only_words(fields)) advice = "Name them with input.columns (--columns)";
    throw_bad_input("this is neither a point nor a header",
                    {.file = sample.file,
                     .place = line_place(sample) + ", column " + std::to_string(at + 1),
                     .found = excerpt(fields[at]),
                     .expected = "a number, or names of columns with x, y and z",
                     .advice = std::move(advice)});
  }
  if (const std::string* name = find_twice(columns))
    throw_bad_input("two columns have one name",
                    {.file = sample.file, .place = line_place(sample), .found = excerpt(*name)});
  return columns;
}

}  // namespace

const char* number_advice(std::string_view text) {
  const std::size_t mark = text.find_first_of(",'");
  const bool has_mark_within = mark != text.npos && mark > 0 && mark + 1 < text.size();
  if (!has_mark_within || text.find_first_not_of("0123456789+-.,'\"; \t\r") != text.npos) return "";
  return sets_off_thousands(text) ? "Write numbers without marks between thousands, such as 1234.5"
                                  : kPointsForCommas;
}

TextLayout find_text_layout(const TextSample& sample, const TextOptions& options) {
  TextLayout layout;
  const std::string_view first = sample.lines[0];
  layout.separator = options.separator != '\0' ? options.separator : find_separator(first);
  if (options.separator == '\0' && options.columns.empty()) refuse_commas_for_both(sample);
  const auto fields = fields_of(first, layout.separator);
  if (fields.size() > kMostColumns)
    throw_bad_input(
        "too many columns for a point",
        {.file = sample.file,
         .place = line_place(sample),
         .found = counted_noun(fields.size(), "column", "columns"),
         .expected = "at most " + std::to_string(kMostColumns),
         .advice = "A line holds one point; name the separator where it is another one"});
  if (!options.columns.empty()) {
    layout.columns = chosen_columns(options);
    layout.has_header_line = only_words(fields);
    return layout;
  }
  if (first_word(fields) != fields.size()) {
    layout.columns = header_columns(sample, fields);
    layout.has_header_line = true;
    narrow_colors(sample, layout);
    return layout;
  }
  // Names in a comment may have a separator of their own: # x, y, z before numbers with blanks.
  for (const char separator : {layout.separator, find_separator(sample.comment)}) {
    const auto hinted = named_columns(fields_of(sample.comment, separator));
    if (hinted.size() != fields.size() || !names_position(hinted) || find_twice(hinted) != nullptr)
      continue;
    layout.columns = hinted;
    narrow_colors(sample, layout);
    return layout;
  }
  if (fields.size() < 3)
    throw_bad_input("too few columns for a point",
                    {.file = sample.file,
                     .place = line_place(sample),
                     .found = counted_noun(fields.size(), "column", "columns"),
                     .expected = "at least 3"});
  guess_columns(sample, layout);
  return layout;
}

std::vector<TextColumn> rounded_columns(const TextSample& sample, const TextLayout& layout) {
  std::vector<ScalarType> exact(layout.columns.size(), ScalarType::kFloat64);
  for (const std::string& line : sample.lines) {
    const auto fields = fields_of(line, layout.separator);
    for (std::size_t i = 0; i < std::min(fields.size(), exact.size()); ++i) {
      const ScalarType of_field = exact_type(fields[i]);
      const bool is_rounded = of_field != ScalarType::kFloat64;
      if (is_rounded && exact[i] != ScalarType::kUint64) exact[i] = of_field;
    }
  }
  std::vector<TextColumn> rounded;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const TextColumn& column = layout.columns[i];
    const bool is_double = column.type == ScalarType::kFloat64 && !column.name.empty();
    if (is_double && exact[i] != ScalarType::kFloat64) rounded.push_back({column.name, exact[i]});
  }
  return rounded;
}

}  // namespace orbweave
