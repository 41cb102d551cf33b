#include "engine/cli/generated_scans.h"

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "io/meshes/shift_file.h"
#include "io/shown_text.h"
#include "io/system/atomic_file.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchPoints = std::size_t{1} << 18;

/// "scans.ply" and "_2" give "scans_2.ply"; a .gz behind the extension moves along.
std::string beside(const std::string& path, const std::string& ending, bool keep_extension) {
  std::filesystem::path stem = path;
  std::string extension = stem.extension().string();
  stem.replace_extension();
  if (extension == ".gz") {
    extension = stem.extension().string() + extension;
    stem.replace_extension();
  }
  return stem.string() + ending + (keep_extension ? extension : "");
}

std::string scan_file(const std::string& out, int scan) {
  return beside(out, "_" + std::to_string(scan), true);
}

std::string pose_file(const std::string& out, PoseFile poses) {
  return beside(out, poses == PoseFile::kStanford ? ".conf" : ".toml", false);
}

std::string name_in_folder(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// "FILE tx ty tz qx qy qz qw".
std::string pose_text(const std::string& path, Vec3 translation,
                      const std::array<double, 4>& quaternion) {
  std::string text = name_in_folder(path);
  for (int axis = 0; axis < 3; ++axis) text += " " + format_exact(translation[axis]);
  for (const double part : quaternion) text += " " + format_exact(part);
  return text;
}

/// A text of JSON is one of TOML.
std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

struct WrittenScan {
  std::string path;
  ScannerPose pose;
};

std::string stanford_poses(const std::vector<WrittenScan>& scans) {
  std::string text;
  for (const auto& [path, pose] : scans)
    text += "bmesh " + pose_text(path, pose.translation, pose.quaternion) + "\n";
  return text;
}

/// A job file's quaternion turns scan coordinates to the world's, not the other way round.
std::string job_with_poses(const std::vector<WrittenScan>& scans, const std::string& out) {
  std::string files, lines;
  for (const auto& [path, pose] : scans) {
    const auto& [x, y, z, w] = pose.quaternion;
    files += "  " + quoted(name_in_folder(path)) + ",\n";
    lines += "  " + quoted(pose_text(path, pose.translation, {-x, -y, -z, w})) + ",\n";
  }
  const std::string mesh = name_in_folder(beside(out, "-mesh.ply", false));
  return "[input]\nfiles = [\n" + files + "]\npose = [\n" + lines +
         "]\n\n[output]\nmesh = " + quoted(mesh) + "\n";
}

}  // namespace

void write_points(PointSource& source, const std::string& path, const PointFiles& files,
                  const StopToken& stop) {
  const std::uint64_t points = source.declared_points().value_or(0);
  const MeshHeader header{.vertices = points, .is_cloud = true, .schema = source.schema()};
  const auto writer = open_mesh_writer(path, header, files.format);
  for (PointCloud batch; source.read(batch, kBatchPoints);) {
    check_interruption(stop);
    writer->write_vertices(batch);
  }
  writer->finish();
  write_shift(path, {});
  note_written(path);
  if (path != "-")
    std::cout << shown(path) << ": " << counted(points, "point", "points") << ", "
              << format_number(files.spacing) << " apart\n";
}

void write_separate_scans(const RangeScans& scans, const std::string& out, PoseFile poses,
                          const PointFiles& files, const StopToken& stop) {
  std::vector<WrittenScan> written;
  for (int scan = 0; scan < scans.scans(); ++scan) {
    const std::string path = scan_file(out, scan);
    if (scans.points(scan) == 0) {
      std::cout << shown(path) << ": not written, the scanner sees nothing from there\n";
      continue;
    }
    write_points(*scans.scan(scan), path, files, stop);
    written.push_back({path, scans.pose(scan)});
  }
  const bool is_stanford = poses == PoseFile::kStanford;
  const std::string path = pose_file(out, poses);
  AtomicFile file(path);
  file.write(is_stanford ? stanford_poses(written) : job_with_poses(written, out));
  file.commit();
  note_written(path);
  std::cout << shown(path) << (is_stanford ? ": poses\n" : ": job file with the poses\n");
}

std::vector<PathRole> separate_scan_files(const std::string& out, int scans, PoseFile poses) {
  std::vector<PathRole> files;
  for (int scan = 0; scan < scans; ++scan)
    files.push_back({"scan " + std::to_string(scan), scan_file(out, scan), PathUse::kWrittenFile});
  files.push_back({"the file of poses", pose_file(out, poses), PathUse::kWrittenFile});
  return files;
}

}  // namespace orbweave
