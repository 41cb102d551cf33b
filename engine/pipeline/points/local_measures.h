// What is measured of the points of a chunk with neighbourhoods that follow the noise.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/cleaning/surfaceness.h"
#include "engine/normals/estimate_normals.h"
#include "engine/pipeline/points/raw_passes.h"

namespace orbweave {

/// Margin that a chunk needs around its points.
double local_normal_halo(std::span<const NormalEstimateOptions> of_level);

/// Normals of the chunk's own points, each estimated as its level asks for.
std::vector<Vec3> normals_locally(const PassPoints& points, std::span<const std::uint8_t> levels,
                                  std::span<const NormalEstimateOptions> of_level);

/// Surfaceness of the chunk's own points, likewise.
std::vector<float> surfaceness_locally(const PassPoints& points,
                                       std::span<const std::uint8_t> levels,
                                       std::span<const SurfacenessOptions> of_level);

}  // namespace orbweave
