#include "engine/pipeline/points/scan_input.h"

#include <algorithm>
#include <filesystem>

#include "io/clouds/open_point_source.h"
#include "io/clouds/point_source_list.h"
#include "io/clouds/scan_source.h"
#include "io/error.h"
#include "io/job/selected_points.h"
#include "io/job/setting.h"
#include "io/vec3_order.h"

namespace orbweave {
namespace {

/// Range scans of the Stanford repository are taken along their -z axis from far away.
constexpr ScannerPlace kStanfordScanner{{0.0, 0.0, 1.0}, true};
/// Everybody else has the scanner at the origin of its own coordinates.
constexpr ScannerPlace kOriginScanner{{0.0, 0.0, 0.0}, false};

/// What all scans of the job have in common, and their poses.
class ScanOpener {
 public:
  ScanOpener(const ResolvedJob& job, const StopToken& stop)
      : job_(job), common_(selection_of(job.input, job.area)) {
    common_.stop = &stop;
    common_.scanner = job.input.scanner;
    common_.scanners = job.input.scanners;
    common_.trajectory = job.trajectory;
    common_.with_view = job.wants_view();
    common_.without_normals = job.estimates_normals;
    common_.would_take_normals = job.estimates_normals && job.normals.source == NormalSource::kAuto;
    common_.without_attributes = !job.output.attributes;
    if (!job.input.pose.empty()) common_.usual_scanner = kOriginScanner;
    if (!job.input.poses.empty()) common_.usual_scanner = kStanfordScanner;
  }

  std::unique_ptr<PointSource> operator()(const std::filesystem::path& path) const {
    ScanOptions options = common_;
    options.motion = pose_of_scan(job_.poses, path);
    return open_scan_source(open_point_source(path, {job_.input.text, common_.stop}), options,
                            path.string());
  }

 private:
  const ResolvedJob& job_;
  ScanOptions common_;
};

void require_normals(const PointSource& source, const ResolvedJob& job) {
  if (source.schema().has_normals) return;
  throw_bad_input(
      "the cloud has no normals",
      {.file = job.files.front(),
       .place = {},
       .found = "points without nx, ny, nz",
       .expected = "a normal per point, as " + setting(job, "normals.source", "file") + " asks for",
       .advice = "Have them estimated: " + setting(job, "normals.source", "estimate")});
}

/// Where the points lie that are (0, 0, 0) in their scans' own coordinates; ascending by x.
std::vector<Vec3> origins_of_scans(const ResolvedJob& job) {
  std::vector<Vec3> origins;
  for (const std::string& file : job.files)
    origins.push_back(pose_of_scan(job.poses, file).point(Vec3{}));
  std::sort(origins.begin(), origins.end(), comes_before);
  origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
  return origins;
}

}  // namespace

std::unique_ptr<PointSource> open_scans(const ResolvedJob& job, const StopToken& stop,
                                        std::vector<std::string>* notes) {
  const std::vector<std::filesystem::path> paths(job.files.begin(), job.files.end());
  auto source = open_point_sources(paths, ScanOpener(job, stop), notes);
  if (!job.estimates_normals) require_normals(*source, job);
  return source;
}

CloudInput scans_as_input(const RunControl& control, const CutStages& stages) {
  const ResolvedJob& job = control.job;
  return {
      .open = [&job, &stop = control.stop](auto* notes) { return open_scans(job, stop, notes); },
      .stages = stages,
      .are_scans = true,
      .order = {},
      .leaves_out_strays = !job.input.keep_strays,
      .scan_origins = origins_of_scans(job)};
}

}  // namespace orbweave
