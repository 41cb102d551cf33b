#include "engine/holes/patched_surface.h"

#include <algorithm>

namespace orbweave {
namespace {

constexpr int kPatchShift = 32;

std::uint32_t patch_of_vertex(std::uint64_t vertex) {
  return static_cast<std::uint32_t>((vertex - kNewVertex) >> kPatchShift);
}

std::size_t place_of_vertex(std::uint64_t vertex) {
  return static_cast<std::size_t>(vertex & 0xffffffffu);
}

}  // namespace

PatchedSurface::PatchedSurface(const FilledSurface& filled)
    : filled_(filled), loops_(static_cast<std::uint32_t>(filled.loops.size())) {
  for (std::uint32_t l = 0; l < loops_; ++l) {
    for (const std::uint64_t vertex : filled.loops[l].vertices) visits_.emplace_back(vertex, l);
    is_there_.push_back(filled.boxes[l].empty() ? 0 : 1);
    if (patch_of_loop(l) != l) joined_.emplace_back(patch_of_loop(l), l);
  }
  std::sort(visits_.begin(), visits_.end());
  visits_.erase(std::unique(visits_.begin(), visits_.end()), visits_.end());
  std::sort(joined_.begin(), joined_.end());
}

Vec3 PatchedSurface::position(std::uint64_t vertex) const {
  if (vertex < kNewVertex) return filled_.scanned.position(vertex);
  return known(patch_of_vertex(vertex)).patch.positions[place_of_vertex(vertex)];
}

std::vector<double> PatchedSurface::values(std::span<const std::uint64_t> vertices) const {
  const auto first_new = std::lower_bound(vertices.begin(), vertices.end(), kNewVertex);
  const auto scanned = static_cast<std::size_t>(first_new - vertices.begin());
  std::vector<double> values = filled_.scanned.values(vertices.first(scanned));
  for (const std::uint64_t vertex : vertices.subspan(scanned)) {
    const std::vector<double>& of_patch = known(patch_of_vertex(vertex)).patch.values;
    const auto row =
        of_patch.begin() + static_cast<std::ptrdiff_t>(place_of_vertex(vertex) * channels());
    values.insert(values.end(), row, row + channels());
  }
  return values;
}

void PatchedSurface::triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const {
  for (const OwnedTriangle& t : owned_at(vertex)) out.push_back(t.corners);
}

std::vector<OwnedTriangle> PatchedSurface::owned_at(std::uint64_t vertex) const {
  std::vector<OwnedTriangle> found;
  if (vertex >= kNewVertex) {
    add_of_patch(patch_of_vertex(vertex), vertex, found);
  } else {
    std::vector<Triangle64> scanned;
    filled_.scanned.triangles_at(vertex, scanned);
    for (const Triangle64& t : scanned)
      if (!taken_.contains(t)) found.push_back({t, OwnedTriangle::kScanned});
    std::vector<std::uint32_t> patches;
    for (const std::uint32_t loop : loops_at(vertex)) patches.push_back(patch_of_loop(loop));
    std::sort(patches.begin(), patches.end());
    patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
    for (auto [at, end] = added_at_.equal_range(vertex); at != end; ++at)
      patches.push_back(at->second);
    for (const std::uint32_t patch : patches) add_of_patch(patch, vertex, found);
  }
  std::sort(found.begin(), found.end());
  return found;
}

void PatchedSurface::add_of_patch(std::uint32_t patch, std::uint64_t vertex,
                                  std::vector<OwnedTriangle>& out) const {
  if (!has_patch(patch)) return;
  const auto& at = known(patch).at;
  for (auto entry = std::lower_bound(at.begin(), at.end(), std::pair{vertex, Triangle64{}});
       entry != at.end() && entry->first == vertex; ++entry)
    out.push_back({entry->second, patch});
}

std::optional<OwnedTriangle> PatchedSurface::along(std::uint64_t tail, std::uint64_t head) const {
  for (const OwnedTriangle& t : owned_at(tail))
    for (int k = 0; k < 3; ++k)
      if (t.corners[k] == tail && t.corners[(k + 1) % 3] == head) return t;
  return std::nullopt;
}

Box PatchedSurface::box_of(const Triangle64& t) const {
  Box box;
  for (const std::uint64_t vertex : t) box.extend(position(vertex));
  return box;
}

const Box& PatchedSurface::box_of_patch(std::uint32_t patch) const {
  return patch < loops_ ? filled_.boxes[patch] : added_boxes_[patch - loops_];
}

std::vector<OwnedTriangle> PatchedSurface::near(const Box& box) const {
  std::vector<Triangle64> scanned;
  filled_.scanned_near(box, scanned);
  std::vector<OwnedTriangle> found;
  for (const Triangle64& t : scanned)
    if (!taken_.contains(t) && box_of(t).intersects(box))
      found.push_back({t, OwnedTriangle::kScanned});
  for (std::uint32_t patch = 0; patch < patches(); ++patch) {
    if (!has_patch(patch) || !box_of_patch(patch).intersects(box)) continue;
    for (const OwnedTriangle& t : triangles_of(patch))
      if (box_of(t.corners).intersects(box)) found.push_back(t);
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<OwnedTriangle> PatchedSurface::triangles_of(std::uint32_t patch) const {
  std::vector<OwnedTriangle> triangles;
  for (const auto& [vertex, t] : known(patch).at)
    if (vertex == t[0]) triangles.push_back({t, patch});
  return triangles;
}

std::uint32_t PatchedSurface::patch_of_loop(std::uint32_t loop) const {
  const HoleFacts& hole = filled_.holes[loop];
  if (hole.joined_to == 0) return loop;
  return static_cast<std::uint32_t>(hole.joined_to - filled_.first_id);
}

std::vector<std::uint32_t> PatchedSurface::loops_of_patch(std::uint32_t patch) const {
  std::vector<std::uint32_t> loops = {patch};
  for (auto at = std::lower_bound(joined_.begin(), joined_.end(), std::pair{patch, 0u});
       at != joined_.end() && at->first == patch; ++at)
    loops.push_back(at->second);
  return loops;
}

bool PatchedSurface::may_be_filled(std::uint32_t patch) const {
  const std::vector<std::uint32_t> loops = loops_of_patch(patch);
  return std::all_of(loops.begin(), loops.end(),
                     [&](std::uint32_t loop) { return filled_.is_wanted[loop] != 0; });
}

std::vector<std::uint32_t> PatchedSurface::loops_at(std::uint64_t vertex) const {
  std::vector<std::uint32_t> loops;
  for (auto at = std::lower_bound(visits_.begin(), visits_.end(), std::pair{vertex, 0u});
       at != visits_.end() && at->first == vertex; ++at)
    loops.push_back(at->second);
  return loops;
}

PatchedSurface::Known PatchedSurface::known_of(LoopPatch patch, std::uint32_t number) const {
  Known known;
  const std::uint64_t first = std::uint64_t{number} << kPatchShift;
  for (Triangle64 t : patch.triangles) {
    for (std::uint64_t& vertex : t) vertex += vertex >= kNewVertex ? first : 0;
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    for (const std::uint64_t vertex : t) known.at.emplace_back(vertex, t);
  }
  std::sort(known.at.begin(), known.at.end());
  known.patch = std::move(patch);
  return known;
}

const PatchedSurface::Known& PatchedSurface::known(std::uint32_t patch) const {
  const auto found = known_.find(patch);
  if (found != known_.end()) return found->second;
  LoopPatch given = patch < loops_ ? filled_.patch_of(patch) : added_[patch - loops_];
  return known_.emplace(patch, known_of(std::move(given), patch)).first->second;
}

std::uint32_t PatchedSurface::add(LoopPatch patch, std::span<const std::uint64_t> rim) {
  const std::uint32_t number = patches();
  for (const std::uint64_t vertex : rim) added_at_.emplace(vertex, number);
  added_rims_.emplace_back(rim.begin(), rim.end());
  added_.push_back(std::move(patch));
  is_there_.push_back(1);
  Box box;
  for (const auto& [vertex, t] : known(number).at) box.extend(position(vertex));
  added_boxes_.push_back(box);
  return number;
}

void PatchedSurface::remove_last() {
  const std::uint32_t number = patches() - 1;
  for (const std::uint64_t vertex : added_rims_.back()) {
    for (auto [at, end] = added_at_.equal_range(vertex); at != end;)
      at = at->second == number ? added_at_.erase(at) : std::next(at);
  }
  known_.erase(number);
  added_rims_.pop_back();
  added_boxes_.pop_back();
  added_.pop_back();
  is_there_.pop_back();
}

}  // namespace orbweave
