#include "engine/pipeline/points/selection_facts.h"

#include <algorithm>
#include <array>
#include <string>

#include "engine/pipeline/points/scan_input.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/points/named_attribute.h"
#include "io/points/point_classes.h"
#include "io/points/polygon_area.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// What the scans hold, selected or not.
struct HeldPoints {
  Box bounds;  ///< of the points whose coordinates are finite
  std::array<std::uint64_t, kPointClasses> classes{};
};

/// Everything that the scans hold, with their poses.
HeldPoints facts_of_scans(ResolvedJob job, const StopToken& stop) {
  const InputOptions all;
  job.input.las_classes.clear();
  job.input.drop_classes.clear();
  job.input.returns = all.returns;
  job.input.crop.reset();
  job.input.every = all.every;
  job.area = nullptr;
  job.output.attributes = true;
  HeldPoints facts;
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
  const auto source = open_scans(job, stop);
  const auto point_class = find_attribute(source->schema(), "classification");
  for (PointCloud batch; source->read(batch, kBatchPoints);) {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (is_finite(batch.positions[i])) facts.bounds.extend(batch.positions[i]);
      if (!point_class) continue;
      const double number = (*point_class)(batch.attribute_row(i));
      if (number >= 0.0 && number < static_cast<double>(kPointClasses))
        ++facts.classes[static_cast<std::size_t>(number)];
    }
  }
  return facts;
}

std::string range_text(const char* axis, double low, double high) {
  return std::string(axis) + " " + format_exact(low) + " to " + format_exact(high);
}

std::string box_text(const Box& box) {
  const std::string plane =
      range_text("x", box.min.x, box.max.x) + ", " + range_text("y", box.min.y, box.max.y);
  return is_finite(box.min) ? plane + ", " + range_text("z", box.min.z, box.max.z) : plane;
}

std::string class_text(const HeldPoints& facts) {
  std::string text;
  for (std::size_t number = 0; number < facts.classes.size(); ++number)
    if (facts.classes[number] != 0)
      text += (text.empty() ? "" : ", ") + format_count(facts.classes[number]) + " of " +
              name_of_class(static_cast<int>(number));
  return text;
}

/// GeoJSON is in degrees by its standard, scans are not.
bool looks_like_degrees(const Box& area, const Box& points) {
  const Box degrees{{-180.0, -90.0, area.min.z}, {180.0, 90.0, area.max.z}};
  return degrees.contains(area.min) && degrees.contains(area.max) && !points.empty() &&
         !degrees.intersects(points);
}

/// All points are of the classes 0 and 1: never classified, or not yet.
bool is_unclassified(const HeldPoints& held) {
  return held.classes[0] + held.classes[1] > 0 &&
         std::all_of(held.classes.begin() + 2, held.classes.end(),
                     [](std::uint64_t points) { return points == 0; });
}

std::string advice_for(const ResolvedJob& job, const HeldPoints& held) {
  if (job.area != nullptr && looks_like_degrees(job.area->bounds(), held.bounds))
    return "The area is in degrees, the points are not. Give it the coordinate system of the "
           "scans: ogr2ogr -t_srs EPSG:CODE area-of-scans.geojson area.geojson";
  if (job.input.crop || job.area != nullptr) return "A crop is in the coordinates of the points.";
  if (!job.input.las_classes.empty() && is_unclassified(held))
    return "The points are not classified. PDAL finds the ground: pdal translate IN.laz OUT.laz "
           "smrf (docs/other-tools.md).";
  std::string keys;
  for (const char* key : {"input.las_classes", "input.drop_classes", "input.returns"})
    keys += (keys.empty() ? "" : ", ") + setting_name(job, key);
  return "What is selected is told by " + keys + " and " + setting_name(job, "input.every") + ".";
}

}  // namespace

void note_dropped_classes(const Job& job, CountedCloud& cloud) {
  std::string text;
  for (const int number : job.input.drop_classes) {
    const auto found = cloud.dropped.find(text_of_dropped_class(number));
    if (found == cloud.dropped.end()) continue;
    text +=
        (text.empty() ? "" : ", ") + format_count(found->second) + " of " + name_of_class(number);
  }
  if (text.empty()) return;
  cloud.notes.push_back("points of dropped classes are left out (" + text + "); " +
                        setting(job, "input.drop_classes", "none") + " keeps them");
}

bool has_selected(const ResolvedJob& job, const DroppedPoints& dropped) {
  const InputOptions& input = job.input;
  return input.crop || job.area != nullptr || !input.las_classes.empty() ||
         input.returns != ReturnFilter::kAll || input.every > 1 ||
         std::ranges::any_of(input.drop_classes, [&](int number) {
           return dropped.contains(text_of_dropped_class(number));
         });
}

void refuse_empty_selection(const RunControl& control, const CountedCloud& cloud) {
  const ResolvedJob& job = control.job;
  const HeldPoints facts = facts_of_scans(job, control.stop);
  std::string found = describe_dropped(cloud.points_read, cloud.dropped);
  if (!facts.bounds.empty()) found += "; the points lie in " + box_text(facts.bounds);
  if (job.input.crop) found += "; the crop is " + box_text(*job.input.crop);
  if (job.area != nullptr)
    found += "; the area of the crop lies in " + box_text(job.area->bounds());
  if (const std::string classes = class_text(facts); !classes.empty())
    found += "; classes: " + classes;
  throw_bad_input("the cloud holds no usable point",
                  {.file = job.files.front(), .found = found, .advice = advice_for(job, facts)});
}

}  // namespace orbweave
