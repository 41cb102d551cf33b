// The colours that pictures give to components, and what legends say of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/report/picture_legend.h"

namespace orbweave {

/// Fronts of the surface from the scan, and where its points are too sparse for the shape.
inline constexpr Rgb kSurfaceColor = {232, 224, 210};
inline constexpr Rgb kUndersampledColor = {245, 150, 20};

/// Components that a legend names one by one.
inline constexpr std::size_t kNamedComponents = 10;

/// The colour of a component by its rank, the largest first. The first kNamedComponents colours
/// are told apart easily; later ones are paler and may resemble each other.
Rgb component_color(std::size_t rank);

/// `triangles`: per component, by rank.
std::vector<LegendEntry> component_legend(std::span<const std::uint64_t> triangles);

}  // namespace orbweave
