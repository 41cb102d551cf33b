#include "engine/pipeline/surface/patch_batch.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

namespace orbweave {
namespace {

constexpr std::uint32_t kFactColumns = 22;
using FactRow = std::array<double, kFactColumns>;

/// Texts go to one array, their lengths to the rows. Counts are whole doubles.
FactRow row_of(const HoleFacts& f, std::string& texts) {
  texts += f.method + f.reason;
  return {static_cast<double>(f.id),
          static_cast<double>(f.first_vertex),
          static_cast<double>(f.edges),
          f.perimeter,
          f.diameter,
          f.center.x,
          f.center.y,
          f.center.z,
          static_cast<double>(f.method.size()),
          static_cast<double>(f.reason.size()),
          static_cast<double>(f.sites),
          static_cast<double>(f.points_added),
          static_cast<double>(f.triangles_added),
          f.residual,
          f.condition,
          f.rim_dihedral_deg,
          static_cast<double>(f.joined_to),
          static_cast<double>(f.open_edges),
          f.area,
          f.rim_mean_deg,
          f.confidence,
          static_cast<double>(f.open)};
}

HoleFacts facts_of(const FactRow& row, const std::vector<char>& texts, std::size_t& place) {
  const auto take = [&](double length) {
    const auto begin = texts.begin() + static_cast<std::ptrdiff_t>(place);
    place += static_cast<std::size_t>(length);
    return std::string(begin, texts.begin() + static_cast<std::ptrdiff_t>(place));
  };
  const auto count = [](double value) { return static_cast<std::uint64_t>(value); };
  HoleFacts f;
  f.id = static_cast<std::int32_t>(row[0]);
  f.first_vertex = count(row[1]);
  f.edges = count(row[2]);
  f.perimeter = row[3];
  f.diameter = row[4];
  f.center = {row[5], row[6], row[7]};
  f.method = take(row[8]);
  f.reason = take(row[9]);
  f.filled = !f.method.empty();
  f.sites = count(row[10]);
  f.points_added = count(row[11]);
  f.triangles_added = count(row[12]);
  f.residual = row[13];
  f.condition = row[14];
  f.rim_dihedral_deg = row[15];
  f.joined_to = static_cast<std::int32_t>(row[16]);
  f.open_edges = count(row[17]);
  f.area = row[18];
  f.rim_mean_deg = row[19];
  f.confidence = row[20];
  f.open = static_cast<OpenReason>(count(row[21]));
  return f;
}

void read_facts(const StoredResult& stored, PatchBatch& batch) {
  const auto rows = stored.read_all<FactRow>("facts");
  const auto seconds = stored.read_all<double>("seconds");
  batch.boxes = stored.read_all<Box>("boxes");
  const auto texts = stored.read_all<char>("texts");
  std::size_t place = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    batch.facts.push_back(facts_of(rows[i], texts, place));
    batch.facts.back().seconds = seconds[i];
  }
}

}  // namespace

void append_patch(LoopPatch&& patch, const Box& box, PatchBatch& batch) {
  const std::uint64_t base = batch.positions.size();
  for (Triangle64 t : patch.triangles) {
    for (std::uint64_t& vertex : t) vertex += vertex >= kNewVertex ? base : 0;
    batch.triangles.push_back(t);
    batch.hole.push_back(patch.facts.id);
  }
  batch.positions.insert(batch.positions.end(), patch.positions.begin(), patch.positions.end());
  batch.normals.insert(batch.normals.end(), patch.normals.begin(), patch.normals.end());
  batch.values.insert(batch.values.end(), patch.values.begin(), patch.values.end());
  batch.boxes.push_back(box);
  batch.facts.push_back(std::move(patch.facts));
}

void drop_patches(std::span<const std::int32_t> ids, PatchBatch& batch) {
  const auto is_dropped = [&](std::int32_t id) {
    return std::binary_search(ids.begin(), ids.end(), id);
  };
  const std::size_t channels =
      batch.positions.empty() ? 0 : batch.values.size() / batch.positions.size();
  // The new vertices of a loop follow those of the loop before.
  std::vector<std::uint64_t> number;
  number.reserve(batch.positions.size());
  std::uint64_t kept = 0, vertex = 0;
  for (std::size_t i = 0; i < batch.facts.size(); ++i) {
    HoleFacts& facts = batch.facts[i];
    const bool stays = !is_dropped(facts.id);
    for (std::uint64_t k = 0; k < facts.points_added; ++k, ++vertex) {
      number.push_back(kNewVertex + kept);
      if (!stays) continue;
      batch.positions[kept] = batch.positions[vertex];
      batch.normals[kept] = batch.normals[vertex];
      for (std::size_t c = 0; c < channels; ++c)
        batch.values[kept * channels + c] = batch.values[vertex * channels + c];
      ++kept;
    }
    if (stays) continue;
    facts.points_added = facts.triangles_added = facts.sites = facts.open_edges = 0;
    facts.residual = facts.condition = facts.area = facts.confidence = 0.0;
    facts.rim_dihedral_deg = facts.rim_mean_deg = 0.0;
    batch.boxes[i] = {};
  }
  batch.positions.resize(kept);
  batch.normals.resize(kept);
  batch.values.resize(kept * channels);
  std::size_t triangles = 0;
  for (std::size_t t = 0; t < batch.triangles.size(); ++t) {
    if (is_dropped(batch.hole[t])) continue;
    Triangle64 triangle = batch.triangles[t];
    for (std::uint64_t& v : triangle)
      if (v >= kNewVertex) v = number[v - kNewVertex];
    batch.hole[triangles] = batch.hole[t];
    batch.triangles[triangles++] = triangle;
  }
  batch.triangles.resize(triangles);
  batch.hole.resize(triangles);
}

void commit_patch_batch(ChunkStore& store, ChunkId batch, const PatchBatch& patches,
                        const std::string& stage) {
  std::vector<FactRow> rows;
  std::vector<double> seconds;
  std::string texts;
  for (std::size_t i = 0; i < patches.facts.size(); ++i) {
    rows.push_back(row_of(patches.facts[i], texts));
    seconds.push_back(patches.facts[i].seconds);
  }
  const ArrayView arrays[] = {
      {"positions", ScalarType::kFloat64, 3, patches.positions.size(), patches.positions.data()},
      {"normals", ScalarType::kFloat64, 3, patches.normals.size(), patches.normals.data()},
      {"values", ScalarType::kFloat64, 1, patches.values.size(), patches.values.data()},
      {"triangles", ScalarType::kUint64, 3, patches.triangles.size(), patches.triangles.data()},
      {"hole", ScalarType::kInt32, 1, patches.hole.size(), patches.hole.data()},
      {"facts", ScalarType::kFloat64, kFactColumns, rows.size(), rows.data()},
      {"seconds", ScalarType::kFloat64, 1, seconds.size(), seconds.data()},
      {"boxes", ScalarType::kFloat64, 6, patches.boxes.size(), patches.boxes.data()},
      {"texts", ScalarType::kUint8, 1, texts.size(), texts.data()},
  };
  store.commit(stage, batch, arrays);
}

namespace {

std::unique_ptr<StoredResult> open_batch(const ChunkStore& store, ChunkId batch) {
  return store.open(store.has(kSettledStage, batch) ? kSettledStage : kHoleStage, batch);
}

}  // namespace

PatchBatch load_patch_facts(const ChunkStore& store, ChunkId batch) {
  PatchBatch patches;
  read_facts(*open_batch(store, batch), patches);
  return patches;
}

PatchBatch load_patch_batch(const ChunkStore& store, ChunkId batch) {
  const auto stored = open_batch(store, batch);
  PatchBatch patches;
  patches.positions = stored->read_all<Vec3>("positions");
  patches.normals = stored->read_all<Vec3>("normals");
  patches.values = stored->read_all<double>("values");
  patches.triangles = stored->read_all<Triangle64>("triangles");
  patches.hole = stored->read_all<std::int32_t>("hole");
  read_facts(*stored, patches);
  return patches;
}

}  // namespace orbweave
