// A set of numbers of vertices that lie in groups, and the rank of each.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <vector>

namespace orbweave {

/// A bit for each number, in blocks that are there where a number is: less than two bits for each
/// number from the lowest to the highest. For one thread: looking up keeps what was found.
class NumberSet {
 public:
  void add(std::uint64_t number) {
    constexpr std::uint64_t kOne = 1;
    block_of(number / kBlock).words[number % kBlock / kWord] |= kOne << (number % kWord);
  }
  /// After the last number, before the first rank.
  void count_up() {
    for (auto& [index, block] : blocks_) {
      block.before = count_;
      std::uint16_t in_block = 0;
      for (std::size_t word = 0; word < block.words.size(); ++word) {
        block.below[word] = in_block;
        in_block = static_cast<std::uint16_t>(in_block + std::popcount(block.words[word]));
      }
      count_ += in_block;
    }
  }
  std::uint64_t count() const { return count_; }
  /// How many numbers of the set are below this one, which is in the set.
  std::uint64_t rank(std::uint64_t number) {
    constexpr std::uint64_t kOne = 1;
    const Block& block = block_of(number / kBlock);
    const std::uint64_t word = number % kBlock / kWord;
    const std::uint64_t below = block.words[word] & ((kOne << (number % kWord)) - 1);
    return block.before + block.below[word] + static_cast<std::uint64_t>(std::popcount(below));
  }
  /// take(numbers): all numbers, ascending, those of a block at a time.
  template <class Take>
  void for_blocks(const Take& take) const {
    std::vector<std::uint64_t> numbers;
    for (const auto& [index, block] : blocks_) {
      numbers.clear();
      for (std::uint64_t word = 0; word < block.words.size(); ++word)
        for (std::uint64_t left = block.words[word]; left != 0; left &= left - 1)
          numbers.push_back(index * kBlock + word * kWord +
                            static_cast<std::uint64_t>(std::countr_zero(left)));
      take(numbers);
    }
  }

 private:
  static constexpr std::uint64_t kBlock = 4096;
  static constexpr std::uint64_t kWord = 64;
  struct Block {
    std::array<std::uint64_t, kBlock / kWord> words{};
    std::array<std::uint16_t, kBlock / kWord> below{};  ///< numbers in the words before
    std::uint64_t before = 0;                           ///< numbers in the blocks before
  };
  struct Recent {
    std::uint64_t index = 0;
    Block* block = nullptr;
  };

  Block& block_of(std::uint64_t index) {
    Recent& recent = recent_[index % recent_.size()];
    if (recent.block == nullptr || recent.index != index) recent = {index, &blocks_[index]};
    return *recent.block;
  }

  std::map<std::uint64_t, Block> blocks_;
  std::array<Recent, 16> recent_;
  std::uint64_t count_ = 0;
};

}  // namespace orbweave
