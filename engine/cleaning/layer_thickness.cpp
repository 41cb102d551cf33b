#include "engine/cleaning/layer_thickness.h"
namespace orbweave {
bool LayerThickness::is_thick() const { return thickness > 0.5 * spacing; }
LayerThickness measure_layers(std::span<const SpacingSite>) { return {}; }
PrepareChoice choose_preparation(const LayerThickness&) { return {}; }
}  // namespace orbweave
