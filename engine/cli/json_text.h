// JSON that the commands print: common pieces, and text from it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "engine/validation/compare.h"
#include "io/box.h"

namespace orbweave {

nlohmann::ordered_json box_json(const Box& box);  ///< {"min": [x, y, z], "max": ...}; null if empty
/// Null for each of them where nothing was measured.
nlohmann::ordered_json distance_json(const DistanceSummary& distances);
nlohmann::ordered_json within_json(std::span<const NearShare> shares);

/// Indented, with a newline at its end; bytes that are no UTF-8 (of names, paths) become \xNN.
std::string json_text(const nlohmann::ordered_json& json);

}  // namespace orbweave
