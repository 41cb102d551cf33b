#include "io/report/reasons.h"

#include <array>
#include <cstddef>

namespace orbweave {
namespace {

constexpr std::array<const char*, 4> kSources = {"", "file", "estimated", "poles"};
constexpr std::array<const char*, 8> kOrientations = {"",          "scanner", "viewpoint", "up",
                                                      "propagate", "ground",  "inward",    "none"};

constexpr std::array<const char*, 8> kOpenReasons = {
    "",
    "outer border of an open sheet (fill.keep_outer_border)",
    "more edges than fill.max_edges",
    "wider than fill.max_diameter",
    "too wide to be known, in an open scene (fill.max_diameter)",
    "rim longer than fill.max_perimeter",
    "",
    "",
};

template <class Enum, std::size_t N>
Enum value_of(const std::array<const char*, N>& texts, std::string_view text) {
  for (std::size_t i = 0; i < N; ++i)
    if (text == texts[i]) return static_cast<Enum>(i);
  return Enum{};
}

}  // namespace

const char* text_of(OpenReason reason) { return kOpenReasons[static_cast<std::size_t>(reason)]; }

const char* text_of(NormalSource source) { return kSources[static_cast<std::size_t>(source)]; }

const char* text_of(Orientation orientation) {
  return kOrientations[static_cast<std::size_t>(orientation)];
}

NormalSource normal_source_from(std::string_view text) {
  return value_of<NormalSource>(kSources, text);
}

Orientation orientation_from(std::string_view text) {
  return value_of<Orientation>(kOrientations, text);
}

}  // namespace orbweave
