// The other side of io/clouds/laz/range_decoder.h, written for clarity from the same sources and
// without sharing its models, so that the two check each other.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

namespace orbweave::test {

/// Adaptive symbol probabilities, by plain sums.
class SlowModel {
 public:
  explicit SlowModel(unsigned symbols);
  std::uint32_t begin_of(unsigned symbol) const { return begins_[symbol]; }
  bool is_last(unsigned symbol) const { return symbol + 1 == counts_.size(); }
  void count(unsigned symbol);

 private:
  void spread(std::uint32_t total);
  std::vector<std::uint32_t> counts_, begins_;
  std::uint32_t total_, cycle_, left_;
};

struct SlowBit {
  std::uint32_t zeros = 1, total = 2, probability = 4096, cycle = 4, left = 4;
  void count(bool bit);
};

/// Writes one coded stream.
class RangeEncoder {
 public:
  void symbol(SlowModel& model, unsigned symbol);
  void bit(SlowBit& model, bool bit);
  void bits(unsigned count, std::uint32_t number);
  void long_word(std::uint64_t number);
  /// The whole stream.
  std::vector<std::uint8_t> finish();

 private:
  void add(std::uint32_t to_base);
  void renormalize();
  std::uint32_t base_ = 0;
  std::uint32_t length_ = 0xffffffffU;
  std::vector<std::uint8_t> bytes_;
};

/// Integers of `bits` bits by their difference from a prediction.
class IntegerEncoder {
 public:
  explicit IntegerEncoder(unsigned bits) : bits_(bits) {}
  void encode(RangeEncoder& out, std::uint32_t predicted, std::uint32_t actual,
              unsigned context = 0);
  unsigned width() const { return width_; }

 private:
  unsigned bits_;
  unsigned width_ = 0;
  SlowBit zero_or_one_;
  std::map<unsigned, SlowModel> widths_, places_;
};

/// Models by context, made when first used.
class SlowModels {
 public:
  explicit SlowModels(unsigned symbols) : symbols_(symbols) {}
  SlowModel& operator[](unsigned context) {
    return models_.try_emplace(context, symbols_).first->second;
  }

 private:
  unsigned symbols_;
  std::map<unsigned, SlowModel> models_;
};

}  // namespace orbweave::test
