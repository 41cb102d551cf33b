// What keeps a closed object from being a watertight manifold once its holes are filled, mended.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/hole_pass.h"
#include "engine/holes/patched_surface.h"
#include "io/hole_facts.h"
#include "io/stop_token.h"
#include "io/surface_options.h"

namespace orbweave {

/// What is to be mended.
struct Faults {
  /// Loops of closed objects that stayed open, or open at some edges, ascending.
  std::vector<std::uint32_t> loops;
  /// Vertices of closed objects that may have several fans, ascending.
  std::vector<std::uint64_t> pinched;
};

/// The loops among the faults: those of closed objects that were to be filled.
/// `holes`: what became of them.
std::vector<std::uint32_t> open_loops_of_solids(const HolePlan& plan,
                                                std::span<const HoleFacts> holes);

/// Of vertices that had several fans before the fill those of closed objects. `fans`: of the mesh
/// before the fill, sorted by vertex.
std::vector<std::uint64_t> pinches_of_solids(const HolePlan& plan,
                                             std::span<const std::uint64_t> pinched,
                                             std::span<const OpenFan> fans);

/// What mending changes of a mesh and its patches.
struct Mended {
  std::vector<LoopPatch> patches;  ///< new ones; each counts for the hole that its facts name
  /// Of loops that a patch above closes as well; their `joined_to` names its hole.
  std::vector<HoleFacts> joined;
  std::vector<std::uint8_t> is_replaced;  ///< per loop: the patch that it had, if any, is gone
  std::vector<Triangle64> taken;          ///< scanned triangles that are gone, sorted
  double taken_area = 0.0;                ///< theirs
  std::uint64_t pieces_gone = 0;          ///< connected pieces of the scanned mesh that went whole
  std::vector<std::uint64_t> freed;       ///< vertices that no triangle uses any more, ascending
  std::vector<OpenFan> corners;           ///< a fan per scanned triangle left at the vertices below
  std::vector<std::uint64_t> touched;     ///< vertices whose fans have changed, ascending

  bool empty() const { return patches.empty() && taken.empty(); }
};

/// Closes every fault another way, one after the other: patches of the fault are given up, and so
/// are the scanned triangles that keep a sound patch from closing the gap: those that a patch runs
/// into, those at the rim where it does, and all but the largest fan of a vertex. What the gap has
/// become then is filled, until no patch crosses anything. A fault that would cost too many
/// triangles, or separate what hangs together, stays as it is. A pure function of its arguments;
/// one fault looks at what is around it alone.
Mended mend_solids(const FilledSurface& filled, const Faults& faults, const FillOptions& options,
                   const StopToken* stop);

}  // namespace orbweave
