#include "engine/levels/listed_holes.h"

#include <algorithm>

namespace orbweave {
namespace {

constexpr std::size_t kListed = 300;

bool is_larger(const ListedHole& a, const ListedHole& b) {
  const double of_a = a.bounds.diagonal(), of_b = b.bounds.diagonal();
  return of_a != of_b ? of_a > of_b : a.hole < b.hole;
}

void keep_largest(std::vector<ListedHole>& holes) {
  std::stable_sort(holes.begin(), holes.end(), is_larger);
  if (holes.size() > kListed) holes.resize(kListed);
}

}  // namespace

void ListedHoles::add(const FacePatch& patch, const std::array<Vec3, 3>& corners) {
  if (patch.hole != current_.hole) {
    keep_current();
    current_ = {patch.hole, patch.confidence, 0, {}, {}};
  }
  if (patch.hole <= 0) return;
  current_.triangles += 1;
  for (const Vec3& corner : corners) current_.bounds.extend(corner);
  current_.area = current_.area + 0.5 * cross(corners[1] - corners[0], corners[2] - corners[0]);
}

void ListedHoles::keep_current() {
  if (current_.hole > 0) {
    kept_.push_back(current_);
    ++count_;
  }
  if (kept_.size() >= 2 * kListed) keep_largest(kept_);
}

std::vector<ListedHole> ListedHoles::largest() {
  keep_current();
  current_ = {};
  keep_largest(kept_);
  return kept_;
}

}  // namespace orbweave
