#include "io/clouds/text_source.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "io/clouds/text_layout.h"
#include "io/error.h"
#include "io/points/point_rows.h"
#include "io/text/counted_noun.h"
#include "io/text/text_fields.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

constexpr std::size_t kSampleLines = 100;
constexpr std::size_t kRowsPerBlock = 2048;

inline const char* skip_blanks(const char* at, const char* last) {
  while (at != last && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
  return at;
}

bool is_color(const TextColumn& column) {
  return column.name == "red" || column.name == "green" || column.name == "blue";
}

/// A fraction of 255, rounded.
ParseOutcome parse_color_fraction(std::string_view token, std::byte* out) {
  double value = 0.0;
  if (!to_number(token, value)) return ParseOutcome::kNoNumber;
  if (!(value >= 0.0 && value <= 1.0)) return ParseOutcome::kOutOfRange;
  constexpr double kMost = 255.0;
  *out = std::byte{static_cast<std::uint8_t>(std::lround(value * kMost))};
  return ParseOutcome::kNumber;
}

class TextSource final : public PointSource {
 public:
  TextSource(ByteReader reader, const TextOptions& options, TextKind kind)
      : reader_(std::move(reader)), kind_(kind), columns_are_named_(!options.columns.empty()) {
    const TextSample sample = take_sample();
    layout_ = find_text_layout(sample, options);
    rounded_ = rounded_columns(sample, layout_);
    if (kind_ == TextKind::kColors && !columns_are_named_) take_color_fractions(sample);
    if (layout_.has_header_line) pending_.erase(pending_.begin());
    make_rows_layout();
  }

  const PointSchema& schema() const override { return rows_layout_.schema(); }
  std::optional<std::uint64_t> declared_points() const override { return declared_; }
  bool keeps_declared_points() const override { return false; }
  FileFacts facts() const override {
    FileFacts facts;
    facts.format = is_pts() ? "PTS" : "text";
    for (const TextColumn& column : rounded_)
      facts.lost_values.push_back("the last digits of column " + column.name +
                                  ", which a double rounds (named " + column.name + ":" +
                                  name_of(column.type) +
                                  " in input.columns, --columns, it keeps "
                                  "them)");
    if (layout_.color_candidates > 3) facts.lost_values.push_back(colors_in_doubt());
    if (layout_.may_begin_with_grid) facts.lost_values.push_back(place_in_doubt());
    return facts;
  }
  std::uint64_t bytes_read() const override { return reader_.source().bytes_read(); }
  std::uint64_t bytes_total() const override { return reader_.source().bytes_total(); }

  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.clear();
    batch.schema = schema();
    while (batch.size() < capacity) {
      const std::size_t count = read_rows(std::min(kRowsPerBlock, capacity - batch.size()));
      if (count == 0) break;
      rows_layout_.append(rows_.data(), count, batch);
    }
    if (batch.empty() && capacity != 0) check_count(reader_.line_number());
    return !batch.empty();
  }

 private:
  struct Line {
    std::string text;
    std::uint64_t number = 0;
  };

  bool is_pts() const { return kind_ == TextKind::kPts; }

  /// The next line that is neither blank nor a comment.
  bool next_line(std::string_view& line) {
    while (reader_.next_line(line)) {
      const std::size_t begin = line.find_first_not_of(" \t\r");
      if (begin == line.npos) continue;
      const std::string_view front = line.substr(begin);
      const bool has_mark = front[0] == '#' || front[0] == '%';
      if (!has_mark && front.substr(0, 2) != "//") return true;
      if (pending_.empty()) comment_ = front.substr(has_mark ? 1 : 2);
    }
    return false;
  }

  /// Reads the first lines, to be looked at now and parsed later.
  TextSample take_sample() {
    skip_byte_order_mark(reader_);
    TextSample sample;
    std::string_view line;
    while (pending_.size() < kSampleLines && next_line(line)) {
      const std::optional<std::uint64_t> count = parse_count(line);
      if (count && pending_.empty()) {
        begin_scan(*count, reader_.line_number());
        declared_ = *count;
        continue;
      }
      pending_.push_back({std::string(line), reader_.line_number()});
      if (!count) sample.lines.emplace_back(line);
    }
    if (sample.lines.empty())
      throw_bad_input("the file holds no points",
                      {.file = reader_.name(), .expected = "lines of numbers"});
    sample.comment = comment_;
    sample.file = reader_.name();
    sample.first_line = pending_.front().number;
    sample.kind = kind_;
    return sample;
  }

  /// Colours of .xyzrgb from 0 to 1, as Open3D writes them, are 8-bit colours.
  void take_color_fractions(const TextSample& sample) {
    std::vector<std::size_t> colors;
    for (std::size_t i = 0; i < layout_.columns.size(); ++i)
      if (is_color(layout_.columns[i]) && layout_.columns[i].type == ScalarType::kFloat64)
        colors.push_back(i);
    const auto has_fractions = [&](const std::string& line) {
      const auto fields = fields_of(line, layout_.separator);
      return std::ranges::all_of(colors, [&](std::size_t i) {
        std::byte ignored{};
        return i < fields.size() &&
               parse_color_fraction(fields[i], &ignored) == ParseOutcome::kNumber;
      });
    };
    const auto points = std::span(sample.lines).subspan(layout_.has_header_line ? 1 : 0);
    has_color_fractions_ = colors.size() == 3 && std::ranges::all_of(points, has_fractions);
    if (!has_color_fractions_) return;
    for (const std::size_t i : colors) layout_.columns[i].type = ScalarType::kUint8;
  }

  /// The number of points of the scan that follows, where a line is that: any of a .pts file, and
  /// the first of other files.
  std::optional<std::uint64_t> parse_count(std::string_view line) const {
    if (!is_pts() && (!pending_.empty() || scan_ != 0)) return std::nullopt;
    const char* const last = line.data() + line.size();
    std::uint64_t count = 0;
    const auto [end, error] = std::from_chars(skip_blanks(line.data(), last), last, count);
    if (error != std::errc{} || skip_blanks(end, last) != last) return std::nullopt;
    return count;
  }

  void begin_scan(std::uint64_t count, std::uint64_t line_number) {
    check_count(line_number);
    ++scan_;
    scan_count_ = count;
    scan_points_ = 0;
  }

  void make_rows_layout() {
    std::vector<RowColumn> columns;
    for (const TextColumn& column : layout_.columns) {
      if (column.name.empty()) continue;
      columns.push_back({column.name, column.type, row_bytes_});
      row_bytes_ += size_of(column.type);
    }
    rows_layout_ = PointRowLayout(columns, row_bytes_, false);
    // Where tabs separate, an empty field must not pass for a blank.
    plain_numbers_ = layout_.separator != '\t';
  }

  std::size_t read_rows(std::size_t limit) {
    rows_.resize(kRowsPerBlock * row_bytes_);
    std::byte* out = rows_.data();
    std::size_t count = 0;
    const auto take = [&](std::string_view text, std::uint64_t number) {
      if (const auto points = parse_count(text)) return begin_scan(*points, number);
      out = parse_row(text, number, out);
      ++count;
      ++scan_points_;
    };
    for (; count < limit && next_pending_ < pending_.size(); ++next_pending_)
      take(pending_[next_pending_].text, pending_[next_pending_].number);
    std::string_view line;
    while (count < limit && next_line(line)) take(line, reader_.line_number());
    return count;
  }

  /// Parses a line into a packed row; returns the end of the row.
  std::byte* parse_row(std::string_view line, std::uint64_t number, std::byte* out) const {
    const char* at = line.data();
    const char* const last = at + line.size();
    for (std::size_t i = 0; i < layout_.columns.size(); ++i) {
      const TextColumn& column = layout_.columns[i];
      const char* next = nullptr;
      if (plain_numbers_ && !column.name.empty()) {
        if (column.type == ScalarType::kFloat64) next = parse_plain_number<double>(at, last, out);
        if (column.type == ScalarType::kFloat32) next = parse_plain_number<float>(at, last, out);
      }
      if (next == nullptr) next = parse_field(at, last, i, line, number, out);
      at = next;
      if (!column.name.empty()) out += size_of(column.type);
    }
    if (skip_blanks(at, last) != last) refuse_row(line, number);
    return out;
  }

  /// The common case, fast: a number and the separator behind it. nullptr for anything else.
  template <class T>
  const char* parse_plain_number(const char* at, const char* last, std::byte* out) const {
    T value{};
    const char* end = parse_number(skip_blanks(at, last), last, value);
    if (end == nullptr) return nullptr;
    const char* const behind = skip_blanks(end, last);
    const bool ends = behind == last;
    if (!ends && (layout_.separator == ' ' ? behind == end : *behind != layout_.separator))
      return nullptr;
    std::memcpy(out, &value, sizeof value);
    return ends || layout_.separator == ' ' ? behind : behind + 1;
  }

  const char* parse_field(const char* at, const char* last, std::size_t index,
                          std::string_view line, std::uint64_t number, std::byte* out) const {
    std::string_view rest(at, static_cast<std::size_t>(last - at));
    auto field = take_field(rest, layout_.separator);
    // A separator at the end of the line has an empty field behind it, where one is expected.
    const bool is_behind_separator =
        layout_.separator != ' ' && at != line.data() && at[-1] == layout_.separator;
    if (!field && is_behind_separator && index + 1 == layout_.columns.size()) {
      field = rest.substr(rest.size());
      rest = *field;
    }
    if (!field) refuse_row(line, number);
    const TextColumn& column = layout_.columns[index];
    if (!column.name.empty()) {
      const ParseOutcome outcome = has_color_fractions_ && is_color(column)
                                       ? parse_color_fraction(*field, out)
                                       : parse_value(*field, column.type, out);
      if (outcome != ParseOutcome::kNumber) refuse_value(*field, column, index, number, outcome);
    }
    return rest.data();
  }

  [[noreturn]] void refuse_value(std::string_view field, const TextColumn& column,
                                 std::size_t index, std::uint64_t number,
                                 ParseOutcome outcome) const {
    std::string advice;
    const bool is_fraction = has_color_fractions_ && is_color(column);
    if (column.type == ScalarType::kUint8 || column.type == ScalarType::kUint16)
      advice = "Name the columns, with types, if " + column.name + " is no value from 0 to " +
               (is_fraction                         ? "1"
                : column.type == ScalarType::kUint8 ? "255"
                                                    : "65535") +
               ": input.columns (--columns)";
    if (*number_advice(field) != '\0') advice = number_advice(field);
    const bool is_place = column.name == "x" || column.name == "y" || column.name == "z";
    if (outcome == ParseOutcome::kNoNumber && !is_place && advice.empty())
      advice = "Leave a column of words out: - in place of " + column.name +
               " in input.columns (--columns)";
    if (field.empty())
      advice = "Write nan where a value is missing, or leave the column out: - in place of " +
               column.name + " in input.columns (--columns)";
    throw_bad_input(
        outcome == ParseOutcome::kNoNumber ? "this is no number" : "the number is out of range",
        {.file = reader_.name(),
         .place = "line " + std::to_string(number) + ", column " + std::to_string(index + 1),
         .found = excerpt(field),
         .expected = is_fraction ? "a number from 0 to 1" : expected_value(column.type),
         .advice = std::move(advice)});
  }

  [[noreturn]] void refuse_row(std::string_view line, std::uint64_t number) const {
    std::size_t found = 0;
    while (take_field(line, layout_.separator)) ++found;
    throw_bad_input(columns_are_named_ ? "the line has another number of columns than are named"
                                       : "the line has another number of columns than the first",
                    {.file = reader_.name(),
                     .place = "line " + std::to_string(number),
                     .found = counted_noun(found, "column", "columns"),
                     .expected = std::to_string(layout_.columns.size())});
  }

  /// The counts in a .pts file, one before each scan, are kept by hand too often to refuse a scan
  /// that has more points; one that has fewer has lost some.
  void check_count(std::uint64_t line_number) const {
    if (scan_points_ >= scan_count_) return;
    throw_bad_input(scan_ == 1 ? "the file has fewer points than its first line says"
                               : "scan " + std::to_string(scan_) +
                                     " of the file has fewer points than the line before it says",
                    {.file = reader_.name(),
                     .place = "line " + std::to_string(line_number),
                     .found = counted_points(scan_points_),
                     .expected = std::to_string(scan_count_),
                     .advice = "The file may be truncated."});
  }

  /// FARO's programs write row and column of the scanner's grid before the coordinates.
  static std::string place_in_doubt() {
    return "the meaning of columns 1 to 5, which have no names: 1 and 2 hold whole numbers, as "
           "rows and columns of a scanner's grid are, and 3 to 5 decimals; 1 to 3 are taken for "
           "x, y and z (input.columns, --columns, says what they are, such as -,-,x,y,z)";
  }

  /// Intensity before the colours, or classes behind them, look like colours as well.
  std::string colors_in_doubt() const {
    const auto place = [&](std::size_t column) {
      return std::to_string(layout_.first_color + column);
    };
    return "the meaning of columns " + place(1) + " to " + place(layout_.color_candidates) +
           ", which have no names and hold whole numbers from 0 to 255: " + place(1) + " to " +
           place(3) +
           " are taken for red, green and blue (input.columns, --columns, says what they are)";
  }

  ByteReader reader_;
  TextKind kind_;
  bool columns_are_named_;     ///< by the options
  std::vector<Line> pending_;  ///< the sample, read but not parsed
  std::size_t next_pending_ = 0;
  std::string comment_;
  std::optional<std::uint64_t> declared_;
  TextLayout layout_;
  std::vector<TextColumn> rounded_;   ///< with types that would keep their numbers
  bool has_color_fractions_ = false;  ///< red, green and blue from 0 to 1, of .xyzrgb
  bool plain_numbers_ = true;
  PointRowLayout rows_layout_;
  std::size_t row_bytes_ = 0;
  std::vector<std::byte> rows_;
  std::uint64_t scan_ = 0;         ///< of a .pts file, from 1; 0 before the first count
  std::uint64_t scan_count_ = 0;   ///< points that the scan should have at least
  std::uint64_t scan_points_ = 0;  ///< points of the scan so far
};

}  // namespace

std::unique_ptr<PointSource> open_text_source(ByteReader reader, const TextOptions& options,
                                              TextKind kind) {
  return std::make_unique<TextSource>(std::move(reader), options, kind);
}

}  // namespace orbweave
