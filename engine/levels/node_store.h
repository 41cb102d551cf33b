// Where the nodes of levels of detail lie that were simplified.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/levels/levels.h"
#include "engine/levels/node_mesh.h"
#include "io/system/spool_file.h"

namespace orbweave {

/// What is told of the nodes before the first one is made.
struct NodePlan {
  /// All that nodes depend on, lines of "name = value". Nodes of an earlier run are those of this
  /// run where the key is the same.
  std::string key;
  std::uint32_t nodes = 0;    ///< of the octree, leaves included
  std::size_t row_bytes = 0;  ///< of a vertex
};

/// Keeps simplified nodes while their parents are made, and for the next run where it can. Leaves
/// are read again from the mesh. Thread-safe after begin().
class NodeStore {
 public:
  virtual ~NodeStore() = default;
  NodeStore() = default;
  NodeStore(const NodeStore&) = delete;
  NodeStore& operator=(const NodeStore&) = delete;

  /// Comes first, and once. Nodes that were kept under another key are dropped.
  virtual void begin(const NodePlan& plan) = 0;
  /// Whether the node was kept, by this run or an earlier one.
  virtual bool has(std::uint32_t node) const = 0;
  virtual void keep(std::uint32_t node, const LevelFacts& facts, const NodeMesh& mesh) = 0;
  /// Of a node that was kept, as mesh().
  virtual LevelFacts facts(std::uint32_t node) const = 0;
  virtual NodeMesh mesh(std::uint32_t node) const = 0;
  /// Of files without a name.
  virtual std::uint64_t unnamed_bytes() const = 0;
};

/// Keeps nodes in a file without a name, which goes with the object.
class SpooledNodes : public NodeStore {
 public:
  explicit SpooledNodes(const std::filesystem::path& directory) : file_(directory) {}

  void begin(const NodePlan& plan) override;
  bool has(std::uint32_t node) const override { return places_[node].bytes > 0; }
  void keep(std::uint32_t node, const LevelFacts& facts, const NodeMesh& mesh) override;
  LevelFacts facts(std::uint32_t node) const override { return places_[node].facts; }
  NodeMesh mesh(std::uint32_t node) const override;
  std::uint64_t unnamed_bytes() const override { return file_.bytes(); }

 private:
  struct Place {
    LevelFacts facts;
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
  };
  SpoolFile file_;
  std::size_t row_bytes_ = 0;
  std::vector<Place> places_;
};

}  // namespace orbweave
