#include "io/ply/ply_rows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <utility>

#include "io/error.h"
#include "io/text/counted_noun.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

static_assert(std::endian::native == std::endian::little ||
              std::endian::native == std::endian::big);

/// Rows per block of packed rows.
constexpr std::size_t kPackedRows = 2048;
/// A block of packed rows also ends when its captured lists hold this number of values.
constexpr std::size_t kListValues = std::size_t{1} << 16;

bool needs_swap(PlyFormat format) {
  if (format == PlyFormat::kAscii) return false;
  return (format == PlyFormat::kBinaryLittleEndian) != (std::endian::native == std::endian::little);
}

template <class T>
std::int64_t as_integer(const std::byte* bytes, bool swap) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return static_cast<std::int64_t>(value);
}

bool is_floating(ScalarType type) {
  return type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// The first blank-separated word, removed from the line; empty at its end.
std::string_view take_word(std::string_view& line) {
  const char* at = line.data();
  const char* const last = at + line.size();
  while (at != last && is_blank(*at)) ++at;
  const char* const begin = at;
  while (at != last && !is_blank(*at)) ++at;
  line = {at, static_cast<std::size_t>(last - at)};
  return {begin, static_cast<std::size_t>(at - begin)};
}

}  // namespace

std::int64_t ply_integer(ScalarType type, const std::byte* bytes, bool swap) {
  switch (type) {
    case ScalarType::kInt8:
      return as_integer<std::int8_t>(bytes, swap);
    case ScalarType::kUint8:
      return as_integer<std::uint8_t>(bytes, swap);
    case ScalarType::kInt16:
      return as_integer<std::int16_t>(bytes, swap);
    case ScalarType::kUint16:
      return as_integer<std::uint16_t>(bytes, swap);
    case ScalarType::kInt32:
      return as_integer<std::int32_t>(bytes, swap);
    case ScalarType::kUint32:
      return as_integer<std::uint32_t>(bytes, swap);
    case ScalarType::kInt64:
      return as_integer<std::int64_t>(bytes, swap);
    default:
      return as_integer<std::uint64_t>(bytes, swap);
  }
}

PlyRowReader::PlyRowReader(ByteReader& reader, const PlyHeader& header, const PlyElement& element,
                           std::optional<std::size_t> captured_list)
    : reader_(reader),
      element_(element),
      format_(header.format),
      captured_list_(captured_list),
      rows_left_(element.count) {
  fixed_ = format_ != PlyFormat::kAscii && !element.has_lists();
  for (const PlyProperty& property : element.properties) {
    if (property.is_list) continue;
    columns_.push_back({property.name, property.type, row_bytes_});
    row_bytes_ += size_of(property.type);
  }
  if (captured_list_ && is_floating(element.properties[*captured_list_].type))
    throw_bad_input("a face's corners have no integer type",
                    {.file = reader_.name(), .place = "element " + element.name});
}

bool PlyRowReader::swapped() const { return needs_swap(format_); }

std::size_t PlyRowReader::next(std::size_t limit) {
  if (to_consume_ != 0) reader_.consume(std::exchange(to_consume_, 0));
  limit = static_cast<std::size_t>(std::min<std::uint64_t>(limit, rows_left_));
  if (limit == 0) return 0;
  if (fixed_ && row_bytes_ != 0 && row_bytes_ <= ByteReader::kBlockBytes) return next_fixed(limit);
  packed_.clear();
  list_sizes_.clear();
  list_values_.clear();
  std::size_t count = 0;
  for (; count < std::min(limit, kPackedRows) && list_values_.size() < kListValues; ++count) {
    if (format_ == PlyFormat::kAscii)
      read_text_row();
    else
      read_binary_row();
    --rows_left_;
  }
  rows_ = packed_.data();
  return count;
}

std::size_t PlyRowReader::next_fixed(std::size_t limit) {
  if (!reader_.ensure(row_bytes_)) truncated();
  const std::size_t count = std::min(limit, reader_.available() / row_bytes_);
  rows_ = reader_.data();
  // Given back with the next call: until then the caller looks at the bytes.
  to_consume_ = count * row_bytes_;
  rows_left_ -= count;
  return count;
}

void PlyRowReader::skip() {
  if (element_.properties.empty()) {
    rows_left_ = 0;
    return;
  }
  while (next(std::numeric_limits<std::size_t>::max()) != 0) {
  }
}

bool PlyRowReader::restrict(std::uint64_t first, std::uint64_t count) {
  if (!fixed_ || row_bytes_ == 0 || first > rows_left_) return false;
  // A damaged header may declare more rows than any file has bytes.
  if (first > std::numeric_limits<std::uint64_t>::max() / row_bytes_) truncated();
  const std::uint64_t bytes = first * row_bytes_;
  if (reader_.skip(bytes) != bytes) truncated();
  rows_left_ = std::min(rows_left_ - first, count);
  return true;
}

void PlyRowReader::add_packed(ScalarType type) {
  const std::size_t bytes = size_of(type);
  if (!reader_.ensure(bytes)) truncated();
  packed_.insert(packed_.end(), reader_.data(), reader_.data() + bytes);
  reader_.consume(bytes);
}

std::int64_t PlyRowReader::binary_integer(ScalarType type) {
  const std::size_t bytes = size_of(type);
  if (!reader_.ensure(bytes)) truncated();
  const std::int64_t value = ply_integer(type, reader_.data(), swapped());
  reader_.consume(bytes);
  return value;
}

void PlyRowReader::read_binary_row() {
  for (std::size_t i = 0; i < element_.properties.size(); ++i) {
    const PlyProperty& property = element_.properties[i];
    if (property.is_list)
      read_binary_list(property, i == captured_list_);
    else
      add_packed(property.type);
  }
}

void PlyRowReader::read_binary_list(const PlyProperty& property, bool capture) {
  const std::int64_t count = binary_integer(property.count_type);
  constexpr std::int64_t kLongest = std::numeric_limits<std::uint32_t>::max();
  if (count < 0 || count > kLongest)
    fail_row("a list's length makes no sense", std::to_string(count), "0 to 4294967295");
  if (!capture) {
    const std::uint64_t bytes = static_cast<std::uint64_t>(count) * size_of(property.type);
    if (reader_.skip(bytes) != bytes) truncated();
    return;
  }
  list_sizes_.push_back(static_cast<std::uint32_t>(count));
  for (std::int64_t i = 0; i < count; ++i) list_values_.push_back(binary_integer(property.type));
}

void PlyRowReader::read_text_row() {
  std::string_view line;
  do {
    if (!reader_.next_line(line)) truncated();
    // Blank lines are no rows, unless a row has no values at all.
  } while (!element_.properties.empty() && line.find_first_not_of(" \t\r") == line.npos);
  for (std::size_t i = 0; i < element_.properties.size(); ++i) {
    const PlyProperty& property = element_.properties[i];
    if (property.is_list) {
      read_text_list(line, property, i == captured_list_);
      continue;
    }
    const std::size_t at = packed_.size();
    packed_.resize(at + size_of(property.type));
    parse_word(next_word(line, property), property, property.type, packed_.data() + at);
  }
  const std::string_view excess = take_word(line);
  if (!excess.empty())
    fail_row("more values than the header's properties", excerpt(excess), "the end of the line");
}

std::string_view PlyRowReader::next_word(std::string_view& line, const PlyProperty& property) {
  const std::string_view word = take_word(line);
  if (word.empty())
    fail_row("fewer values than the header's properties", "the end of the line",
             "a value of property " + property.name);
  return word;
}

void PlyRowReader::parse_word(std::string_view word, const PlyProperty& property, ScalarType type,
                              std::byte* out) const {
  const ParseOutcome outcome = parse_value(word, type, out);
  if (outcome == ParseOutcome::kNumber) return;
  fail_row(outcome == ParseOutcome::kNoNumber
               ? "property " + property.name + " is no number"
               : "property " + property.name + " is out of its type's range",
           excerpt(word), expected_value(type));
}

void PlyRowReader::read_text_list(std::string_view& line, const PlyProperty& property,
                                  bool capture) {
  std::array<std::byte, 8> value{};
  parse_word(next_word(line, property), property, property.count_type, value.data());
  const std::int64_t count = ply_integer(property.count_type, value.data(), false);
  if (count < 0) fail_row("a list's length makes no sense", std::to_string(count), "0 or more");
  // No more than the line has words: each pass of the loop takes one or throws.
  for (std::int64_t i = 0; i < count; ++i) {
    const std::string_view word = next_word(line, property);
    parse_word(word, property, property.type, value.data());
    if (capture) list_values_.push_back(ply_integer(property.type, value.data(), false));
  }
  if (capture) list_sizes_.push_back(static_cast<std::uint32_t>(count));
}

std::string PlyRowReader::row_place() const {
  return (format_ == PlyFormat::kAscii ? reader_.line_place() : reader_.byte_place()) + ", " +
         element_.name + " " + std::to_string(element_.count - rows_left_);
}

void PlyRowReader::fail_row(const std::string& problem, std::string found,
                            std::string expected) const {
  throw_bad_input(problem, {.file = reader_.name(),
                            .place = row_place(),
                            .found = std::move(found),
                            .expected = std::move(expected)});
}

void PlyRowReader::truncated() const {
  throw_bad_input("the file ends inside element " + element_.name,
                  {.file = reader_.name(),
                   .place = row_place(),
                   .found = counted_noun(element_.count - rows_left_, "whole row", "whole rows"),
                   .expected = counted_noun(element_.count, "row", "rows"),
                   .advice = "The file is truncated or its header's count is wrong."});
}

void check_ply_end(ByteReader& reader, const PlyElement& last_element) {
  while (reader.ensure(1)) {
    const auto* text = reinterpret_cast<const char*>(reader.data());
    const char* const last = text + reader.available();
    const char* const at =
        std::find_if(text, last, [](char c) { return !is_blank(c) && c != '\n' && c != '\0'; });
    reader.consume(static_cast<std::size_t>(at - text));
    if (at == last) continue;
    throw_bad_input("the file goes on after its last row",
                    {.file = reader.name(),
                     .place = reader.byte_place(),
                     .expected = "the end of the file after " +
                                 counted_noun(last_element.count, "row", "rows") + " of element " +
                                 last_element.name,
                     .advice = "The header's count may be wrong."});
  }
}

}  // namespace orbweave
