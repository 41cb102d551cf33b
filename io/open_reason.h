// Why a boundary loop stays open.
#pragma once

#include <cstdint>

namespace orbweave {

/// kOther: no option decided; the loop's text says what is in the way.
enum class OpenReason : std::uint8_t {
  kNone,
  kOuterBorder,
  kMaxEdges,
  kMaxDiameter,
  kTooWide,
  kMaxPerimeter,
  kTooManyPoints,
  kOther,
};

}  // namespace orbweave
