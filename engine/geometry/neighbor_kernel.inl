// Nearest neighbours, four at once, for the machine that the including unit is compiled for. No
// unit of this file may use anything that is shared with units compiled for other machines.

#include "engine/geometry/lanes.h"
#include "engine/geometry/neighbor_kernel.h"

namespace orbweave {
namespace {

/// Values that are left to be sorted one by one.
constexpr std::uint32_t kFew = 4;
/// Steps of a search by interpolation, and of one by halves after that.
constexpr int kInterpolations = 6, kHalvings = 70;

/// How far a place is from an interval. Rounding keeps the order: never more than the computed
/// distance of a member.
inline Four gap(Four low, Four high, Four place) {
  return larger(larger(low - place, place - high), all(0.0));
}

std::uint32_t gather(const PositionColumns& positions, const BlockColumns& blocks,
                     const double place[3], std::uint32_t self, double limit, FoundColumns found) {
  const Four px = all(place[0]), py = all(place[1]), pz = all(place[2]), limit4 = all(limit);
  const std::uint32_t own_four = self & ~3u;
  const unsigned others = ~(1u << (self & 3u));
  std::uint32_t count = 0;
  for (std::uint32_t b = 0; b < blocks.count; b += 4) {
    const auto bound = [&](int column) { return load(blocks.bounds[column] + b); };
    const Four x = gap(bound(0), bound(3), px), y = gap(bound(1), bound(4), py),
               z = gap(bound(2), bound(5), pz);
    unsigned near = bits_of(x * x + y * y + z * z <= limit4);
    if (blocks.count - b < 4) near &= (1u << (blocks.count - b)) - 1u;
    for (; near != 0; near &= near - 1) {
      const std::uint32_t block = blocks.block[b + static_cast<std::uint32_t>(__builtin_ctz(near))];
      const auto part = [&](int column) { return load(positions.bounds[column] + 4 * block); };
      const Four part_x = gap(part(0), part(3), px), part_y = gap(part(1), part(4), py),
                 part_z = gap(part(2), part(5), pz);
      unsigned parts = bits_of(part_x * part_x + part_y * part_y + part_z * part_z <= limit4);
      for (; parts != 0; parts &= parts - 1) {
        const std::uint32_t first =
            block * kPointsPerBlock + 8 * static_cast<std::uint32_t>(__builtin_ctz(parts));
        for (std::uint32_t i = first; i < first + 8; i += 4) {
          const Four dx = load(positions.x + i) - px, dy = load(positions.y + i) - py,
                     dz = load(positions.z + i) - pz;
          const Four squared = dx * dx + dy * dy + dz * dz;
          unsigned bits = bits_of(squared <= limit4);
          bits &= i == own_four ? others : ~0u;
          const Packing packing(bits);
          packing.store(found.squared + count, squared);
          packing.store_numbers(found.index + count, i);
          count += count_of(bits);
        }
      }
    }
  }
  return count;
}

/// Values of at most `limit`. Those behind the last are no numbers.
inline std::uint32_t count_within(const double* values, std::uint32_t count, double limit) {
  const Four limit4 = all(limit);
  FourMask sum{0, 0, 0, 0};
  for (std::uint32_t i = 0; i < count; i += 4) sum -= load(values + i) <= limit4;
  return static_cast<std::uint32_t>(sum[0] + sum[1] + sum[2] + sum[3]);
}

/// Values above `low` and not above `high`, sorted, in the room at `to`.
std::uint32_t sorted_between(const double* values, std::uint32_t count, double low, double high,
                             double* to) {
  std::uint32_t found = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double value = values[i];
    if (!(value > low && value <= high)) continue;
    std::uint32_t at = found++;
    for (; at > 0 && value < to[at - 1]; --at) to[at] = to[at - 1];
    to[at] = value;
  }
  return found;
}

inline void take_within(FoundColumns from, std::uint32_t count, double limit, FoundColumns to) {
  std::uint32_t taken = 0;
  for (std::uint32_t i = 0; i < count; i += 4) {
    const Four squared = load(from.squared + i);
    const unsigned bits = bits_of(squared <= all(limit));
    const Packing packing(bits);
    packing.store(to.squared + taken, squared);
    packing.store_of(to.index + taken, from.index + i);
    taken += count_of(bits);
  }
}

/// Those below `limit`, and of those at it the first `at_limit`.
void take_first(FoundColumns from, std::uint32_t count, double limit, std::uint32_t at_limit,
                FoundColumns to) {
  std::uint32_t taken = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double squared = from.squared[i];
    if (squared > limit || (squared == limit && at_limit == 0)) continue;
    if (squared == limit) --at_limit;
    to.squared[taken] = squared;
    to.index[taken++] = from.index[i];
  }
}

double largest_of(const double* values, std::uint32_t count) {
  Four largest = all(0.0);
  for (std::uint32_t i = 0; i < count; i += 4) largest = larger(load(values + i), largest);
  double result = 0.0;
  for (int lane = 0; lane < 4; ++lane)
    if (largest[lane] > result) result = largest[lane];
  return result;
}

double select(FoundColumns from, std::uint32_t count, std::uint32_t wanted, FoundColumns to) {
  store(from.squared + count, all(__builtin_nan("")));
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
  double* const between = from.squared + count + 4;
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

constexpr NeighborKernel kKernel{gather, select};

}  // namespace
}  // namespace orbweave
