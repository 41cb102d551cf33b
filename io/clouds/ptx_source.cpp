#include "io/clouds/ptx_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "io/clouds/text_layout.h"
#include "io/error.h"
#include "io/points/no_data.h"
#include "io/text/counted_noun.h"
#include "io/text/quantity.h"
#include "io/text/text_fields.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

constexpr std::size_t kHeaderLines = 10;
constexpr std::array<std::size_t, kHeaderLines> kHeaderFields = {1, 1, 3, 3, 3, 3, 4, 4, 4, 4};
constexpr std::array<const char*, kHeaderLines> kHeaderMeaning = {
    "the number of columns of a scan",
    "the number of rows of the scan",
    "the scanner's position, 3 numbers",
    "the scanner's first axis, 3 numbers",
    "the scanner's second axis, 3 numbers",
    "the scanner's third axis, 3 numbers",
    "row 1 of a 4x4 matrix",
    "row 2 of a 4x4 matrix",
    "row 3 of a 4x4 matrix",
    "row 4 of a 4x4 matrix"};
constexpr const char* kNoReturn = "no return";

struct PtxScan {
  std::uint64_t columns = 0;
  std::uint64_t rows = 0;
  bool is_genuine = true;                         ///< the axes are not all zero
  std::array<std::array<double, 3>, 4> matrix{};  ///< for row vectors; last column left out

  std::uint64_t pulses() const { return columns * rows; }
  /// The matrix for column vectors.
  RigidMotion motion() const {
    RigidMotion motion;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      motion.rows[axis] = {matrix[0][axis], matrix[1][axis], matrix[2][axis]};
      motion.translation[static_cast<int>(axis)] = matrix[3][axis];
    }
    return motion;
  }
  /// Products from left to right, the translation last: what survives of seven digits before the
  /// point depends on no compiler's liking.
  Vec3 world(Vec3 p) const {
    if (holds_no_data_value(p)) return p;
    Vec3 w;
    for (std::size_t axis = 0; axis < 3; ++axis)
      w[static_cast<int>(axis)] =
          p.x * matrix[0][axis] + p.y * matrix[1][axis] + p.z * matrix[2][axis] + matrix[3][axis];
    return w;
  }
};

struct PtxRow {
  Vec3 position;
  float intensity = 0.0F;
  std::array<std::uint8_t, 3> color{};
  bool has_color = false;
};

std::size_t count_fields(std::string_view line) {
  std::size_t count = 0;
  while (take_field(line, ' ')) ++count;
  return count;
}

inline const char* skip_blanks(const char* at, const char* last) {
  while (at != last && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
  return at;
}

inline bool is_blank_line(std::string_view line) {
  return line.find_first_not_of(" \t\r") == line.npos;
}

/// A number and the blank or line end behind it; nullptr for anything else.
template <class T>
inline const char* take_number(const char* at, const char* last, T& value) {
  const char* const end = parse_number(skip_blanks(at, last), last, value);
  if (end == nullptr) return nullptr;
  const char* const behind = skip_blanks(end, last);
  return behind == last || behind != end ? behind : nullptr;
}

/// Headers and rows of a PTX file, one after the other.
class PtxLines {
 public:
  explicit PtxLines(ByteReader reader) : reader_(std::move(reader)) {
    skip_byte_order_mark(reader_);
  }
  const ByteReader& reader() const { return reader_; }

  /// The next scan's header; false where the file has ended before it.
  bool next_header(PtxScan& scan) {
    std::array<std::array<double, 4>, kHeaderLines> values{};
    for (std::size_t i = 0; i < kHeaderLines; ++i) {
      if (!next_line()) {
        if (i == 0) return false;
        refuse("the file ends inside the header of scan " + std::to_string(scans_ + 1), "its end",
               kHeaderMeaning[i]);
      }
      if (i < 2)
        (i == 0 ? scan.columns : scan.rows) = parse_count(i);
      else
        parse_header_line(i, values[i]);
    }
    ++scans_;
    take_values(values, scan);
    check_length(scan);
    return true;
  }

  /// The scan's next row; false where the file has ended.
  bool next_row(PtxRow& row) {
    if (!next_line()) return false;
    parse_row(row);
    return true;
  }

  /// Skips a row unread; false where the file has ended.
  bool skip_row() { return next_line(); }

  [[noreturn]] void refuse(const std::string& problem, const std::string& found,
                           const std::string& expected, const std::string& advice = "") const {
    throw_bad_input(problem, {.file = reader_.name(),
                              .place = reader_.line_place(),
                              .found = found,
                              .expected = expected,
                              .advice = advice});
  }

  [[noreturn]] void refuse_end(const PtxScan& scan, std::uint64_t rows_read) const {
    refuse("scan " + std::to_string(scans_) + " has fewer rows than its header says",
           counted_noun(rows_read, "row", "rows"),
           std::to_string(scan.columns) + " x " + std::to_string(scan.rows),
           "The file may be truncated.");
  }

 private:
  bool next_line() {
    while (reader_.next_line(line_))
      if (!is_blank_line(line_)) return true;
    return false;
  }

  std::uint64_t parse_count(std::size_t i) const {
    std::string_view rest = line_;
    const auto field = take_field(rest, ' ');
    std::uint32_t count = 0;
    const ParseOutcome outcome =
        parse_value(*field, ScalarType::kUint32, reinterpret_cast<std::byte*>(&count));
    if (outcome == ParseOutcome::kNumber && is_blank_line(rest)) return count;
    refuse(scans_ == 0 ? "this is no PTX header" : "this is no header of a further scan",
           excerpt(line_), std::string(kHeaderMeaning[i]) + ", below 2^32",
           scans_ == 0 ? "" : "All rows of the scan before it were read.");
  }

  void parse_header_line(std::size_t i, std::array<double, 4>& values) const {
    std::string_view rest = line_;
    bool is_good = count_fields(line_) == kHeaderFields[i];
    for (std::size_t k = 0; is_good && k < kHeaderFields[i]; ++k) {
      const auto field = take_field(rest, ' ');
      is_good = parse_value(*field, ScalarType::kFloat64,
                            reinterpret_cast<std::byte*>(&values[k])) == ParseOutcome::kNumber &&
                std::isfinite(values[k]);
    }
    if (!is_good) refuse("this is no line of a PTX header", excerpt(line_), kHeaderMeaning[i]);
  }

  void take_values(const std::array<std::array<double, 4>, kHeaderLines>& values,
                   PtxScan& scan) const {
    constexpr std::size_t kAxes = 3;
    constexpr std::size_t kMatrix = 6;
    scan.is_genuine = std::any_of(&values[kAxes], &values[kMatrix], [](const auto& axis) {
      return axis[0] != 0.0 || axis[1] != 0.0 || axis[2] != 0.0;
    });
    for (std::size_t row = 0; row < 4; ++row) {
      const std::array<double, 4>& from = values[kMatrix + row];
      if (from[3] != (row == 3 ? 1.0 : 0.0))
        refuse("the matrix of a scan is not affine",
               format_exact(from[3]) + " in row " + std::to_string(row + 1),
               "a last column of 0 0 0 1",
               "PTX matrices have the translation in their last row; this one may be turned over.");
      std::copy_n(from.begin(), 3, scan.matrix[row].begin());
    }
    const auto axis = [&](std::size_t row) {
      return Vec3{scan.matrix[row][0], scan.matrix[row][1], scan.matrix[row][2]};
    };
    if (dot(axis(0), cross(axis(1), axis(2))) == 0.0)
      refuse("the matrix of a scan maps space to a plane", "determinant 0", "a rotation");
  }

  /// Told before the first row where the file cannot hold the scan: a row has at least 8 bytes.
  void check_length(const PtxScan& scan) const {
    constexpr std::uint64_t kLeastRow = 8;
    const auto left = reader_.bytes_left();
    if (!scan.is_genuine || !left || scan.pulses() <= (*left + 1) / kLeastRow) return;
    refuse("scan " + std::to_string(scans_) + " has fewer rows than its header says",
           std::to_string(*left) + " bytes",
           std::to_string(scan.columns) + " x " + std::to_string(scan.rows) + " rows",
           "The file may be truncated.");
  }

  void parse_row(PtxRow& row) const {
    const char* at = line_.data();
    const char* const last = at + line_.size();
    for (int axis = 0; axis < 3; ++axis) {
      at = take_number(at, last, row.position[axis]);
      if (at == nullptr) refuse_row();
    }
    at = take_number(at, last, row.intensity);
    if (at == nullptr) refuse_row();
    row.has_color = at != last;
    for (std::size_t i = 0; row.has_color && i < 3; ++i) {
      std::string_view rest(at, static_cast<std::size_t>(last - at));
      const auto field = take_field(rest, ' ');
      if (!field ||
          parse_value(*field, ScalarType::kUint8, reinterpret_cast<std::byte*>(&row.color[i])) !=
              ParseOutcome::kNumber)
        refuse_row();
      at = rest.data();
    }
    if (skip_blanks(at, last) != last) refuse_row();
  }

  /// Says which field of the line is at fault.
  [[noreturn]] void refuse_row() const {
    const std::size_t fields = count_fields(line_);
    if (fields != 4 && fields != 7)
      refuse("this is no row of scan " + std::to_string(scans_),
             counted_noun(fields, "column", "columns"),
             "x y z intensity or x y z intensity red green blue",
             fields == 1 ? "The scan before may have fewer rows than its header says." : "");
    std::string_view rest = line_;
    for (std::size_t i = 0; i < fields; ++i) {
      const auto field = take_field(rest, ' ');
      const ScalarType type = i < 3    ? ScalarType::kFloat64
                              : i == 3 ? ScalarType::kFloat32
                                       : ScalarType::kUint8;
      std::array<std::byte, 8> ignored;
      const ParseOutcome outcome = parse_value(*field, type, ignored.data());
      if (outcome == ParseOutcome::kNumber) continue;
      throw_bad_input(
          outcome == ParseOutcome::kNoNumber ? "this is no number" : "the number is out of range",
          {.file = reader_.name(),
           .place = reader_.line_place() + ", column " + std::to_string(i + 1),
           .found = excerpt(*field),
           .expected = expected_value(type)});
    }
    refuse("this is no row of a scan", excerpt(line_), "numbers between blanks");
  }

  ByteReader reader_;
  std::string_view line_;
  std::uint64_t scans_ = 0;
};

/// Walks over the rows that hold a point.
class PtxRows {
 public:
  explicit PtxRows(ByteReader reader) : lines_(std::move(reader)) {}

  /// The next row with a return, of this scan or a later one; false at the end.
  bool next(PtxRow& row) {
    while (true) {
      while (rows_read_ == scan_.pulses())
        if (!next_scan()) return false;
      if (!lines_.next_row(row)) {
        end_early();
        return false;
      }
      ++rows_read_;
      has_color_ = row.has_color;
      if (row.position != Vec3{}) return true;
      ++no_return_;
    }
  }

  /// Moves on to the next scan, the rest of this one unread.
  void skip_scan() {
    while (rows_read_ < scan_.pulses() && lines_.skip_row()) ++rows_read_;
    if (rows_read_ < scan_.pulses()) end_early();
  }

  const PtxLines& lines() const { return lines_; }
  const PtxScan& scan() const { return scan_; }
  std::uint64_t scan_number() const { return scan_number_; }
  bool has_scans() const { return scan_number_ != 0; }
  bool has_color() const { return has_color_; }  ///< of the last row

  DroppedPoints left_out() const {
    DroppedPoints reasons;
    if (no_return_ != 0) reasons[kNoReturn] = no_return_;
    return reasons;
  }

 private:
  bool next_scan() {
    PtxScan scan;
    if (!lines_.next_header(scan)) return false;
    scan_ = scan;
    rows_read_ = 0;
    ++scan_number_;
    return true;
  }

  void end_early() {
    if (scan_.is_genuine) lines_.refuse_end(scan_, rows_read_);
    scan_ = {};
    rows_read_ = 0;
  }

  PtxLines lines_;
  PtxScan scan_;
  std::uint64_t scan_number_ = 0;
  std::uint64_t rows_read_ = 0;  ///< of the scan
  std::uint64_t no_return_ = 0;
  bool has_color_ = false;
};

/// Whether the first point of every scan has colours.
bool every_scan_has_colors(ByteReader reader) {
  PtxRows rows(std::move(reader));
  PtxRow row;
  while (rows.next(row)) {
    if (!row.has_color) return false;
    rows.skip_scan();
  }
  return true;
}

class PtxSource final : public PointSource {
 public:
  PtxSource(ByteReader reader, const std::function<ByteReader()>& again)
      : rows_(std::move(reader)), has_row_(rows_.next(row_)) {
    if (!rows_.has_scans())
      throw_bad_input("the file holds no scans",
                      {.file = rows_.lines().reader().name(), .expected = kHeaderMeaning[0]});
    has_colors_ = rows_.has_color() && (!again || every_scan_has_colors(again()));
    loses_colors_ = rows_.has_color() && !has_colors_;
    schema_.position_type = ScalarType::kFloat64;
    schema_.attributes.push_back({"intensity", ScalarType::kFloat32});
    if (!has_colors_) return;
    for (const char* name : {"red", "green", "blue"})
      schema_.attributes.push_back({name, ScalarType::kUint8});
  }

  const PointSchema& schema() const override { return schema_; }
  /// Scans further on are not known yet, and pulses without return count as rows.
  std::optional<std::uint64_t> declared_points() const override { return std::nullopt; }
  std::uint64_t bytes_read() const override { return bytes().bytes_read(); }
  std::uint64_t bytes_total() const override { return bytes().bytes_total(); }
  std::optional<ScannerPlace> scanner() const override { return scanner_; }
  ScanNumber scan() const override { return {.scan = scan_}; }
  DroppedPoints left_out() const override { return rows_.left_out(); }
  FileFacts facts() const override {
    FileFacts facts;
    facts.format = "PTX";
    facts.scans = scans_;
    if (loses_colors_)
      facts.lost_values.emplace_back("colours, which not all scans of the file have");
    return facts;
  }

  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.clear();
    batch.schema = schema_;
    if (!has_row_ || capacity == 0) return false;
    const PtxScan scan = rows_.scan();
    const std::uint64_t scan_number = rows_.scan_number();
    scanner_.reset();
    if (scan.is_genuine) scanner_ = ScannerPlace{scan.world({})};
    add_facts(scan, scan_number);
    scan_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(scan_number, kMostScans) - 1);
    do {
      append(scan, batch);
      has_row_ = rows_.next(row_);
    } while (has_row_ && rows_.scan_number() == scan_number && batch.size() < capacity);
    if (scan_number == scans_.size()) scans_.back().points += batch.size();
    return true;
  }

 private:
  /// That are told apart: a file may hold a scan per point.
  static constexpr std::size_t kMostScans = 10'000;

  void add_facts(const PtxScan& scan, std::uint64_t number) {
    while (scans_.size() < std::min<std::uint64_t>(number, kMostScans)) scans_.emplace_back();
    if (number != scans_.size()) return;
    scans_.back().pose = scan.motion();
    scans_.back().scanner = scanner_;
  }

  const ByteSource& bytes() const { return rows_.lines().reader().source(); }

  void append(const PtxScan& scan, PointCloud& batch) {
    batch.positions.push_back(scan.world(row_.position));
    loses_colors_ = loses_colors_ || (row_.has_color && !has_colors_);
    std::array<std::byte, sizeof(float) + 3> attributes;
    std::memcpy(attributes.data(), &row_.intensity, sizeof(float));
    if (has_colors_) {
      if (!row_.has_color)
        rows_.lines().refuse("this row has no colours, unlike the file's first scan", "4 columns",
                             "7 columns",
                             "A pipe is read once and cannot look ahead: name the file instead.");
      std::memcpy(attributes.data() + sizeof(float), row_.color.data(), 3);
    }
    batch.attributes.insert(batch.attributes.end(), attributes.begin(),
                            attributes.begin() + (has_colors_ ? sizeof(float) + 3 : sizeof(float)));
  }

  PtxRows rows_;
  PtxRow row_;  ///< the next point, of the scan that rows_ is in
  bool has_row_ = false;
  bool has_colors_ = false;
  bool loses_colors_ = false;     ///< some points, as far as they were read, have colours
  std::vector<ScanFacts> scans_;  ///< that were read; scans without points have none
  PointSchema schema_;
  std::optional<ScannerPlace> scanner_;
  std::uint32_t scan_ = 0;  ///< that the last batch is of
};

}  // namespace

bool looks_like_ptx(ByteReader& reader) {
  constexpr std::size_t kLookBytes = 4096;
  reader.ensure(kLookBytes);
  std::string_view text(reinterpret_cast<const char*>(reader.data()),
                        std::min(reader.available(), kLookBytes));
  for (const std::size_t fields : kHeaderFields) {
    const std::size_t end = text.find('\n');
    if (end == text.npos || count_fields(text.substr(0, end)) != fields) return false;
    text.remove_prefix(end + 1);
  }
  return true;
}

std::unique_ptr<PointSource> open_ptx_source(ByteReader reader,
                                             const std::function<ByteReader()>& again) {
  return std::make_unique<PtxSource>(std::move(reader), again);
}

}  // namespace orbweave
