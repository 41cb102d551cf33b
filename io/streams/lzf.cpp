// The coding, bit by bit (liblzf's description of its own format):
//   000LLLLL                     a run of L + 1 literal bytes follows
//   LLLooooo oooooooo            copy L + 2 bytes from o + 1 bytes back, L from 1 to 6
//   111ooooo LLLLLLLL oooooooo   copy L + 9 bytes from o + 1 bytes back
// The high bits of o come first. A copy may overlap what it makes, which repeats a pattern.
#include "io/streams/lzf.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace orbweave {

bool LzfDecoder::make_room(std::size_t bytes) {
  constexpr std::size_t kFirstBytes = std::size_t{1} << 12;
  if (bytes > limit_bytes_ - size_) return false;
  const std::size_t needed = size_ + bytes;
  if (needed > out_.size())
    out_.resize(std::min(limit_bytes_, std::max({needed, 2 * out_.size(), kFirstBytes})));
  return true;
}

bool LzfDecoder::copy_back(std::size_t distance, std::size_t bytes) {
  if (distance > size_ || !make_room(bytes)) return false;
  const std::byte* from = out_.data() + (size_ - distance);
  std::byte* to = out_.data() + size_;
  if (distance >= bytes)
    std::memcpy(to, from, bytes);
  else
    for (std::size_t i = 0; i < bytes; ++i) to[i] = from[i];
  size_ += bytes;
  return true;
}

std::size_t LzfDecoder::decode(std::span<const std::byte> piece) {
  constexpr std::size_t kLiteralEnd = 32;
  constexpr std::size_t kLongCopy = 7;
  const auto at = [&](std::size_t i) { return std::to_integer<std::size_t>(piece[i]); };
  std::size_t used = 0;
  while (is_valid_ && used < piece.size()) {
    const std::size_t left = piece.size() - used;
    const std::size_t control = at(used);
    if (control < kLiteralEnd) {
      const std::size_t bytes = control + 1;
      if (left < 1 + bytes) break;
      is_valid_ = make_room(bytes);
      if (!is_valid_) break;
      std::memcpy(out_.data() + size_, piece.data() + used + 1, bytes);
      size_ += bytes;
      used += 1 + bytes;
      continue;
    }
    std::size_t length = control >> 5;
    const std::size_t instruction = length == kLongCopy ? 3 : 2;
    if (left < instruction) break;
    if (length == kLongCopy) length += at(used + 1);
    const std::size_t distance = ((control & 31) << 8) + at(used + instruction - 1) + 1;
    is_valid_ = copy_back(distance, length + 2);
    if (is_valid_) used += instruction;
  }
  return used;
}

std::vector<std::byte> LzfDecoder::take() {
  out_.resize(size_);
  size_ = 0;
  return std::exchange(out_, {});
}

}  // namespace orbweave
