#include "tests/support/raw_scans.h"

#include <filesystem>
#include <fstream>

#include "io/meshes/mesh_writer.h"
#include "io/text/quantity.h"

namespace orbweave::test {

RawScans scan_torus(const ScratchDirectory& scratch, std::uint64_t points, double noise,
                    double misregistration) {
  VirtualScannerOptions options;
  options.surface.shape = Shape::kTorus;
  options.surface.points = points;
  options.surface.noise = noise;
  options.scans = 6;
  options.misregistration = misregistration;
  const VirtualScanner scanner(options);
  RawScans scans{{}, (scratch / "scans.conf").string(), scanner.ray_distance()};
  std::ofstream poses(scans.poses);
  for (int k = 0; k < scanner.scans(); ++k) {
    const std::string name = "scan" + std::to_string(k) + ".ply";
    scans.files.push_back((scratch / name).string());
    write_cloud(scans.files.back(), read_all(*scanner.scan(k)));
    const ScannerPose& pose = scanner.pose(k);
    poses << "bmesh " << name;
    for (int axis = 0; axis < 3; ++axis) poses << ' ' << format_exact(pose.translation[axis]);
    for (const double part : pose.quaternion) poses << ' ' << format_exact(part);
    poses << '\n';
  }
  return scans;
}

Job job_for(const ScratchDirectory& scratch, const RawScans& scans) {
  Job job;
  job.input.files = scans.files;
  job.input.poses = scans.poses;
  job.output.mesh = (scratch / "mesh.ply").string();
  job.run.work_dir = (scratch / "work").string();
  job.reconstruct.levels = 2;
  return job;
}

Job cleaning_job(const ScratchDirectory& scratch, std::uint64_t points) {
  const RawScans scans = scan_torus(scratch, points, 0.2, 0.3);
  Job job = job_for(scratch, scans);
  job.partition.chunk_points = 500;
  job.cleaning.automatic = false;
  job.cleaning.outlier_sigma = 6.0;
  job.cleaning.smooth_radius = 2.5 * scans.spacing;
  job.cleaning.thin_to_spacing = 0.5 * scans.spacing;
  job.normals.orientation = Orientation::kPropagate;
  return job;
}

}  // namespace orbweave::test
