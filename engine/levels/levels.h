// Levels of detail of a mesh of any size, out of core.
//
// An octree over the triangles, cut by a fixed number of triangles (engine/levels/level_tree.h).
// A leaf has the triangles of its cell; every other node has those of its children, simplified
// together. The border of a node towards others stays as it is: so nodes of any two levels fit
// together, vertex by vertex, and what was a border between children is simplified in their parent.
// Rims of the mesh become simpler along themselves. The edges between leaves are kept in memory:
// some 16 bytes for fifty triangles.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/levels/level_tree.h"
#include "engine/levels/node_mesh.h"
#include "io/box.h"

namespace orbweave {

class NodeStore;

struct LevelOptions {
  std::uint64_t leaf_triangles = 65536;                 ///< most triangles of a leaf, at least 1
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  ///< of the whole process
  int threads = 1;
  std::filesystem::path directory;  ///< for temporary files without a name
  NodeStore* nodes = nullptr;       ///< where simplified nodes lie; null: in such a file
  bool keeps_tags = false;          ///< faces keep the holes that they fill and their components
};

/// What is known of a node when it is done.
struct LevelFacts {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t border_triangles = 0;  ///< with an edge at the node's border or at a rim
  /// How far its surface is from the mesh, world units, as engine/levels/simplify.h measures it,
  /// added up over the levels below; 0: a leaf.
  double error = 0.0;
  /// A manifold wherever the mesh is one, as all nodes below it are.
  bool is_sound = true;
  Box bounds;  ///< of all vertices below it, so those of children lie in those of parents
};

/// What happens on the way. Calls come from several threads.
struct LevelEvents {
  /// A node's mesh is done. `points`: its vertices with normals and colours.
  std::function<void(std::uint32_t node, const PointCloud& points, const NodeMesh& mesh)> done;
  std::function<void(std::uint64_t triangles)> read;  ///< were read since the last call
  /// How many nodes there will be, and the bounds of all vertices.
  std::function<void(std::uint32_t nodes, const Box& bounds)> planned;
};

struct Levels {
  std::vector<LevelNode> nodes;
  std::vector<LevelFacts> facts;  ///< of each node
  std::uint64_t triangles = 0;    ///< of the mesh
  std::uint64_t vertices = 0;
  std::uint64_t reused = 0;  ///< nodes that an earlier run simplified
};

/// The largest leaves that a budget has room for.
std::uint64_t most_leaf_triangles(std::uint64_t memory_bytes);

/// The smallest budget that has room for leaves of that size.
std::uint64_t least_level_memory(std::uint64_t leaf_triangles);

/// How many nodes are made at a time. Throws Error (resource) where the budget has no room for one.
int level_workers(const LevelOptions& options);

}  // namespace orbweave
