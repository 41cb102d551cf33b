#include "tests/io/laz_records.h"

#include <algorithm>
#include <array>
#include <random>

namespace orbweave::test {
namespace {

template <class T>
void put(std::uint8_t* at, T value) {
  std::vector<std::uint8_t> bytes;
  append(bytes, value);
  std::copy(bytes.begin(), bytes.end(), at);
}

/// Moves the point on; `at` holds the one before.
class Scanner {
 public:
  Scanner(const LazOptions& options, std::uint64_t seed) : options_(options), random_(seed) {}

  void step(std::uint8_t* at) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      put(at + 4 * axis, static_cast<std::uint32_t>(take<std::uint32_t>(at + 4 * axis) +
                                                    random_() % 41 + axis * 7 - 20));
    const bool layered = options_.point_format >= 6;
    step_returns(at + 14, layered);
    if (random_() % 3 == 0) put(at + 12, static_cast<std::uint16_t>(random_() % 300));
    if (layered && random_() % 16 == 0) at[15] = static_cast<std::uint8_t>(random_());
    const std::size_t time = layered ? 22 : 20;
    if (layered || options_.point_format == 1 || options_.point_format >= 3) step_time(at + time);
    const std::size_t rest = layered ? 30 : options_.point_format % 2 == 1 ? 28 : 20;
    for (std::size_t i = 14; i < record_bytes(options_); ++i) {
      const bool clock = i >= time && i < time + 8;
      if (!clock && random_() % 64 == 0) at[i] = static_cast<std::uint8_t>(random_());
      if (i >= rest && random_() % 4 == 0) ++at[i];
    }
    if (random_() % 100 == 0)
      for (std::size_t i = 0; i < 14; ++i) at[i] = static_cast<std::uint8_t>(random_());
  }

 private:
  void step_returns(std::uint8_t* at, bool layered) {
    const unsigned bits = layered ? 4 : 3;
    const unsigned mask = (1U << bits) - 1;
    unsigned r = *at & mask;
    unsigned n = *at >> bits & mask;
    if (++r > n) {
      r = 1;
      n = 1 + static_cast<unsigned>(random_() % 3);
    }
    *at = static_cast<std::uint8_t>(r | n << bits | (layered ? 0U : *at & 0xc0U));
  }

  void step_time(std::uint8_t* at) {
    constexpr std::array<std::uint64_t, 10> kSteps{1, 1, 1, 2, 12, 499, 700, 0, ~0ULL, 1ULL - 12};
    const std::uint64_t kind = random_() % 20;
    std::uint64_t& clock = clocks_[clock_];
    if (kind < 12) clock += 1000 * kSteps[kind % kSteps.size()] + random_() % 3;
    if (kind == 12) clock_ = random_() % clocks_.size();
    if (kind == 13 && random_() % 8 == 0) clock = random_();
    put(at, clocks_[clock_]);
  }

  const LazOptions& options_;
  std::mt19937_64 random_;
  std::array<std::uint64_t, 4> clocks_{0x4100000000000000, 0x4200000000000000, 0x4300000000000000,
                                       0x4400000000000000};
  std::size_t clock_ = 0;
};

}  // namespace

std::vector<std::uint8_t> random_records(const LazOptions& options, std::size_t points,
                                         std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::uint8_t> records(points * record_bytes(options));
  for (auto& byte : records) byte = static_cast<std::uint8_t>(random());
  return records;
}

std::vector<std::uint8_t> scan_records(const LazOptions& options, std::size_t points,
                                       std::uint64_t seed) {
  const std::size_t size = record_bytes(options);
  std::vector<std::uint8_t> records;
  std::vector<std::uint8_t> point(size);
  Scanner scanner(options, seed);
  for (std::size_t i = 0; i < points; ++i) {
    scanner.step(point.data());
    records.insert(records.end(), point.begin(), point.end());
  }
  return records;
}

}  // namespace orbweave::test
