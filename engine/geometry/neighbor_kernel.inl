// Nearest neighbours, a vector at once, for the machine that the including unit is compiled for. No
// unit of this file may use anything that is shared with units compiled for other machines.

#include "engine/geometry/neighbor_kernel.h"
#include "engine/geometry/simd.h"

namespace orbweave {
namespace {

/// Values that are left to be sorted one by one.
constexpr std::uint32_t kFew = 4;
/// Steps of a search by interpolation, and of one by halves after that.
constexpr int kInterpolations = 6, kHalvings = 70;
constexpr std::uint32_t kWidth = Lanes::kWidth;

struct Point {
  Lanes x, y, z;
};
inline Point load(const double* x, const double* y, const double* z) {
  return {Lanes::load(x), Lanes::load(y), Lanes::load(z)};
}
inline Lanes squared(Lanes x, Lanes y, Lanes z) { return x * x + y * y + z * z; }

/// How far a place is from an interval. Rounding keeps the order: never more than the computed
/// distance of a member.
inline Lanes gap(const double* low, const double* high, Lanes place) {
  return larger(larger(Lanes::load(low) - place, place - Lanes::load(high)), Lanes::all(0.0));
}
/// How far intervals are from another.
inline Lanes gap(const double* low, const double* high, Lanes from, Lanes to) {
  return larger(larger(Lanes::load(low) - to, from - Lanes::load(high)), Lanes::all(0.0));
}

/// Boxes from `first` on within `limit` of a place.
inline Lanes::Mask boxes_near(const double* const bounds[6], std::size_t first, Point place,
                              Lanes limit) {
  return squared(gap(bounds[0] + first, bounds[3] + first, place.x),
                 gap(bounds[1] + first, bounds[4] + first, place.y),
                 gap(bounds[2] + first, bounds[5] + first, place.z)) <= limit;
}

/// Which of the first `count` of the boxes from `first` on are near, a bit for each.
inline unsigned bits_near(const double* const bounds[6], std::size_t first, std::uint32_t count,
                          Point place, Lanes limit) {
  unsigned bits = 0;
  for (std::uint32_t k = 0; k < count; k += kWidth)
    bits |= bits_of(boxes_near(bounds, first + k, place, limit)) << k;
  return bits & ((1u << count) - 1u);
}

std::uint32_t gather(const PositionColumns& positions, const BlockColumns& blocks,
                     const double place[3], std::uint32_t self, double limit, FoundColumns found) {
  constexpr std::uint32_t kPart = kPointsPerBlock / kPartsPerBlock;
  const Point p{Lanes::all(place[0]), Lanes::all(place[1]), Lanes::all(place[2])};
  const Lanes within = Lanes::all(limit);
  std::uint32_t number = 0;
  const auto take_part = [&](std::uint32_t first) {
    for (std::uint32_t i = first; i < first + kPart; i += kWidth) {
      const Point other = load(positions.x + i, positions.y + i, positions.z + i);
      const Lanes distance = squared(other.x - p.x, other.y - p.y, other.z - p.z);
      Lanes::Mask near = distance <= within;
      if (self - i < kWidth) near = but_not(near, lane_mask(self - i));
      compress_store(found.squared + number, distance, near);
      compress_store_indices(found.index + number, i, near);
      number += count(near);
    }
  };
  for (std::uint32_t b = 0; b < blocks.count; b += kBoxesAtOnce) {
    const std::uint32_t left = blocks.count - b;
    unsigned near =
        bits_near(blocks.bounds, b, left < kBoxesAtOnce ? left : kBoxesAtOnce, p, within);
    for (; near != 0; near &= near - 1) {
      const std::uint32_t block = blocks.block[b + static_cast<std::uint32_t>(__builtin_ctz(near))];
      if constexpr (kWidth == kPart) {
        for (std::uint32_t part = 0; part < kPartsPerBlock; ++part)
          take_part(block * kPointsPerBlock + kPart * part);
        continue;
      }
      unsigned parts = bits_near(positions.bounds, kPartsPerBlock * std::size_t{block},
                                 kPartsPerBlock, p, within);
      for (; parts != 0; parts &= parts - 1)
        take_part(block * kPointsPerBlock +
                  kPart * static_cast<std::uint32_t>(__builtin_ctz(parts)));
    }
  }
  return number;
}

unsigned near_boxes(const double* const bounds[6], std::size_t first, const double low[3],
                    const double high[3], double limit) {
  const Lanes from[3] = {Lanes::all(low[0]), Lanes::all(low[1]), Lanes::all(low[2])};
  const Lanes to[3] = {Lanes::all(high[0]), Lanes::all(high[1]), Lanes::all(high[2])};
  const auto apart = [&](int axis, std::size_t k) {
    return gap(bounds[axis] + k, bounds[axis + 3] + k, from[axis], to[axis]);
  };
  unsigned bits = 0;
  for (std::uint32_t k = 0; k < kBoxesAtOnce; k += kWidth) {
    const Lanes distance = squared(apart(0, first + k), apart(1, first + k), apart(2, first + k));
    bits |= bits_of(distance <= Lanes::all(limit)) << k;
  }
  return bits;
}

/// Values of at most `limit`. Those behind the last are no numbers.
inline std::uint32_t count_within(const double* values, std::uint32_t size, double limit) {
  std::uint32_t within = 0;
  for (std::uint32_t i = 0; i < size; i += kWidth)
    within += count(Lanes::load(values + i) <= Lanes::all(limit));
  return within;
}

/// Values above `low` and not above `high`, sorted, in the room at `to`.
std::uint32_t sorted_between(const double* values, std::uint32_t size, double low, double high,
                             double* to) {
  std::uint32_t found = 0;
  for (std::uint32_t i = 0; i < size; i += kWidth) {
    const Lanes value = Lanes::load(values + i);
    const Lanes::Mask between = both(Lanes::all(low) < value, value <= Lanes::all(high));
    compress_store(to + found, value, between);
    found += count(between);
  }
  for (std::uint32_t i = 1; i < found; ++i) {
    const double value = to[i];
    std::uint32_t at = i;
    for (; at > 0 && value < to[at - 1]; --at) to[at] = to[at - 1];
    to[at] = value;
  }
  return found;
}

inline void take_within(FoundColumns from, std::uint32_t size, double limit, FoundColumns to) {
  std::uint32_t taken = 0;
  for (std::uint32_t i = 0; i < size; i += kWidth) {
    const Lanes distance = Lanes::load(from.squared + i);
    const Lanes::Mask within = distance <= Lanes::all(limit);
    compress_store(to.squared + taken, distance, within);
    compress_store_numbers(to.index + taken, from.index + i, within);
    taken += count(within);
  }
}

/// Those below `limit`, and of those at it the first `at_limit`.
void take_first(FoundColumns from, std::uint32_t size, double limit, std::uint32_t at_limit,
                FoundColumns to) {
  std::uint32_t taken = 0;
  for (std::uint32_t i = 0; i < size; ++i) {
    const double distance = from.squared[i];
    if (distance > limit || (distance == limit && at_limit == 0)) continue;
    if (distance == limit) --at_limit;
    to.squared[taken] = distance;
    to.index[taken++] = from.index[i];
  }
}

/// Of values that are not negative; those behind the last are no numbers.
double largest_of(const double* values, std::uint32_t size) {
  Lanes most = Lanes::all(0.0);
  for (std::uint32_t i = 0; i < size; i += kWidth) most = larger(Lanes::load(values + i), most);
  return largest(most);
}

double select(FoundColumns from, std::uint32_t count, std::uint32_t wanted, FoundColumns to) {
  Lanes::all(__builtin_nan("")).store(from.squared + count);
  // Within low lie `few`, fewer than wanted; within high lie `many`, more than that. Squared
  // distances on a surface are about evenly spread.
  double low = -1.0, high = largest_of(from.squared, count);
  std::uint32_t few = 0, many = count;
  for (int step = 0; many - few > kFew && step < kInterpolations + kHalvings; ++step) {
    const double share = step < kInterpolations
                             ? static_cast<double>(wanted - few) / static_cast<double>(many - few)
                             : 0.5;
    const double from_low = low < 0.0 ? 0.0 : low;
    const double middle = from_low + share * (high - from_low);
    if (!(middle > low && middle < high)) break;
    const std::uint32_t within = count_within(from.squared, count, middle);
    if (within == wanted) {
      take_within(from, count, middle, to);
      return middle;
    }
    if (within < wanted) {
      low = middle;
      few = within;
    } else {
      high = middle;
      many = within;
    }
  }
  double* const between = from.squared + count + kWidth;
  const std::uint32_t found = sorted_between(from.squared, count, low, high, between);
  const double last = between[wanted - few - 1];
  std::uint32_t below = few, at = 0;
  for (std::uint32_t i = 0; i < found; ++i) {
    below += between[i] < last;
    at += between[i] == last;
  }
  if (below + at == wanted) {
    take_within(from, count, last, to);
  } else {
    take_first(from, count, last, wanted - below, to);
  }
  return last;
}

constexpr NeighborKernel kKernel{gather, select, near_boxes};

}  // namespace
}  // namespace orbweave
