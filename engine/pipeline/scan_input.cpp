#include "engine/pipeline/scan_input.h"

#include <filesystem>

#include "io/error.h"
#include "io/scan_source.h"

namespace orbweave {
namespace {

/// Range scans of the Stanford repository are taken along their -z axis from far away.
constexpr ScannerPlace kStanfordScanner{{0.0, 0.0, 1.0}, true};
/// Everybody else has the scanner at the origin of its own coordinates.
constexpr ScannerPlace kOriginScanner{{0.0, 0.0, 0.0}, false};

bool wants_view(const Job& job, bool estimates) {
  return estimates && (job.normals.orientation == Orientation::kAuto ||
                       job.normals.orientation == Orientation::kScanner);
}

/// What all scans of the job have in common, and their poses.
class ScanOpener {
 public:
  ScanOpener(const Job& job, bool estimates) : job_(job), poses_(job.input.pose) {
    common_.scanner = job.input.scanner;
    common_.with_view = wants_view(job, estimates);
    common_.without_normals = estimates;
    common_.without_attributes = !job.output.attributes;
    common_.classes = job.input.las_classes;
    common_.returns = job.input.returns;
    if (!poses_.empty()) common_.usual_scanner = kOriginScanner;
    if (job.input.poses.empty()) return;
    common_.usual_scanner = kStanfordScanner;
    for (ScanPose& pose : read_stanford_poses(job.input.poses)) poses_.push_back(std::move(pose));
  }

  std::unique_ptr<PointSource> operator()(const std::filesystem::path& path) const {
    ScanOptions options = common_;
    options.motion = pose_of_scan(poses_, path);
    return open_scan_source(open_point_source(path, {job_.input.text}), options, path.string());
  }

 private:
  const Job& job_;
  std::vector<ScanPose> poses_;
  ScanOptions common_;
};

void require_normals(const PointSource& source, const InputContext& context) {
  if (source.schema().has_normals) return;
  throw_bad_input("the cloud has no normals",
                  {.file = context.files.front(),
                   .place = {},
                   .found = "points without nx, ny, nz",
                   .expected = "a normal per point, as normals.source = \"file\" asks for",
                   .advice = "Have them estimated: normals.source = \"estimate\"."});
}

}  // namespace

bool estimates_normals(const InputContext& context) {
  switch (context.job.normals.source) {
    case NormalSource::kFile:
      return false;
    case NormalSource::kEstimate:
      return true;
    case NormalSource::kAuto:
      break;
  }
  return !open_point_source(context.files.front(), {context.job.input.text})->schema().has_normals;
}

std::unique_ptr<PointSource> open_scans(const InputContext& context,
                                        std::vector<std::string>* notes) {
  const std::vector<std::filesystem::path> paths(context.files.begin(), context.files.end());
  const bool estimates = estimates_normals(context);
  auto source = open_point_sources(paths, ScanOpener(context.job, estimates), notes);
  if (!estimates) require_normals(*source, context);
  return source;
}

}  // namespace orbweave
