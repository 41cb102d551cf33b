#include "io/job/selected_points.h"

#include <utility>

#include "io/points/area_text.h"

namespace orbweave {

bool names_area_file(const InputOptions& input) {
  return !input.crop_area.empty() && !is_area_text(input.crop_area);
}

std::shared_ptr<const PolygonArea> area_of(const InputOptions& input) {
  if (input.crop_area.empty()) return nullptr;
  return std::make_shared<const PolygonArea>(
      names_area_file(input) ? read_area(input.crop_area) : parse_area(input.crop_area, ""));
}

ScanOptions selection_of(const InputOptions& input, std::shared_ptr<const PolygonArea> area) {
  ScanOptions options;
  options.classes = input.las_classes;
  options.dropped_classes = input.drop_classes;
  options.returns = input.returns;
  options.crop = input.crop;
  options.area = std::move(area);
  options.every = input.every;
  return options;
}

}  // namespace orbweave
