// Probabilities of symbols that follow the data, for the range coder of LAZ files.
//
// Source: Amir Said, Introduction to Arithmetic Coding, HPL-2004-76, with the constants of LASzip
// (docs/dev/laz.md). The format fixes when a model is refreshed and to which probabilities; how a
// symbol is found is ours.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace orbweave::laz {

/// Probability of a bit, in steps of 2^-13.
class AdaptiveBit {
 public:
  static constexpr unsigned kProbabilityBits = 13;

  void reset() { *this = AdaptiveBit(); }
  std::uint32_t zero_probability() const { return zero_probability_; }
  void count(bool bit) {
    zeros_ += bit ? 0 : 1;
    if (--left_ == 0) refresh();
  }

 private:
  void refresh() {
    constexpr std::uint32_t kMostCounted = 1U << kProbabilityBits;
    counted_ += cycle_;
    if (counted_ > kMostCounted) {
      counted_ = (counted_ + 1) / 2;
      zeros_ = (zeros_ + 1) / 2;
      if (zeros_ == counted_) ++counted_;
    }
    zero_probability_ = (zeros_ * (0x80000000U / counted_)) >> (31 - kProbabilityBits);
    cycle_ = cycle_ * 5 / 4 < 64 ? cycle_ * 5 / 4 : 64;
    left_ = cycle_;
  }

  std::uint32_t zeros_ = 1;
  std::uint32_t counted_ = 2;
  std::uint32_t zero_probability_ = 1U << (kProbabilityBits - 1);
  std::uint32_t cycle_ = 4;  ///< symbols from one refresh to the next
  std::uint32_t left_ = 4;   ///< symbols until the next
};

/// Probabilities of the symbols 0 to kSymbols - 1, in steps of 2^-15. Costs nothing until its
/// first use: a chunk that never needs a model does not pay for it.
template <unsigned kSymbols>
class AdaptiveModel {
 public:
  static constexpr unsigned kProbabilityBits = 15;

  void reset() { left_ = 0; }
  /// Before anything else of a symbol.
  void prepare() {
    if (left_ == 0) [[unlikely]]
      begin();
  }
  /// The symbol whose interval holds `target`, which may lie a little above 2^15.
  unsigned find(std::uint32_t target) const {
    unsigned symbol = cells_[target >> kCellShift];
    while (begins_[symbol + 1] <= target) ++symbol;
    return symbol;
  }
  /// Where the symbol's interval begins; that of the last one has no end here.
  std::uint32_t begin_of(unsigned symbol) const { return begins_[symbol]; }
  void count(unsigned symbol) {
    ++counts_[symbol];
    if (--left_ == 0) [[unlikely]]
      refresh();
  }

 private:
  // About two symbols a cell: what is left to search is short, and a refresh stays cheap.
  static constexpr unsigned kCellBits =
      kSymbols <= 16 ? 4U : static_cast<unsigned>(std::bit_width(kSymbols - 1)) - 1;
  static constexpr unsigned kCellShift = kProbabilityBits - kCellBits;
  static constexpr std::uint16_t kNeverReached = 0xffff;

  void begin() {
    counts_.fill(1);
    counted_ = kSymbols;
    spread();
    cycle_ = left_ = (kSymbols + 6) / 2;
  }

  void refresh() {
    constexpr std::uint32_t kMostCounted = 1U << kProbabilityBits;
    constexpr std::uint32_t kLongestCycle = (kSymbols + 6) * 8;
    counted_ += cycle_;
    if (counted_ > kMostCounted) {
      counted_ = 0;
      for (std::uint16_t& count : counts_) {
        count = static_cast<std::uint16_t>((count + 1) / 2);
        counted_ += count;
      }
    }
    spread();
    cycle_ = cycle_ * 5 / 4 < kLongestCycle ? cycle_ * 5 / 4 : kLongestCycle;
    left_ = cycle_;
  }

  /// Intervals from the counts. Every symbol keeps at least one step, as counted_ <= 2^15.
  void spread() {
    const std::uint32_t scale = 0x80000000U / counted_;
    std::uint32_t sum = 0;
    unsigned cell = 0;
    for (unsigned symbol = 0; symbol < kSymbols; ++symbol) {
      const std::uint32_t start = (scale * sum) >> (31 - kProbabilityBits);
      begins_[symbol] = static_cast<std::uint16_t>(start);
      sum += counts_[symbol];
      // The cells that begin before this symbol does belong to the one in front of it.
      for (; (cell << kCellShift) < start; ++cell)
        cells_[cell] = static_cast<std::uint16_t>(symbol - 1);
    }
    begins_[kSymbols] = kNeverReached;
    for (; cell < cells_.size(); ++cell) cells_[cell] = static_cast<std::uint16_t>(kSymbols - 1);
  }

  std::uint32_t left_ = 0;   ///< symbols until the next refresh; 0 before the first use
  std::uint32_t cycle_ = 0;  ///< symbols from one refresh to the next
  std::uint32_t counted_ = 0;
  std::array<std::uint16_t, kSymbols + 1> begins_{};
  /// The symbol at the beginning of each cell of 2^kCellShift steps, and one cell for what lies
  /// above 2^15.
  std::array<std::uint16_t, (1U << kCellBits) + 1> cells_{};
  std::array<std::uint16_t, kSymbols> counts_{};
};

/// Models of which few are used, such as one for every value of the point before.
template <unsigned kSymbols>
class ModelBank {
 public:
  explicit ModelBank(std::size_t models) : models_(models) {}
  AdaptiveModel<kSymbols>& operator[](std::size_t index) {
    if (!models_[index]) [[unlikely]]
      models_[index] = std::make_unique<AdaptiveModel<kSymbols>>();
    return *models_[index];
  }
  void reset() {
    for (auto& model : models_)
      if (model) model->reset();
  }

 private:
  std::vector<std::unique_ptr<AdaptiveModel<kSymbols>>> models_;
};

}  // namespace orbweave::laz
