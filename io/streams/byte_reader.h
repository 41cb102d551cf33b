// A ByteSource in blocks: contiguous bytes for binary rows, lines for text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "io/streams/byte_source.h"

namespace orbweave {

/// Buffers a source. Holds one block, or one line where that is longer; a line may have up to
/// kLineLimit bytes.
class ByteReader {
 public:
  static constexpr std::size_t kBlockBytes = std::size_t{1} << 18;
  static constexpr std::size_t kLineLimit = std::size_t{1} << 20;

  explicit ByteReader(std::unique_ptr<ByteSource> source);

  /// The bytes at hand, and how many; valid until the next call of ensure or next_line.
  const std::byte* data() const { return buffer_.data() + begin_; }
  std::size_t available() const { return end_ - begin_; }
  /// Brings at least `bytes` bytes to hand, fewer only where the stream ends. Returns true when
  /// the stream holds them. `bytes` must not exceed kBlockBytes.
  bool ensure(std::size_t bytes) { return available() >= bytes || refill(bytes); }
  /// Drops bytes at hand.
  void consume(std::size_t bytes) { begin_ += bytes; }
  /// Drops bytes, at hand or not; returns how many there were to drop.
  std::uint64_t skip(std::uint64_t bytes);

  /// The next line, without its LF or CRLF; false at the end. Where the first line ends in a CR
  /// alone, as on old Macs, a CR ends a line as well. The view is valid until the next
  /// call. Throws Error (bad input) for a line beyond kLineLimit: that is no text.
  bool next_line(std::string_view& line);
  /// Number of the line that next_line returned last, from 1.
  std::uint64_t line_number() const { return line_number_; }

  /// Position in the (decompressed) stream.
  std::uint64_t offset() const { return loaded_ - available(); }
  const ByteSource& source() const { return *source_; }
  const std::string& name() const { return source_->name(); }
  /// Bytes from here to the end, where that is known beforehand.
  std::optional<std::uint64_t> bytes_left() const;
  /// "line 7": where the last line was; "byte 1042": where the reader stands.
  std::string line_place() const;
  std::string byte_place() const;

 private:
  bool refill(std::size_t bytes);
  bool first_line_ends_in_cr();
  const void* find_line_end(std::size_t from) const;

  std::unique_ptr<ByteSource> source_;
  std::vector<std::byte> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t loaded_ = 0;
  std::uint64_t line_number_ = 0;
  bool source_ended_ = false;
  bool cr_ends_lines_ = false;
};

/// At the front of a text: drops the mark that some programs put before UTF-8. Throws Error (bad
/// input) for UTF-16, which such a mark tells as well.
void skip_byte_order_mark(ByteReader& reader);

/// Text from a damaged file for a message: quoted, shortened, as shown() has it.
std::string excerpt(std::string_view text);

}  // namespace orbweave
