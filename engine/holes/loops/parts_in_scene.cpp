#include "engine/holes/loops/parts_in_scene.h"

#include <utility>

#include "engine/holes/loops/loop_parts.h"
#include "engine/holes/patch/crease.h"
#include "engine/holes/patch/patch_intersections.h"

namespace orbweave {
namespace {

// Of 216 loops of nine scans with more contacts than these three came to be closed, by patches of
// confidences of 0.10, 0.20 and 0.53. They took up to a fifth of the time of all holes. Shorter
// loops take little time, and more of them came to be closed.
constexpr std::size_t kLong = 100, kVeryLong = 150;  // edges
constexpr std::uint64_t kMostContacts = 32, kMostContactsOfRough = 64;

}  // namespace

PartsInScene::PartsInScene(const HoleProblem& problem, const BoxTree& sheet,
                           const PatchOptions& options) {
  const std::size_t edges = problem.loop.size();
  if (!options.whole || edges < kLong) return;
  // The pane of a window is flat, and clear of what triangles between the corners run into.
  bool may_be_flat = false;
  const auto look_at = [&](const HoleProblem& part, const Rim& rim) {
    const bool is_most = 2 * part.loop.size() >= edges;
    if (is_most && !may_be_flat) may_be_flat = call_for_flat_patch(part, rim).any();
  };
  const auto meets_oftener = [&](const HolePatch& corners, std::uint64_t most) {
    return !may_be_flat && corners.method != FillMethod::kNone &&
           find_contacts(problem, sheet, corners, most + 1).size() > most;
  };
  if (edges >= kVeryLong) {
    const HolePatch rough =
        fill_by_parts(problem, sheet, [&](const HoleProblem& part, std::size_t) {
          if (is_closed_directly(part, options)) return direct_fill(part);
          const LoopTriangles loop = rough_triangles_of_loop(part);
          look_at(part, loop.rim);
          return direct_fill(part, loop);
        });
    is_hopeless_ = meets_oftener(rough, kMostContactsOfRough);
    if (is_hopeless_) return;
  }
  const HolePatch corners =
      fill_by_parts(problem, sheet, [&](const HoleProblem& part, std::size_t) {
        parts_.emplace_back();
        if (is_closed_directly(part, options)) return direct_fill(part);
        LoopTriangles loop = triangles_of_loop(part);
        look_at(part, loop.rim);
        HolePatch patch = direct_fill(part, loop);
        parts_.back() = {part.forbidden, std::move(loop)};
        return patch;
      });
  is_hopeless_ = meets_oftener(corners, kMostContacts);
}

std::optional<LoopTriangles> PartsInScene::take_triangles(const HoleProblem& part,
                                                          std::size_t number) {
  if (number >= parts_.size() || !parts_[number]) return {};
  std::optional<Part> known = std::exchange(parts_[number], {});
  if (known->forbidden != part.forbidden) return {};
  return std::move(known->loop);
}

}  // namespace orbweave
