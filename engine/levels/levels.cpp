#include "engine/levels/levels.h"

#include <algorithm>

#include "io/error.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// Of the process without any node.
constexpr std::uint64_t kBaseBytes = std::uint64_t{48} << 20;
/// Of a node that is made, per triangle of its children: the meshes, the trees that distances are
/// measured with, meshoptimizer's tables.
constexpr std::uint64_t kBytesPerTriangle = 320;
/// Children of a node of a surface are about four; eight in a crowd.
constexpr std::uint64_t kChildren = 6;

}  // namespace

std::uint64_t most_leaf_triangles(std::uint64_t memory_bytes) {
  return memory_bytes <= kBaseBytes ? 0
                                    : (memory_bytes - kBaseBytes) / (kChildren * kBytesPerTriangle);
}

std::uint64_t least_level_memory(std::uint64_t leaf_triangles) {
  return kBaseBytes + kChildren * leaf_triangles * kBytesPerTriangle;
}

int level_workers(const LevelOptions& options) {
  const std::uint64_t node = kChildren * options.leaf_triangles * kBytesPerTriangle;
  if (options.memory_bytes < least_level_memory(options.leaf_triangles))
    throw_resource(
        "the memory budget has no room for a tile of this size",
        {.found = format_bytes(options.memory_bytes),
         .expected = "at least " + format_bytes(least_level_memory(options.leaf_triangles)),
         .advice = "Give it more memory, or make smaller tiles: --leaf-triangles"});
  const std::uint64_t room = (options.memory_bytes - kBaseBytes) / node;
  return static_cast<int>(std::min(room, static_cast<std::uint64_t>(std::max(options.threads, 1))));
}

}  // namespace orbweave
