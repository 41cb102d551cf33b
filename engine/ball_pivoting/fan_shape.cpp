#include "engine/ball_pivoting/fan_shape.h"

#include <algorithm>

namespace orbweave {

void FanFinder::find_followers(std::span<const VertexCorner> corners) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  follower_.assign(count, count);
  is_led_to_.assign(count, 0);
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::uint32_t k = 0; k < count; ++k) {
      if (first_of(corners[k].corner) != second_of(corners[i].corner)) continue;
      follower_[i] = k;
      is_led_to_[k] = 1;
      break;
    }
  }
}

/// Labels the fan that begins with a corner; returns its last corner.
std::uint32_t FanFinder::label_fan(std::span<const VertexCorner> corners, std::uint32_t begin) {
  ++shape_.fans;
  const auto count = static_cast<std::uint32_t>(corners.size());
  std::uint32_t label = first_of(corners[begin].corner), last = begin;
  for (std::uint32_t i = begin; i < count && is_seen_[i] == 0; i = follower_[i]) {
    is_seen_[i] = 1;
    label = std::min(label, first_of(corners[i].corner));
    last = i;
  }
  for (std::uint32_t i = begin;; i = follower_[i]) {
    shape_.label[i] = label;
    if (i == last) return last;
  }
}

const FanShape& FanFinder::shape_of(std::span<const VertexCorner> corners) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  find_followers(corners);
  shape_.fans = 0;
  shape_.open.clear();
  shape_.label.assign(count, 0);
  is_seen_.assign(count, 0);
  // Open fans begin at a corner that no other corner leads to; the remaining fans are cycles.
  for (std::uint32_t i = 0; i < count; ++i) {
    if (is_led_to_[i] != 0) continue;
    const std::uint32_t last = label_fan(corners, i);
    shape_.open.push_back(
        {second_of(corners[last].corner), corners[i].vertex, first_of(corners[i].corner)});
  }
  shape_.closed = count > 0 && shape_.fans == 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (is_seen_[i] == 0) label_fan(corners, i);
  }
  return shape_;
}

}  // namespace orbweave
