#include "io/store/packed_blocks.h"

#include <zlib.h>

#include <new>

namespace orbweave {
namespace {

/// The fastest: what higher levels save is a few percent, and they take twice the time and more.
constexpr int kLevel = 1;

}  // namespace

std::size_t most_packed_bytes(std::size_t padded_bytes) { return compressBound(padded_bytes); }

std::vector<std::byte> pack_block(std::span<const std::byte> rows, std::size_t number_bytes,
                                  std::size_t padded_bytes) {
  std::vector<std::byte> shuffled(padded_bytes);
  const std::size_t numbers = padded_bytes / number_bytes;
  const std::size_t given = rows.size() / number_bytes;
  for (std::size_t place = 0; place < number_bytes; ++place) {
    std::byte* const to = shuffled.data() + place * numbers;
    const std::byte* const from = rows.data() + place;
    for (std::size_t i = 0; i < given; ++i) to[i] = from[i * number_bytes];
  }
  uLongf size = compressBound(padded_bytes);
  std::vector<std::byte> packed(size);
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(shuffled.data()), padded_bytes, kLevel) != Z_OK)
    throw std::bad_alloc();
  packed.resize(size);
  packed.shrink_to_fit();
  return packed;
}

bool unpack_block(std::span<const std::byte> packed, std::size_t number_bytes,
                  std::size_t padded_bytes, std::span<std::byte> rows) {
  std::vector<std::byte> shuffled(padded_bytes);
  uLongf size = padded_bytes;
  if (uncompress(reinterpret_cast<Bytef*>(shuffled.data()), &size,
                 reinterpret_cast<const Bytef*>(packed.data()), packed.size()) != Z_OK ||
      size != padded_bytes)
    return false;
  const std::size_t numbers = padded_bytes / number_bytes;
  const std::size_t wanted = rows.size() / number_bytes;
  for (std::size_t place = 0; place < number_bytes; ++place) {
    const std::byte* const from = shuffled.data() + place * numbers;
    std::byte* const to = rows.data() + place;
    for (std::size_t i = 0; i < wanted; ++i) to[i * number_bytes] = from[i];
  }
  return true;
}

}  // namespace orbweave
