#include "engine/levels/node_store.h"

namespace orbweave {

void SpooledNodes::begin(const NodePlan& plan) {
  row_bytes_ = plan.row_bytes;
  places_.resize(plan.nodes);
}

void SpooledNodes::keep(std::uint32_t node, const LevelFacts& facts, const NodeMesh& mesh) {
  const std::vector<std::byte> bytes = packed(mesh);
  places_[node] = {facts, file_.append(bytes), bytes.size()};
}

NodeMesh SpooledNodes::mesh(std::uint32_t node) const {
  std::vector<std::byte> bytes(places_[node].bytes);
  file_.read(places_[node].offset, bytes);
  return unpacked(bytes, row_bytes_);
}

}  // namespace orbweave
