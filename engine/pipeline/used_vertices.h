// Which points the mesh uses, and the number each of them gets in the output file.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace orbweave {

/// One bit per point and a running count per 64 points: two bits a point.
class UsedVertices {
 public:
  explicit UsedVertices(std::uint64_t points)
      : bits_(points / 64 + 1, 0), before_(bits_.size() + 1, 0) {}

  /// Points `first`, first + 1, ... are used where fans is not 0.
  void mark(std::uint64_t first, std::span<const std::uint8_t> fans) {
    for (std::size_t i = 0; i < fans.size(); ++i) {
      if (fans[i] != 0) bits_[(first + i) / 64] |= std::uint64_t{1} << ((first + i) % 64);
    }
  }
  /// The point is not used after all.
  void unmark(std::uint64_t point) { bits_[point / 64] &= ~(std::uint64_t{1} << (point % 64)); }
  /// Call once, after the last mark.
  void number() {
    for (std::size_t word = 0; word < bits_.size(); ++word) {
      before_[word + 1] = before_[word] + ones(bits_[word]);
    }
  }
  bool used(std::uint64_t point) const { return (bits_[point / 64] >> (point % 64) & 1) != 0; }
  std::uint64_t count() const { return before_.back(); }
  /// How many used points come before this one; `point` may be one past the last.
  std::uint64_t rank(std::uint64_t point) const {
    const std::uint64_t below = (std::uint64_t{1} << (point % 64)) - 1;
    const std::uint64_t word = bits_[point / 64] & below;
    // On most surfaces nearly every point is used: then there is nothing to count.
    return before_[point / 64] + (word == below ? point % 64 : ones(word));
  }

 private:
  static std::uint64_t ones(std::uint64_t word) {
    return static_cast<std::uint64_t>(std::popcount(word));
  }

  std::vector<std::uint64_t> bits_;
  std::vector<std::uint64_t> before_;
};

}  // namespace orbweave
