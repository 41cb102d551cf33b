// Nodes of levels of detail in the work directory, from which an interrupted job goes on.
#pragma once

#include <string>

#include "engine/levels/node_store.h"
#include "io/store/chunk_store.h"

namespace orbweave {

/// Keeps nodes as results of a stage. Reading a damaged one throws CorruptResult.
class StoredNodes : public NodeStore {
 public:
  /// `stage`: the directory in the store, which outlives the object.
  StoredNodes(ChunkStore& store, std::string stage) : store_(store), stage_(std::move(stage)) {}

  void begin(const NodePlan& plan) override;
  bool has(std::uint32_t node) const override { return store_.has(stage_, node); }
  void keep(std::uint32_t node, const LevelFacts& facts, const NodeMesh& mesh) override;
  LevelFacts facts(std::uint32_t node) const override;
  NodeMesh mesh(std::uint32_t node) const override;
  std::uint64_t unnamed_bytes() const override { return 0; }

 private:
  ChunkStore& store_;
  std::string stage_;
  std::size_t row_bytes_ = 0;
};

}  // namespace orbweave
