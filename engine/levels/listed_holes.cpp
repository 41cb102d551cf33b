#include "engine/levels/listed_holes.h"

#include <algorithm>
#include <cstddef>

namespace orbweave {
namespace {

constexpr std::size_t kListed = 300;

bool is_larger(const ListedHole& a, const ListedHole& b) {
  const double of_a = a.bounds.diagonal(), of_b = b.bounds.diagonal();
  return of_a != of_b ? of_a > of_b : a.hole < b.hole;
}

}  // namespace

void ListedHoles::add(const FacePatch& patch, const std::array<Vec3, 3>& corners) {
  if (patch.hole <= 0) return;
  if (last_ == nullptr || last_->hole != patch.hole) {
    const ListedHole first{patch.hole, patch.confidence, 0, {}, {}};
    last_ = &holes_.try_emplace(patch.hole, first).first->second;
  }
  last_->triangles += 1;
  for (const Vec3& corner : corners) last_->bounds.extend(corner);
  last_->area = last_->area + 0.5 * cross(corners[1] - corners[0], corners[2] - corners[0]);
}

std::vector<ListedHole> ListedHoles::largest() const {
  std::vector<ListedHole> listed;
  listed.reserve(holes_.size());
  for (const auto& [hole, facts] : holes_) listed.push_back(facts);
  const std::size_t kept = std::min(listed.size(), kListed);
  std::partial_sort(listed.begin(), listed.begin() + static_cast<std::ptrdiff_t>(kept),
                    listed.end(), is_larger);
  listed.resize(kept);
  return listed;
}

}  // namespace orbweave
