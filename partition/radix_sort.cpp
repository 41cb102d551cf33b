#include "partition/radix_sort.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <span>
#include <utility>

namespace orbweave {
namespace {

constexpr int kTopBits = 11;   // digit of the first pass, over the whole array
constexpr int kDigitBits = 8;  // digit of the passes inside a bucket, which fits the cache
constexpr std::size_t kSmall = 48;
/// Items that one thread counts and moves in the first pass: far more than there are digits.
constexpr std::size_t kSlice = std::size_t{1} << 17;

bool key_less(const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; }

void sort_small(std::span<KeyIndex> items) {
  if (items.size() > kSmall) {
    std::stable_sort(items.begin(), items.end(), key_less);
    return;
  }
  for (std::size_t i = 1; i < items.size(); ++i) {
    const KeyIndex item = items[i];
    std::size_t j = i;
    for (; j > 0 && item.key < items[j - 1].key; --j) items[j] = items[j - 1];
    items[j] = item;
  }
}

/// Sorts, stably, the runs that agree in all bits from `shift` upwards.
void finish_runs(std::span<KeyIndex> items, int shift) {
  for (std::size_t begin = 0; begin < items.size();) {
    std::size_t end = begin + 1;
    while (end < items.size() && (items[end].key >> shift) == (items[begin].key >> shift)) ++end;
    if (end - begin > 1) sort_small(items.subspan(begin, end - begin));
    begin = end;
  }
}

/// One stable counting pass on `bits` bits from `shift`.
void scatter(std::span<const KeyIndex> from, std::span<KeyIndex> to, int shift,
             std::span<std::uint32_t> count) {
  const std::uint64_t mask = count.size() - 1;
  std::fill(count.begin(), count.end(), 0);
  for (const KeyIndex& item : from) ++count[(item.key >> shift) & mask];
  std::uint32_t sum = 0;
  for (std::uint32_t& c : count) sum += std::exchange(c, sum);
  for (const KeyIndex& item : from) to[count[(item.key >> shift) & mask]++] = item;
}

/// Sorts a bucket whose keys differ in their lowest `bits` bits only; `spare` is of equal size.
void sort_bucket(std::span<KeyIndex> items, std::span<KeyIndex> spare, int bits) {
  if (items.size() <= kSmall || bits <= 0) return sort_small(items);
  // Points of a surface fill Morton space like the square fills the cube: telling n of them
  // apart takes about 3/2 log2 n leading bits. The rest is left to the comparison of few.
  const int wanted = 3 * static_cast<int>(std::bit_width(items.size())) / 2;
  int passes = (std::min(wanted, bits) + kDigitBits - 1) / kDigitBits;
  passes += passes % 2;  // an even number ends where it began
  const int lowest = std::max(0, bits - passes * kDigitBits);
  std::array<std::uint32_t, std::size_t{1} << kDigitBits> count;
  for (int pass = 0; pass < passes; pass += 2) {
    scatter(items, spare, std::min(lowest + pass * kDigitBits, 63), count);
    scatter(spare, items, std::min(lowest + (pass + 1) * kDigitBits, 63), count);
  }
  if (lowest > 0) finish_runs(items, lowest);
}

std::size_t slices_of(std::size_t items) { return (items + kSlice - 1) / kSlice; }

std::span<const KeyIndex> slice_of(std::span<const KeyIndex> items, std::size_t slice) {
  const std::size_t begin = slice * kSlice;
  return items.subspan(begin, std::min(kSlice, items.size() - begin));
}

/// How many of the lowest bits tell the keys apart.
int varying_bits(std::span<const KeyIndex> items) {
  std::vector<std::uint64_t> varying(slices_of(items.size()), 0);
  tbb::parallel_for(std::size_t{0}, varying.size(), [&](std::size_t slice) {
    std::uint64_t bits = 0;
    for (const KeyIndex& item : slice_of(items, slice)) bits |= item.key ^ items.front().key;
    varying[slice] = bits;
  });
  std::uint64_t all = 0;
  for (const std::uint64_t bits : varying) all |= bits;
  return static_cast<int>(std::bit_width(all));
}

/// One stable counting pass on the bits from `shift` to kTopBits above, slice beside slice.
/// Returns where the items of each digit end.
std::vector<std::uint32_t> scatter_in_slices(std::span<const KeyIndex> from, std::span<KeyIndex> to,
                                             int shift) {
  constexpr std::size_t kDigits = std::size_t{1} << kTopBits;
  constexpr std::uint64_t kMask = kDigits - 1;
  const std::size_t slices = slices_of(from.size());
  std::vector<std::uint32_t> places(slices * kDigits, 0);
  const auto places_of = [&](std::size_t slice) {
    return std::span(places).subspan(slice * kDigits, kDigits);
  };
  tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t slice) {
    const std::span<std::uint32_t> count = places_of(slice);
    for (const KeyIndex& item : slice_of(from, slice)) ++count[(item.key >> shift) & kMask];
  });
  std::vector<std::uint32_t> ends(kDigits);
  std::uint32_t sum = 0;
  for (std::size_t digit = 0; digit < kDigits; ++digit) {
    for (std::size_t slice = 0; slice < slices; ++slice)
      sum += std::exchange(places_of(slice)[digit], sum);
    ends[digit] = sum;
  }
  tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t slice) {
    const std::span<std::uint32_t> place = places_of(slice);
    for (const KeyIndex& item : slice_of(from, slice))
      to[place[(item.key >> shift) & kMask]++] = item;
  });
  return ends;
}

}  // namespace

void radix_sort(std::span<KeyIndex> items) {
  if (items.size() <= kSmall) return sort_small(items);
  const int bits = varying_bits(items);
  if (bits == 0) return;
  const int shift = std::max(0, bits - kTopBits);

  KeyList spare(items.size());
  const std::vector<std::uint32_t> ends = scatter_in_slices(items, spare, shift);
  tbb::parallel_for(std::size_t{0}, ends.size(), [&](std::size_t bucket) {
    const std::size_t begin = bucket == 0 ? 0 : ends[bucket - 1];
    const std::size_t size = ends[bucket] - begin;
    sort_bucket(std::span(spare).subspan(begin, size), items.subspan(begin, size), shift);
    std::copy_n(spare.begin() + static_cast<std::ptrdiff_t>(begin), size,
                items.begin() + static_cast<std::ptrdiff_t>(begin));
  });
}

std::vector<std::uint32_t> run_begins(std::span<const KeyIndex> items) {
  const auto begins_run = [&](std::size_t i) { return i == 0 || items[i].key != items[i - 1].key; };
  const auto visit = [&](std::size_t slice, const auto& use) {
    const std::size_t begin = slice * kSlice, end = std::min(items.size(), begin + kSlice);
    for (std::size_t i = begin; i < end; ++i)
      if (begins_run(i)) use(static_cast<std::uint32_t>(i));
  };
  const std::size_t slices = slices_of(items.size());
  std::vector<std::size_t> first(slices + 1, 0);
  tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t slice) {
    visit(slice, [&](std::uint32_t) { ++first[slice + 1]; });
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> begins(first.back() + 1);
  tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t slice) {
    std::size_t at = first[slice];
    visit(slice, [&](std::uint32_t i) { begins[at++] = i; });
  });
  begins.back() = static_cast<std::uint32_t>(items.size());
  return begins;
}

}  // namespace orbweave
