// Which points the mesh uses, and the number each of them gets in the output file.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace orbweave {

/// One bit per point and a running count per 512 points: 1.13 bits a point.
class UsedVertices {
 public:
  explicit UsedVertices(std::uint64_t points)
      : bits_((points + 63) / 64, 0), before_((points + 511) / 512 + 1, 0) {}

  /// Points `first`, first + 1, ... are used where fans is not 0.
  void mark(std::uint64_t first, std::span<const std::uint8_t> fans) {
    for (std::size_t i = 0; i < fans.size(); ++i) {
      if (fans[i] != 0) bits_[(first + i) / 64] |= std::uint64_t{1} << ((first + i) % 64);
    }
  }
  /// Call once, after the last mark.
  void number() {
    for (std::size_t block = 0; block + 1 < before_.size(); ++block) {
      std::uint64_t count = 0;
      for (std::size_t w = 8 * block; w < std::min(8 * block + 8, bits_.size()); ++w) {
        count += static_cast<std::uint64_t>(std::popcount(bits_[w]));
      }
      before_[block + 1] = before_[block] + count;
    }
  }
  bool used(std::uint64_t point) const { return (bits_[point / 64] >> (point % 64) & 1) != 0; }
  std::uint64_t count() const { return before_.back(); }
  /// How many used points come before this one.
  std::uint64_t rank(std::uint64_t point) const {
    std::uint64_t rank = before_[point / 512];
    for (std::uint64_t w = point / 512 * 8; w < point / 64; ++w) {
      rank += static_cast<std::uint64_t>(std::popcount(bits_[w]));
    }
    const std::uint64_t below = (std::uint64_t{1} << (point % 64)) - 1;
    return rank + static_cast<std::uint64_t>(std::popcount(bits_[point / 64] & below));
  }

 private:
  std::vector<std::uint64_t> bits_;
  std::vector<std::uint64_t> before_;
};

}  // namespace orbweave
