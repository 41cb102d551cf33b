// Some vertices of a mesh, and the number of each among them.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace orbweave {

/// A bit per vertex, and a count per 4096 of them.
class ChosenVertices {
 public:
  explicit ChosenVertices(std::uint64_t vertices)
      : bits_(vertices / 64 + 1, 0), before_(bits_.size() / kWords + 2, 0) {}

  void choose(std::uint64_t vertex) { bits_[vertex / 64] |= std::uint64_t{1} << (vertex % 64); }
  bool is_chosen(std::uint64_t vertex) const {
    return (bits_[vertex / 64] >> (vertex % 64) & 1) != 0;
  }
  /// Call once, after the last vertex is chosen.
  void number() {
    for (std::uint64_t word = 0; word < bits_.size(); ++word)
      before_[word / kWords + 1] += ones(bits_[word]);
    for (std::size_t block = 1; block < before_.size(); ++block)
      before_[block] += before_[block - 1];
  }
  std::uint64_t count() const { return before_.back(); }
  /// How many chosen vertices come before this one.
  std::uint64_t rank(std::uint64_t vertex) const {
    const std::uint64_t last = vertex / 64;
    std::uint64_t rank = before_[last / kWords];
    for (std::uint64_t word = last / kWords * kWords; word < last; ++word)
      rank += ones(bits_[word]);
    return rank + ones(bits_[last] & ((std::uint64_t{1} << (vertex % 64)) - 1));
  }

 private:
  static constexpr std::uint64_t kWords = 64;
  static std::uint64_t ones(std::uint64_t word) {
    return static_cast<std::uint64_t>(std::popcount(word));
  }

  std::vector<std::uint64_t> bits_;
  std::vector<std::uint64_t> before_;  ///< chosen vertices before each block, and all
};

}  // namespace orbweave
