// Memory for the walks of one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/ball_pivoting/walk.h"

namespace orbweave {

/// Working arrays of the walks that go on at once; they grow to the largest neighbourhood met.
class ScratchSpace {
 public:
  bool is_too_small(std::uint32_t candidates) const { return candidates > capacity_; }
  /// What the arrays hold is lost.
  void grow(std::uint32_t candidates) {
    capacity_ = candidates + candidates / 2 + 64;
    const std::size_t room = capacity_ + kLanePadding;
    doubles_.assign(kWalksAtOnce * 7 * room, 0.0);
    ids_.assign(kWalksAtOnce * 2 * room, 0);
    corners_.assign(kWalksAtOnce * std::size_t{corner_bound(capacity_)}, 0);
    double* at = doubles_.data();
    for (std::uint32_t w = 0; w < kWalksAtOnce; ++w) {
      WalkScratch& s = scratch_[w];
      Neighbours& list = s.neighbours;
      for (double** array : {&list.dx, &list.dy, &list.dz, &list.cap_height, &list.inverse_length,
                             &s.arc_begin, &s.arc_length}) {
        *array = at;
        at += room;
      }
      list.id = ids_.data() + 2 * w * room;
      s.list = list.id + room;
      fans_[w].corners = corners_.data() + w * std::size_t{corner_bound(capacity_)};
    }
  }
  WalkScratch* arrays() { return scratch_; }
  Fan* fans() { return fans_; }

 private:
  std::uint32_t capacity_ = 0;
  std::vector<double> doubles_;
  std::vector<std::uint32_t> ids_;
  std::vector<Corner> corners_;
  WalkScratch scratch_[kWalksAtOnce];
  Fan fans_[kWalksAtOnce];
};

}  // namespace orbweave
