// Reads clouds and says what is in them, how fast they came and a digest of every value, one JSON
// object per line; for a file that is refused, the message.
#include <xxhash.h>

#include <array>
#include <chrono>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "io/box.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/points/point_source.h"

namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kBatchPoints = std::size_t{1} << 16;

struct Digests {
  std::uint64_t in_order = 0;    ///< of positions as they come
  std::uint64_t as_set = 0;      ///< of positions in any order, in whole thousandths of a unit
  std::uint64_t attributes = 0;  ///< of attribute rows as they come
};

void add(Digests& digests, const orbweave::PointCloud& batch) {
  // Row by row, so that the digest does not depend on how the source cuts its batches.
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const std::uint64_t row = XXH64(&batch.positions[i], sizeof(orbweave::Vec3), 0);
    const auto& p = batch.positions[i];
    const std::array<long long, 3> whole = {std::llround(1000.0 * p.x), std::llround(1000.0 * p.y),
                                            std::llround(1000.0 * p.z)};
    digests.as_set += XXH64(whole.data(), sizeof whole, 0);
    digests.in_order = XXH64(&row, sizeof row, digests.in_order);
    const auto attributes = batch.attribute_row(i);
    digests.attributes = XXH64(attributes.data(), attributes.size(), digests.attributes);
  }
}

/// Seconds of reading alone, nothing kept.
double reading_seconds(const std::string& file) {
  const auto begin = std::chrono::steady_clock::now();
  const auto source = orbweave::open_point_source(file);
  for (orbweave::PointCloud batch; source->read(batch, kBatchPoints);) continue;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Json box_of(const orbweave::Box& box) {
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

Json facts_of(const std::string& file) {
  const auto source = orbweave::open_point_source(file);
  Digests digests;
  orbweave::Box bounds;
  std::uint64_t points = 0, not_finite = 0;
  for (orbweave::PointCloud batch; source->read(batch, kBatchPoints);) {
    add(digests, batch);
    points += batch.size();
    for (const orbweave::Vec3& p : batch.positions) {
      if (orbweave::is_finite(p))
        bounds.extend(p);
      else
        ++not_finite;
    }
  }
  Json names = Json::array();
  for (const auto& field : source->schema().attributes) names.push_back(field.name);
  return {{"file", file},
          {"points", points},
          {"not_finite", not_finite},
          {"left_out", source->left_out()},
          {"bounds", points > not_finite ? box_of(bounds) : Json()},
          {"normals", source->schema().has_normals},
          {"attributes", names},
          {"coordinate_system", !source->coordinate_system().empty()},
          {"digest", std::to_string(digests.in_order)},
          {"digest_of_set", std::to_string(digests.as_set)},
          {"digest_of_attributes", std::to_string(digests.attributes)}};
}

}  // namespace

int main(int count, char** arguments) {
  for (int k = 1; k < count; ++k) {
    const std::string file = arguments[k];
    try {
      Json facts = facts_of(file);
      facts["seconds"] = reading_seconds(file);
      std::cout << facts.dump() << "\n";
    } catch (const orbweave::Error& error) {
      std::cout << Json{{"file", file}, {"refused", error.what()}}.dump() << "\n";
    }
  }
  return std::cout.flush() ? 0 : 1;
}
