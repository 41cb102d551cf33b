// Decompression of LZF, the byte-oriented Lempel-Ziv coding of Marc Lehmann's liblzf.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace orbweave {

/// No LZF stream decompresses to more than this many bytes per byte of its own: the longest
/// back reference makes 264 bytes of 3.
constexpr std::size_t kLzfMostBytesPerByte = 88;

/// Decodes an LZF stream that comes in pieces. Memory grows with what was decoded.
class LzfDecoder {
 public:
  /// `limit_bytes`: the output's length; a stream that goes beyond is invalid.
  explicit LzfDecoder(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}

  /// Decodes the whole instructions at the front of `piece` and returns how many bytes they take
  /// up; fewer than all only where the last is cut off (one has up to 33 bytes) or is invalid.
  std::size_t decode(std::span<const std::byte> piece);
  /// False from the first back reference that reaches before the output's front, or instruction
  /// that goes beyond the limit, on.
  bool is_valid() const { return is_valid_; }
  std::size_t size() const { return size_; }  ///< bytes decoded so far
  /// Hands over the bytes decoded.
  std::vector<std::byte> take();

 private:
  /// Makes room for `bytes` more; false beyond the limit.
  bool make_room(std::size_t bytes);
  bool copy_back(std::size_t distance, std::size_t bytes);

  std::size_t limit_bytes_;
  std::size_t size_ = 0;
  bool is_valid_ = true;
  std::vector<std::byte> out_;  ///< longer than size_
};

}  // namespace orbweave
