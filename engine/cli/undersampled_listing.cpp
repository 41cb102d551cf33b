#include "engine/cli/undersampled_listing.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "engine/cli/json_text.h"
#include "engine/cli/output.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/text/quantity.h"
#include "partition/canonical_order.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

double share_of(const voronoi::Undersampling& found) {
  if (found.well_sampled.empty()) return 0.0;
  return static_cast<double>(found.points) / static_cast<double>(found.well_sampled.size());
}

Vec3 center_of(const Box& box) { return 0.5 * (box.min + box.max); }

std::string place_text(Vec3 p) {
  return format_number(p.x) + " " + format_number(p.y) + " " + format_number(p.z);
}

std::string percent(double share) { return format_number(std::round(share * 1000.0) / 10.0) + "%"; }

}  // namespace

void require_undersampling(const Job& job, std::uint64_t points) {
  require_voronoi_family();
  const std::uint64_t needed =
      MemoryCosts::kBaseBytes + points * costs_of(ReconstructionMethod::kCocone).bytes_per_point;
  if (needed <= job.partition.memory_bytes) return;
  throw_resource("the memory budget is too small for --undersampled, which holds the whole cloud",
                 {.place = setting_name(job, "partition.memory"),
                  .found = format_bytes(job.partition.memory_bytes) + "; " +
                           counted(points, "point", "points"),
                  .expected = "at least " + std::to_string((needed >> 20) + 1) + " MiB",
                  .advice = "Or select a part of the cloud, with --crop"});
}

voronoi::Undersampling undersampling_of(PointCloud cloud) {
  std::erase_if(cloud.positions, [](const Vec3& p) { return !is_finite(p); });
  PointCloud places;
  places.positions = std::move(cloud.positions);
  if (!places.empty()) sort_canonically(places, root_cube(places.bounds()));
  return find_undersampling(places.positions, nullptr);
}

Json undersampled_json(const voronoi::Undersampling& found) {
  Json places = Json::array();
  for (const voronoi::UndersampledPlace& place : found.places)
    places.push_back({{"points", place.points}, {"bounds", box_json(place.bounds)}});
  return {{"points", found.points}, {"share", share_of(found)}, {"places", std::move(places)}};
}

std::string undersampled_text(const voronoi::Undersampling& found) {
  constexpr std::size_t kShown = 8;
  std::string text = "\nundersampled: " + counted(found.points, "point", "points") + " (" +
                     percent(share_of(found)) + ") in " +
                     counted(found.places.size(), "place", "places") + "\n";
  if (found.places.empty()) return text;
  std::vector<std::vector<std::string>> rows = {
      {found.places.size() > kShown ? "largest places" : "places", "points", "diameter", "around"}};
  for (std::size_t i = 0; i < std::min(found.places.size(), kShown); ++i) {
    const voronoi::UndersampledPlace& place = found.places[i];
    rows.push_back({std::to_string(i + 1), format_count(place.points),
                    format_number(norm(place.bounds.extent())),
                    place_text(center_of(place.bounds))});
  }
  text += table(rows);
  if (found.places.size() > kShown)
    text += "and " + format_count(found.places.size() - kShown) + " more; --json lists all\n";
  return text;
}

}  // namespace orbweave
