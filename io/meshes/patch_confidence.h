// The confidence of the patches of a mesh by the ids of their holes, as mesh writers take it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace orbweave {

/// The largest id in a table of confidence by id: 256 MiB.
inline constexpr std::int32_t kMostIdWithConfidence = 1 << 26;

/// Notes the confidence of the patch of a hole; ids that are passed over have 1.
inline void note_confidence(std::vector<float>& confidence, std::int32_t id, float value) {
  if (id < 1) return;
  const auto place = static_cast<std::size_t>(id) - 1;
  if (place >= confidence.size()) confidence.resize(place + 1, 1.0F);
  confidence[place] = value;
}

}  // namespace orbweave
