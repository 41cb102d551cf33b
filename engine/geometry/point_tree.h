// Nearest points of a cloud in core.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "io/vec3.h"

namespace orbweave {

struct Neighbor {
  double squared_distance = 0.0;
  std::uint32_t index = 0;
  friend bool operator==(const Neighbor&, const Neighbor&) = default;
};

/// The order of neighbours, by distance and index. An object, not a function, so that sorting
/// compares without a call. No branch between the two parts: the processor would foresee it wrong
/// half of the time.
inline constexpr auto kNearerFirst = [](const Neighbor& a, const Neighbor& b) {
  return static_cast<bool>(static_cast<int>(a.squared_distance < b.squared_distance) |
                           (static_cast<int>(a.squared_distance == b.squared_distance) &
                            static_cast<int>(a.index < b.index)));
};

/// A k-d tree over positions, which must outlive it and be finite. Fewer than 2^32 points.
/// Results are exact to rounding; equally near points come in order of index, so they do not depend
/// on the tree. Safe for queries from many threads. For a few dozen neighbours: each is put in its
/// place among those found.
class PointTree {
 public:
  explicit PointTree(std::span<const Vec3> positions);
  ~PointTree();
  PointTree(PointTree&&) noexcept;
  PointTree& operator=(PointTree&&) noexcept;

  /// The `count` nearest positions (fewer in smaller sets), nearest first. A query
  /// that is itself one of the positions finds itself, and its exact duplicates, at distance 0.
  void nearest(Vec3 query, std::size_t count, std::vector<Neighbor>& found) const;
  /// The nearest position. Precondition: there is one.
  Neighbor nearest(Vec3 query) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
