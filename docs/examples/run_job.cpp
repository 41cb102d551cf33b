// Runs a job from files to a file, as `orbweave run` does: for clouds of any size, resumable.
#include <orbweave/mesh_reader.h>
#include <orbweave/mesh_writer.h>
#include <orbweave/run_job.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

namespace {

/// A scan to begin with.
void write_torus(const std::filesystem::path& file) {
  orbweave::PointCloud cloud;
  constexpr int kRings = 120, kAround = 48;
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kAround; ++j) {
      const double u = 6.283185307179586 * i / kRings, v = 6.283185307179586 * j / kAround;
      const double r = 1.0 + 0.4 * std::cos(v);
      cloud.positions.push_back({r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)});
    }
  }
  orbweave::write_cloud(file, cloud);
}

}  // namespace

int main() {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / "orbweave-example-run-job";
  std::filesystem::create_directories(folder);
  try {
    write_torus(folder / "scan.ply");
    orbweave::Job job;
    job.input.files = {(folder / "scan.ply").string()};
    job.partition.memory_bytes = std::uint64_t{1} << 30;
    job.output.mesh = (folder / "mesh.ply").string();
    const auto progress = orbweave::make_progress(orbweave::ProgressStyle::kPlain);
    const orbweave::RunReport report = orbweave::run_job(job, {.progress = progress.get()});
    const orbweave::TriangleMesh mesh = orbweave::read_mesh(job.output.mesh);
    std::printf("%zu triangles in %.1f s\n", mesh.triangles.size(), report.measured.seconds);
    return mesh.triangles.size() == report.mesh.triangles ? 0 : 1;
  } catch (const orbweave::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
