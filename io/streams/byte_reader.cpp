#include "io/streams/byte_reader.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "io/byte_order_mark.h"
#include "io/error.h"
#include "io/shown_text.h"

namespace orbweave {

namespace {

/// A stream of unknown length may be short: the buffer starts small and grows while it fills.
constexpr std::size_t kFirstBytes = std::size_t{1} << 13;

}  // namespace

ByteReader::ByteReader(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {
  // A short stream is read whole, with one byte to spare so that its end shows.
  const std::uint64_t length = source_->length().value_or(kFirstBytes);
  buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(length + 1, kBlockBytes)));
}

bool ByteReader::refill(std::size_t bytes) {
  if (source_ended_) return available() >= bytes;
  if (begin_ != 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, available());
    end_ -= begin_;
    begin_ = 0;
  }
  const std::size_t grown = loaded_ == 0 ? 0 : std::min(4 * buffer_.size(), kBlockBytes);
  if (buffer_.size() < std::max(bytes, grown)) buffer_.resize(std::max(bytes, grown));
  const std::size_t room = buffer_.size() - end_;
  const std::size_t got = source_->read({buffer_.data() + end_, room});
  source_ended_ = got < room;
  end_ += got;
  loaded_ += got;
  return available() >= bytes;
}

std::uint64_t ByteReader::skip(std::uint64_t bytes) {
  const auto at_hand = static_cast<std::size_t>(std::min<std::uint64_t>(bytes, available()));
  consume(at_hand);
  if (bytes == at_hand) return bytes;
  const std::uint64_t beyond = source_->skip(bytes - at_hand);
  loaded_ += beyond;
  return at_hand + beyond;
}

/// Whether a CR that no LF follows comes before the first LF. CRs before an LF are blanks, however
/// many there are.
bool ByteReader::first_line_ends_in_cr() {
  std::size_t at = 0;
  const auto end_of_line = [](std::byte b) { return b == std::byte{'\r'} || b == std::byte{'\n'}; };
  const auto has = [&](std::size_t index) { return index < kLineLimit && ensure(index + 1); };
  while (has(at) && !end_of_line(data()[at])) ++at;
  if (!has(at) || data()[at] == std::byte{'\n'}) return false;
  while (has(at) && data()[at] == std::byte{'\r'}) ++at;
  return !has(at) || data()[at] != std::byte{'\n'};
}

/// The first end of a line from `from` bytes on; null where none is at hand.
const void* ByteReader::find_line_end(std::size_t from) const {
  if (!cr_ends_lines_) return std::memchr(data() + from, '\n', available() - from);
  // One pass for both: a search for either alone would look at all that is at hand for every line.
  const std::byte* const end = data() + available();
  const std::byte* const found = std::find_if(
      data() + from, end, [](std::byte b) { return b == std::byte{'\r'} || b == std::byte{'\n'}; });
  return found != end ? found : nullptr;
}

bool ByteReader::next_line(std::string_view& line) {
  if (!ensure(1)) return false;
  if (line_number_ == 0) cr_ends_lines_ = first_line_ends_in_cr();
  ++line_number_;
  std::size_t searched = 0;
  const void* newline = nullptr;
  while (true) {
    newline = find_line_end(searched);
    if (newline != nullptr) break;
    searched = available();
    if (searched > kLineLimit)
      throw_bad_input("a line has more than " + std::to_string(kLineLimit) + " bytes",
                      {.file = name(), .place = line_place(), .expected = "text"});
    if (!refill(std::max(searched + 1, std::min(2 * searched, kLineLimit + 1))) &&
        available() == searched)
      break;
  }
  const auto* text = reinterpret_cast<const char*>(data());
  const std::size_t length =
      newline != nullptr ? static_cast<std::size_t>(static_cast<const std::byte*>(newline) - data())
                         : available();
  consume(length + (newline != nullptr ? 1 : 0));
  line = {text, length};
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

std::optional<std::uint64_t> ByteReader::bytes_left() const {
  const std::optional<std::uint64_t> length = source_->length();
  if (!length) return std::nullopt;
  return *length - std::min(*length, offset());
}

std::string ByteReader::line_place() const { return "line " + std::to_string(line_number_); }
std::string ByteReader::byte_place() const { return "byte " + std::to_string(offset()); }

void skip_byte_order_mark(ByteReader& reader) {
  const auto begins_with = [&](std::string_view mark) {
    return reader.ensure(mark.size()) && std::memcmp(reader.data(), mark.data(), mark.size()) == 0;
  };
  if (begins_with(kByteOrderMark)) reader.consume(kByteOrderMark.size());
  if (begins_with("\xFF\xFE") || begins_with("\xFE\xFF"))
    throw_bad_input(
        "the text is UTF-16",
        {.file = reader.name(),
         .expected = "ASCII or UTF-8",
         .advice = "Save it as UTF-8; PowerShell 5 does so with: Out-File -Encoding utf8"});
}

std::string excerpt(std::string_view text) {
  constexpr std::size_t kMost = 40;
  return "\"" + shown(text.substr(0, kMost)) + (text.size() > kMost ? "...\"" : "\"");
}

}  // namespace orbweave
