#include "io/points/dropped_points.h"

#include <array>
#include <cstddef>

namespace orbweave {
namespace {

constexpr std::array<const char*, 15> kDropReasons = {
    "",
    "coordinate not finite",
    "no-data value (3.4028e38 or -3.4028e38)",
    "coordinate beyond 1e75",
    "missing return (several points at exactly 0, 0, 0)",
    "stray (64 or more extents away from all other points)",
    "normal not finite",
    "zero normal",
    "exact duplicate",
    "outlier",
    "merged with another point",
    "thinned",
    "too few neighbours for a normal",
    "small cluster apart from the surface",
    "no surface around it",
};

}  // namespace

const char* text_of(DropReason reason) { return kDropReasons[static_cast<std::size_t>(reason)]; }

}  // namespace orbweave
