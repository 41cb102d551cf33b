#include "engine/pipeline/points/scan_extents.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "engine/spacing/site_points.h"
#include "engine/validation/odd_scans.h"
#include "engine/validation/scan_agreement.h"
#include "io/job/setting.h"
#include "io/points/length_units.h"
#include "io/points/scan_pose.h"
#include "io/text/json_dump.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;

void add_vector(Vec3 v, Json& list) {
  for (int axis = 0; axis < 3; ++axis) list.push_back(v[axis]);
}

Vec3 vector_at(const Json& list, std::size_t first) {
  return {list.at(first), list.at(first + 1), list.at(first + 2)};
}

std::string size_text(double length) { return format_number(length) + " across"; }

/// "a.ply", "a.ply and 2 more scans".
std::string names_of(const std::vector<std::string>& names, const std::vector<std::size_t>& some) {
  const std::string& first = names[some.front()];
  if (some.size() == 1) return first;
  const std::size_t more = some.size() - 1;
  return first + " and " + std::to_string(more) + (more == 1 ? " more scan" : " more scans");
}

/// "the other scan", "the other 3 scans".
std::string others_of(std::size_t all, const OddScans& odd) {
  const std::size_t others = all - odd.scans.size();
  return others == 1 ? "the other scan" : "the other " + std::to_string(others) + " scans";
}

/// One scan lies, some scans lie.
std::string of_number(const OddScans& odd, const char* one, const char* several) {
  return odd.scans.size() == 1 ? one : several;
}

std::string objection_to_place(const ResolvedJob& job, const OddScans& odd,
                               const std::string& names, const std::string& others) {
  const std::string what = names + of_number(odd, " lies ", " lie ") + format_number(odd.gap) +
                           " away from " + others + ", " + size_text(odd.size) + ", the others " +
                           size_text(odd.size_of_others) + ": ";
  if (odd.factor > 0.0)
    return what + "coordinates multiplied by " + format_number(odd.factor) +
           " lie among those of the others, so the unit is probably another one; give all scans "
           "in one unit";
  return what + "the poses (" + setting_name(job, "input.poses") + ", " +
         setting_name(job, "input.pose") +
         ") or the origin or the unit of the coordinates are probably not those of the others; "
         "give all scans in one system of coordinates";
}

std::string objection_to_size(const OddScans& odd, const std::string& names,
                              const std::string& others) {
  const bool is_larger = odd.place == OddPlace::kLarger;
  const double ratio = is_larger ? odd.size / odd.size_of_others : odd.size_of_others / odd.size;
  return names + of_number(odd, " is ", " are ") + size_text(odd.size) + " and " + others + " " +
         size_text(odd.size_of_others) + (is_larger ? " at most" : " at least") + ", a ratio of " +
         format_number(ratio) +
         ": the unit is probably another one, as millimetres are beside metres; give all scans in "
         "one unit";
}

std::string objection_to_surface(const ResolvedJob& job, const OffScan& off,
                                 const std::vector<std::string>& names, double meters_per_unit) {
  const Length apart = readable_length(off.distance, meters_per_unit);
  const double share = static_cast<double>(off.off) / static_cast<double>(off.meetings);
  const std::string& name = names[off.scan];
  const std::string& beside = names[off.beside];
  const bool are_two = names.size() == 2;
  return (are_two ? name + " and " + beside + " do not lie on one surface"
                  : name + " does not lie on the surface of the other scans") +
         ": where they meet, at " + format_count(off.meetings) +
         " places, the median between them is " + short_text(apart.value) + apart.unit + " (" +
         brief_text(off.spacings) + " point spacings), and at " + format_percent(share) +
         " of the places they cross or lie apart" + (are_two ? "" : ", most of all " + beside) +
         "; the mesh has the surface twice or scattered there; check the poses (" +
         setting_name(job, "input.poses") + ", " + setting_name(job, "input.pose") +
         "), or register the scans better";
}

}  // namespace

void ScanExtents::add(ScanNumber scan, const ScanExtent& part) {
  ScanExtent& extent = of_scan_[scan];
  extent.points += part.points;
  extent.bounds.extend(part.bounds);
  if (part.scanner) extent.scanner = part.scanner;
}

std::uint32_t ScanExtents::index_of(ScanNumber scan) const {
  return static_cast<std::uint32_t>(std::distance(of_scan_.begin(), of_scan_.lower_bound(scan)));
}

std::string extents_text(const ScanExtents& extents) {
  Json list = Json::array();
  for (const auto& [scan, extent] : extents.all()) {
    if (extent.points == 0) continue;
    Json one = {scan.file, scan.scan, extent.points};
    for (const Vec3 corner : {extent.bounds.min, extent.bounds.max}) add_vector(corner, one);
    if (extent.scanner) {
      add_vector(extent.scanner->vector, one);
      one.push_back(extent.scanner->is_direction);
    }
    list.push_back(std::move(one));
  }
  return json_dump(list);
}

void add_extents(const std::string& text, ScanExtents& extents) {
  constexpr std::size_t kWithScanner = 13;
  for (const Json& one : Json::parse(text)) {
    ScanExtent extent{one.at(2), {vector_at(one, 3), vector_at(one, 6)}, std::nullopt};
    if (one.size() == kWithScanner) extent.scanner = {vector_at(one, 9), one.at(12)};
    extents.add({one.at(0), one.at(1)}, extent);
  }
}

std::string name_of_scan(const ResolvedJob& job, const ScanExtents& extents, ScanNumber scan) {
  const std::string& file = job.files.at(scan.file);
  const auto first = extents.all().lower_bound({scan.file, 0});
  const bool is_alone =
      std::next(first) == extents.all().end() || std::next(first)->first.file != scan.file;
  return is_alone ? file : "scan " + std::to_string(scan.scan + 1) + " of " + file;
}

std::vector<std::string> objections_to_extents(const ResolvedJob& job, const ScanExtents& extents) {
  if (extents.all().size() < 2) return {};
  std::vector<PlacedScan> scans;
  std::vector<std::string> names;
  for (const auto& [scan, extent] : extents.all()) {
    const Vec3 origin = pose_of_scan(job.poses, job.files.at(scan.file)).point(Vec3{});
    scans.push_back({extent.bounds, extent.points, origin});
    names.push_back(name_of_scan(job, extents, scan));
  }
  std::vector<std::string> objections;
  for (const OddScans& odd : odd_scans(scans)) {
    const std::string some = names_of(names, odd.scans), others = others_of(scans.size(), odd);
    objections.push_back(odd.place == OddPlace::kApart ? objection_to_place(job, odd, some, others)
                                                       : objection_to_size(odd, some, others));
  }
  return objections;
}

std::vector<std::string> objections_to_surfaces(const ResolvedJob& job, const ScanExtents& extents,
                                                const SpacingSampler& sampler,
                                                std::optional<Vec3> of_scans,
                                                const StopToken& stop) {
  if (sampler.scans().empty()) return {};
  std::vector<std::optional<ScannerPlace>> scanners;
  std::vector<std::string> names;
  for (const auto& [scan, extent] : extents.all()) {
    scanners.push_back(extent.scanner);
    names.push_back(name_of_scan(job, extents, scan));
  }
  const double unit = meters_per_unit(job.input.units_per_meter, of_scans).value_or(Vec3{}).x;
  std::vector<std::string> objections;
  for (const OffScan& off : scans_off_surface(sampler.sites(), sampler.scans(), scanners, &stop))
    objections.push_back(objection_to_surface(job, off, names, unit));
  return objections;
}

}  // namespace orbweave
