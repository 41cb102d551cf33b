#include "engine/pipeline/output/stored_nodes.h"

#include <array>
#include <memory>

namespace orbweave {
namespace {

constexpr std::uint32_t kMeasures = 7;  // error and bounds
constexpr std::uint32_t kCounts = 2;    // triangles at borders; whether the node is sound
static_assert(sizeof(FaceTag) == 12, "a tag is stored as its bytes");

}  // namespace

void StoredNodes::begin(const NodePlan& plan) {
  row_bytes_ = plan.row_bytes;
  store_.begin_stage(stage_, plan.key);
}

void StoredNodes::keep(std::uint32_t node, const LevelFacts& facts, const NodeMesh& mesh) {
  const Vec3& min = facts.bounds.min;
  const Vec3& max = facts.bounds.max;
  const std::array<double, kMeasures> measures = {facts.error, min.x, min.y, min.z,
                                                  max.x,       max.y, max.z};
  const std::array<std::uint64_t, kCounts> counts = {facts.border_triangles,
                                                     facts.is_sound ? 1U : 0U};
  const std::array<ArrayView, 6> arrays = {
      ArrayView{"vertices", ScalarType::kUint64, 1, mesh.vertices.size(), mesh.vertices.data()},
      ArrayView{"rows", ScalarType::kUint8, static_cast<std::uint32_t>(row_bytes_),
                mesh.vertices.size(), mesh.rows.data()},
      ArrayView{"triangles", ScalarType::kUint32, 3, mesh.triangles.size(), mesh.triangles.data()},
      ArrayView{"tags", ScalarType::kUint8, sizeof(FaceTag), mesh.tags.size(), mesh.tags.data()},
      ArrayView{"measures", ScalarType::kFloat64, kMeasures, 1, measures.data()},
      ArrayView{"counts", ScalarType::kUint64, kCounts, 1, counts.data()},
  };
  store_.commit(stage_, node, arrays);
}

LevelFacts StoredNodes::facts(std::uint32_t node) const {
  const std::unique_ptr<StoredResult> stored = store_.open(stage_, node);
  std::array<double, kMeasures> measures{};
  std::array<std::uint64_t, kCounts> counts{};
  stored->read("measures", 0, 1, measures.data());
  stored->read("counts", 0, 1, counts.data());
  LevelFacts facts;
  facts.vertices = stored->rows("vertices");
  facts.triangles = stored->rows("triangles");
  facts.border_triangles = counts[0];
  facts.is_sound = counts[1] != 0;
  facts.error = measures[0];
  facts.bounds = {{measures[1], measures[2], measures[3]}, {measures[4], measures[5], measures[6]}};
  return facts;
}

NodeMesh StoredNodes::mesh(std::uint32_t node) const {
  const std::unique_ptr<StoredResult> stored = store_.open(stage_, node);
  NodeMesh mesh;
  mesh.vertices = stored->read_all<std::uint64_t>("vertices");
  mesh.rows = stored->read_all<std::byte>("rows");
  mesh.triangles = stored->read_all<Triangle>("triangles");
  mesh.tags = stored->read_all<FaceTag>("tags");
  return mesh;
}

}  // namespace orbweave
