// Long loops of open scenes that touch themselves: which are worth a patch.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/holes/patch/box_tree.h"
#include "engine/holes/patch/direct_fill.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// A loop that touches itself is cut into parts, of which each may be closed. A wide gap of an open
/// scene is closed whole or not at all (PatchOptions::whole), and a patch of one that meets the
/// surface often at first never comes to be clear of it, unless it is flat. That is asked of
/// triangles between the corners of the parts, before any patch is made.
class PartsInScene {
 public:
  /// Other loops are not looked at. `sheet`: of the problem's sheet.
  PartsInScene(const HoleProblem& problem, const BoxTree& sheet, const PatchOptions& options);

  /// Whether the triangles meet the surface, or one another, too often.
  bool is_hopeless() const { return is_hopeless_; }
  /// The triangles that were made of a part, where the patches of those before it forbid the same
  /// edges; none else. Each is given once.
  std::optional<LoopTriangles> take_triangles(const HoleProblem& part, std::size_t number);

 private:
  struct Part {
    std::vector<std::array<std::uint32_t, 2>> forbidden;  ///< of its problem
    LoopTriangles loop;
  };
  std::vector<std::optional<Part>> parts_;  ///< by number; none of those closed directly
  bool is_hopeless_ = false;
};

}  // namespace orbweave
