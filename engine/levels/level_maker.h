// The making of levels of detail: the mesh sorted on disk, and its nodes one height after another.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "engine/geometry/edge_components.h"
#include "engine/levels/levels.h"
#include "engine/levels/listed_holes.h"
#include "engine/levels/node_mesh.h"
#include "engine/levels/node_store.h"
#include "engine/levels/sorted_triangles.h"
#include "engine/levels/vertex_table.h"
#include "io/meshes/mesh_stream.h"
#include "io/stop_token.h"

namespace orbweave {

/// Reads a mesh and makes the nodes of its octree; the meshes of nodes stay on disk, as long as the
/// object, or as long as the store of the options keeps them. What the constructor takes must
/// outlive it.
class LevelMaker {
 public:
  /// `schema`: what of the vertices is kept: that of the mesh, or less. Reads all of the mesh.
  /// Throws Error as make_levels() does.
  LevelMaker(MeshStream& mesh, const PointSchema& schema, const LevelOptions& options,
             const LevelEvents& events, const StopToken& stop);

  /// Whether a node serves, once it is made.
  using Serves = std::function<bool(const LevelNode&, const LevelFacts&)>;
  /// Makes leaves, then every node whose children all serve. Leaves do in any case. Nodes that an
  /// earlier run left in the store are not simplified again.
  void make(const Serves& serves);
  /// Makes all nodes.
  void make();

  /// Of nodes that were not made, the facts are empty.
  const Levels& levels() const { return levels_; }
  const Box& bounds() const { return mesh_.vertices->bounds(); }  ///< of all vertices

  /// The largest filled holes, where faces keep their tags.
  const std::vector<ListedHole>& holes() const { return mesh_.holes; }
  std::uint64_t hole_count() const { return mesh_.hole_count; }  ///< of all that are filled
  /// Triangles of each component, the largest first, where faces keep their tags.
  const std::vector<std::uint64_t>& components() const { return components_.triangles(); }

  /// Of the files without a name, as they are now.
  std::uint64_t disk_bytes() const {
    return mesh_.vertices->disk_bytes() + mesh_.triangles->disk_bytes() + nodes_->unnamed_bytes();
  }

  /// The coarsest nodes that serve and together hold the whole mesh, in the order of their cells.
  std::vector<std::uint32_t> cut() const;
  /// The mesh of a node that was made. Thread-safe.
  NodeMesh node(std::uint32_t number) const;
  std::vector<Vec3> positions(const NodeMesh& mesh) const { return positions_of(mesh, row_bytes_); }
  /// Its vertices with the normals and colours that are kept.
  PointCloud points(const NodeMesh& mesh) const { return mesh_.vertices->points(mesh.rows); }
  const PointSchema& schema() const { return mesh_.vertices->schema(); }
  /// Of what vertices tell of their points.
  std::vector<ShownRange> value_ranges() const { return mesh_.vertices->value_ranges(); }
  /// The vertices of a node that nodes beside it have as well, ascending. Thread-safe.
  std::vector<std::uint32_t> border_vertices(const NodeMesh& mesh) const;

  /// Calls `work` with the places from 0 to `count`, on as many threads as the memory has room for
  /// nodes.
  void on_threads(std::size_t count, const std::function<void(std::size_t)>& work) const;

 private:
  /// The mesh on disk: vertices by their numbers, triangles by their cells.
  struct StoredMesh {
    std::unique_ptr<VertexTable> vertices;
    std::unique_ptr<SortedTriangles> triangles;
    std::uint64_t checksum = 0;  ///< of the triangles as they were read
    std::vector<ListedHole> holes;
    std::uint64_t hole_count = 0;
  };
  enum class State : std::uint8_t { kAbsent, kMade, kServes };

  static StoredMesh stored_mesh(MeshStream& mesh, const PointSchema& schema,
                                const LevelOptions& options, const LevelEvents& events,
                                const StopToken& stop);
  void begin_nodes();
  void find_components();
  bool children_serve(std::uint32_t number) const;
  void make_node(std::uint32_t number, const Serves& serves);
  NodeMesh made_node(std::uint32_t number);
  void add_seams(const NodeMesh& mesh, std::span<const OpenEdge> open);
  void keep_seams();
  NodeMesh leaf(std::uint32_t number) const;
  NodeMesh merged_children(std::uint32_t number) const;
  NodeMesh simplified(std::uint32_t number);

  const LevelOptions& options_;
  const LevelEvents& events_;
  const StopToken& stop_;
  StoredMesh mesh_;
  std::unique_ptr<NodeStore> own_nodes_;  ///< null: those of the options are used
  NodeStore* nodes_;
  std::size_t row_bytes_;
  Levels levels_;
  std::vector<State> states_;
  EdgeComponents components_;         ///< its parts are the leaves
  std::vector<std::uint32_t> parts_;  ///< of each node that is a leaf
  std::mutex mutex_;
  std::vector<MeshEdge> seams_;  ///< edges between leaves
};

/// Reads the mesh and makes all levels. They depend on the mesh alone: not on threads, not on
/// memory. Throws Error: bad input where a corner is not finite, where coordinates cannot be
/// computed with (engine/validation/usable_scale.h) or where there is no triangle, resource where
/// the disk is full, interrupted.
Levels make_levels(MeshStream& mesh, const LevelOptions& options, const LevelEvents& events,
                   const StopToken& stop);

}  // namespace orbweave
