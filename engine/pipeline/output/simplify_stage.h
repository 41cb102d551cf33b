// The simplified mesh of the finished mesh file.
#pragma once

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Throws Error (usage) where the job asks for a simplified mesh that cannot be made: its mesh is
/// no uncompressed PLY file, no mesh is written under the simplified one's name, the memory budget
/// is too small, nothing says how far it is to be simplified, or its numbers would replace what
/// something else wrote.
void check_simplification(const Job& job);

/// Throws Error (usage) where the simplified mesh's coordinates would lose too much. Before the
/// points are known nothing says so; behind the mesh it would be late.
void check_simplified_origin(const Job& job, const Partition& partition);

struct SimplifyInputs {
  const Partition& partition;
  std::uint64_t triangles = 0;  ///< of the mesh file
};

/// Simplify stage: reads the finished mesh file and writes the simplified one, by the root alone.
/// The bytes depend on the mesh file, the target and where the coordinates are counted from.
/// Nodes that are simplified on the way are kept in the store: a later run simplifies none of them
/// again. Throws CorruptResult where one is damaged.
void make_simplified(const SimplifyInputs& inputs, StageRunner& runner);

}  // namespace orbweave
