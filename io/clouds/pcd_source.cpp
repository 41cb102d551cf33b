#include "io/clouds/pcd_source.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "io/clouds/pcd_header.h"
#include "io/clouds/text_layout.h"
#include "io/error.h"
#include "io/streams/lzf.h"
#include "io/text/counted_noun.h"
#include "io/text/little_endian.h"
#include "io/text/text_fields.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

constexpr std::size_t kRowsPerBlock = 2048;

/// Delivers the rows of a PCD file, packed as its header says.
class PcdRows {
 public:
  PcdRows(ByteReader& reader, const PcdHeader& header) : reader_(reader), header_(header) {}
  virtual ~PcdRows() = default;
  /// Brings the next rows to hand and returns how many: at least one, at most `limit`, of which
  /// there must be one left to read.
  virtual std::size_t next(std::size_t limit) = 0;
  /// The rows at hand, until the next call.
  virtual const std::byte* rows() const = 0;
  /// Refuses anything but blanks and zeros behind the last row.
  void check_end() {
    const auto is_filler = [](std::byte b) {
      return b == std::byte{0} || b == std::byte{' '} || b == std::byte{'\t'} ||
             b == std::byte{'\r'} || b == std::byte{'\n'};
    };
    while (reader_.ensure(1)) {
      const std::byte* const last = reader_.data() + reader_.available();
      const std::byte* const at = std::find_if_not(reader_.data(), last, is_filler);
      reader_.consume(static_cast<std::size_t>(at - reader_.data()));
      if (at != last)
        refuse("the file goes on after its last point", "",
               "the end of the file after " + counted_points(header_.points));
    }
  }

 protected:
  [[noreturn]] void refuse(const std::string& problem, const std::string& found,
                           const std::string& expected, const std::string& advice = "") const {
    throw_bad_input(problem, {.file = reader_.name(),
                              .place = reader_.byte_place(),
                              .found = found,
                              .expected = expected,
                              .advice = advice});
  }
  [[noreturn]] void refuse_short(const std::string& found) const {
    refuse("the file is shorter than its header says", found,
           counted_points(header_.points) + " of " + std::to_string(header_.row_bytes) + " bytes",
           "The file may be truncated.");
  }

  ByteReader& reader_;
  const PcdHeader& header_;
};

class BinaryRows final : public PcdRows {
 public:
  BinaryRows(ByteReader& reader, const PcdHeader& header) : PcdRows(reader, header) {
    const auto left = reader.bytes_left();
    if (left && header.points > *left / header.row_bytes)
      refuse_short(std::to_string(*left) + " bytes");
  }
  const std::byte* rows() const override { return rows_; }

  std::size_t next(std::size_t limit) override {
    const std::size_t count = std::min(limit, ByteReader::kBlockBytes / header_.row_bytes);
    if (!reader_.ensure(count * header_.row_bytes))
      refuse_short(std::to_string(reader_.available()) + " more bytes");
    rows_ = reader_.data();
    reader_.consume(count * header_.row_bytes);
    return count;
  }

 private:
  const std::byte* rows_ = nullptr;
};

class AsciiRows final : public PcdRows {
 public:
  AsciiRows(ByteReader& reader, const PcdHeader& header) : PcdRows(reader, header) {
    // A digit and a separator per value; the last line may lack its end.
    const auto left = reader.bytes_left();
    if (left && header.points > (*left + 1) / (2 * header.row_values))
      refuse_end(std::to_string(*left) + " bytes");
  }
  const std::byte* rows() const override { return rows_.data(); }

  std::size_t next(std::size_t limit) override {
    const std::size_t count = std::min(limit, kRowsPerBlock);
    rows_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      std::string_view line;
      do {
        if (!reader_.next_line(line)) refuse_end(counted_points(rows_read_));
      } while (line.find_first_not_of(" \t\r") == line.npos);
      // Grown row by row: a line that is there justifies its row.
      rows_.resize(rows_.size() + header_.row_bytes);
      parse_row(line, rows_.data() + rows_.size() - header_.row_bytes);
      ++rows_read_;
    }
    return count;
  }

 private:
  void parse_row(std::string_view line, std::byte* out) const {
    std::string_view rest = line;
    std::size_t column = 0;
    for (const PcdField& field : header_.fields) {
      for (std::size_t i = 0; i < field.count; ++i, ++column) {
        const auto value = take_field(rest, ' ');
        if (!value) refuse_line(line);
        if (field.is_padding()) continue;
        const ParseOutcome outcome = parse_value(*value, field.type, out + i * size_of(field.type));
        if (outcome != ParseOutcome::kNumber) refuse_value(*value, column, field, outcome);
      }
      if (std::endian::native == std::endian::big && field.is_packed_color())
        std::reverse(out, out + field.bytes());
      out += field.bytes();
    }
    if (take_field(rest, ' ')) refuse_line(line);
  }

  [[noreturn]] void refuse_end(const std::string& found) const {
    throw_bad_input("the file is shorter than its header says",
                    {.file = reader_.name(),
                     .place = reader_.line_place(),
                     .found = found,
                     .expected = counted_points(header_.points),
                     .advice = "The file may be truncated."});
  }

  [[noreturn]] void refuse_line(std::string_view line) const {
    std::size_t found = 0;
    while (take_field(line, ' ')) ++found;
    throw_bad_input("the line does not match FIELDS",
                    {.file = reader_.name(),
                     .place = reader_.line_place(),
                     .found = counted_noun(found, "value", "values"),
                     .expected = std::to_string(header_.row_values)});
  }

  [[noreturn]] void refuse_value(std::string_view value, std::size_t column, const PcdField& field,
                                 ParseOutcome outcome) const {
    throw_bad_input(
        outcome == ParseOutcome::kNoNumber ? "this is no number" : "the number is out of range",
        {.file = reader_.name(),
         .place = reader_.line_place() + ", column " + std::to_string(column + 1),
         .found = excerpt(value),
         .expected = std::string(expected_value(field.type)) + " (" + field.name + ")"});
  }

  std::vector<std::byte> rows_;
  std::uint64_t rows_read_ = 0;
};

class CompressedRows final : public PcdRows {
 public:
  using PcdRows::PcdRows;
  const std::byte* rows() const override { return rows_.data(); }

  std::size_t next(std::size_t limit) override {
    if (!std::exchange(started_, true)) decompress();
    const std::size_t count = std::min(limit, ByteReader::kBlockBytes / header_.row_bytes);
    rows_.resize(count * header_.row_bytes);
    std::size_t column = 0;
    std::size_t offset = 0;
    for (const PcdField& field : header_.fields) {
      if (!field.is_padding() || has_padding_) {
        const std::size_t bytes = field.bytes();
        const std::byte* from = data_.data() + column + next_row_ * bytes;
        std::byte* to = rows_.data() + offset;
        for (std::size_t i = 0; i < count; ++i, from += bytes, to += header_.row_bytes)
          std::memcpy(to, from, bytes);
        column += static_cast<std::size_t>(header_.points) * bytes;
      }
      offset += field.bytes();
    }
    next_row_ += count;
    return count;
  }

 private:
  void decompress() {
    constexpr std::size_t kSizesBytes = 8;
    if (!reader_.ensure(kSizesBytes)) refuse_short("no sizes of the compressed points");
    const std::uint64_t compressed = load_little<std::uint32_t>(reader_.data());
    const std::uint64_t whole = load_little<std::uint32_t>(reader_.data() + 4);
    check_whole(whole);
    if (whole / kLzfMostBytesPerByte > compressed)
      refuse("the compressed size cannot be true",
             std::to_string(compressed) + " bytes for " + std::to_string(whole),
             "at least one byte for " + std::to_string(kLzfMostBytesPerByte));
    reader_.consume(kSizesBytes);
    const auto left = reader_.bytes_left();
    if (left && compressed > *left)
      refuse_short(std::to_string(*left) + " of " + std::to_string(compressed) +
                   " compressed bytes");
    decode(compressed, static_cast<std::size_t>(whole));
  }

  /// Writers leave padding out of compressed files, though a header may still speak of it.
  void check_whole(std::uint64_t whole) {
    std::uint64_t padding = 0;
    for (const PcdField& field : header_.fields)
      if (field.is_padding()) padding += field.bytes();
    const auto fits = [&](std::uint64_t row_bytes) {
      return row_bytes != 0 && whole % row_bytes == 0 && whole / row_bytes == header_.points;
    };
    has_padding_ = fits(header_.row_bytes);
    if (has_padding_ || fits(header_.row_bytes - padding)) return;
    refuse("the size of the decompressed points does not match the header",
           std::to_string(whole) + " bytes",
           counted_points(header_.points) + " of " + std::to_string(header_.row_bytes) + " bytes");
  }

  void decode(std::uint64_t compressed, std::size_t whole) {
    constexpr std::uint64_t kPieceBytes = std::uint64_t{1} << 16;
    LzfDecoder decoder(whole);
    while (compressed > 0) {
      reader_.ensure(static_cast<std::size_t>(std::min(compressed, kPieceBytes)));
      const auto piece = static_cast<std::size_t>(
          std::min<std::uint64_t>({compressed, kPieceBytes, reader_.available()}));
      const std::size_t used = decoder.decode({reader_.data(), piece});
      reader_.consume(used);
      compressed -= used;
      if (!decoder.is_valid())
        refuse("the compressed points are damaged", "",
               "LZF data of " + std::to_string(whole) + " bytes");
      if (used == 0) refuse_short(std::to_string(compressed) + " compressed bytes missing");
    }
    if (decoder.size() != whole)
      refuse("the compressed points are damaged", std::to_string(decoder.size()) + " bytes",
             std::to_string(whole));
    data_ = decoder.take();
  }

  bool started_ = false;
  bool has_padding_ = true;
  std::vector<std::byte> data_;  ///< field by field
  std::size_t next_row_ = 0;
  std::vector<std::byte> rows_;
};

std::unique_ptr<PcdRows> make_rows(ByteReader& reader, const PcdHeader& header) {
  switch (header.data) {
    case PcdData::kAscii:
      return std::make_unique<AsciiRows>(reader, header);
    case PcdData::kBinary:
      return std::make_unique<BinaryRows>(reader, header);
    case PcdData::kCompressed:
      break;
  }
  return std::make_unique<CompressedRows>(reader, header);
}

class PcdSource final : public PointSource {
 public:
  explicit PcdSource(ByteReader reader)
      : reader_(std::move(reader)),
        header_(read_pcd_header(reader_)),
        layout_(pcd_columns(header_, reader_.name()), header_.row_bytes, rows_are_swapped()) {
    if (!layout_.missing().empty())
      throw_bad_input("the points have no " + layout_.missing(),
                      {.file = reader_.name(), .place = "FIELDS", .expected = "x, y and z"});
    rows_ = make_rows(reader_, header_);
    if (header_.viewpoint) scanner_ = ScannerPlace{*header_.viewpoint};
  }

  const PointSchema& schema() const override { return layout_.schema(); }
  std::optional<std::uint64_t> declared_points() const override { return header_.points; }
  std::uint64_t bytes_read() const override { return reader_.source().bytes_read(); }
  std::uint64_t bytes_total() const override { return reader_.source().bytes_total(); }
  std::optional<ScannerPlace> scanner() const override { return scanner_; }
  FileFacts facts() const override {
    FileFacts facts;
    facts.format = "PCD";
    facts.version = header_.version;
    facts.encoding = header_.data == PcdData::kAscii    ? "ascii"
                     : header_.data == PcdData::kBinary ? "binary"
                                                        : "binary_compressed";
    return facts;
  }

  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.clear();
    batch.schema = schema();
    while (batch.size() < capacity && points_read_ < header_.points) {
      const auto limit = static_cast<std::size_t>(
          std::min<std::uint64_t>(capacity - batch.size(), header_.points - points_read_));
      const std::size_t count = rows_->next(limit);
      layout_.append(rows_->rows(), count, batch);
      points_read_ += count;
    }
    if (batch.empty() && capacity != 0 && !std::exchange(ended_, true)) rows_->check_end();
    return !batch.empty();
  }

 private:
  bool rows_are_swapped() const {
    return std::endian::native == std::endian::big && header_.data != PcdData::kAscii;
  }

  ByteReader reader_;
  PcdHeader header_;
  PointRowLayout layout_;
  std::unique_ptr<PcdRows> rows_;
  std::optional<ScannerPlace> scanner_;
  std::uint64_t points_read_ = 0;
  bool ended_ = false;
};

}  // namespace

bool looks_like_pcd(ByteReader& reader) {
  for (const std::string_view front : {"# .PCD", "VERSION 0.", "VERSION ."}) {
    if (reader.ensure(front.size()) && std::memcmp(reader.data(), front.data(), front.size()) == 0)
      return true;
  }
  return false;
}

std::unique_ptr<PointSource> open_pcd_source(ByteReader reader) {
  return std::make_unique<PcdSource>(std::move(reader));
}

}  // namespace orbweave
