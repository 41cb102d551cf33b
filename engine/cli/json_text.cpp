#include "engine/cli/json_text.h"

#include <nlohmann/json.hpp>

#include "io/text/json_dump.h"

namespace orbweave {

using Json = nlohmann::ordered_json;

Json box_json(const Box& box) {
  if (box.empty()) return nullptr;
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

Json distance_json(const DistanceSummary& distances) {
  const auto known = [&](double value) { return distances.measured > 0 ? Json(value) : Json(); };
  return {{"points", distances.points},        {"measured", distances.measured},
          {"mean", known(distances.mean)},     {"rms", known(distances.rms)},
          {"median", known(distances.median)}, {"percentile_95", known(distances.percentile_95)},
          {"max", known(distances.max)}};
}

Json within_json(std::span<const NearShare> shares) {
  Json within = Json::array();
  for (const NearShare& share : shares)
    within.push_back({{"distance", share.distance},
                      {"precision", share.precision},
                      {"recall", share.recall},
                      {"f_score", share.f_score}});
  return within;
}

std::string json_text(const Json& json) { return json_dump(json, 2) + "\n"; }

}  // namespace orbweave
