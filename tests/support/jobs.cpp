#include "tests/support/jobs.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

#include "io/error.h"
#include "io/meshes/mesh_writer.h"

namespace orbweave::test {

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  REQUIRE(stream);
  std::ostringstream all;
  all << stream.rdbuf();
  return all.str();
}

void damage(const std::filesystem::path& victim) {
  std::fstream file(victim, std::ios::in | std::ios::out | std::ios::binary);
  const auto middle = static_cast<std::streamoff>(std::filesystem::file_size(victim) / 2);
  file.seekg(middle);
  const int byte = file.get();
  file.seekp(middle);
  file.put(static_cast<char>(byte ^ 0x40));
}

std::size_t results_in(const std::filesystem::path& directory) {
  std::size_t files = 0;
  std::error_code ignored;  // a job at work removes what the walk is about to see
  for (std::filesystem::recursive_directory_iterator at(directory, ignored), end;
       !ignored && at != end; at.increment(ignored))
    files += at->path().extension() == ".h5" ? 1 : 0;
  return files;
}

void paint(PointCloud& cloud) {
  cloud.schema.attributes = {{"red", ScalarType::kUint8}, {"intensity", ScalarType::kFloat32}};
  for (const Vec3& p : cloud.positions) {
    const auto red = static_cast<std::uint8_t>(std::abs(p.x) * 100.0);
    const auto intensity = static_cast<float>(p.y + 2.0 * p.z);
    const auto* bytes = reinterpret_cast<const std::byte*>(&intensity);
    cloud.attributes.push_back(std::byte{red});
    cloud.attributes.insert(cloud.attributes.end(), bytes, bytes + sizeof intensity);
  }
}

void shuffle(PointCloud& cloud, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::size_t> order(cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  PointCloud shuffled;
  shuffled.schema = cloud.schema;
  for (const std::size_t i : order) shuffled.append(cloud, i);
  cloud = std::move(shuffled);
}

Job job_for(const ScratchDirectory& scratch, const NamedCloud& named,
            std::vector<std::string> files) {
  Job job;
  if (files.empty()) {
    files = {(scratch / "cloud.ply").string()};
    write_cloud(files.front(), named.cloud);
  }
  job.input.files = std::move(files);
  job.output.mesh = (scratch / "mesh.ply").string();
  job.run.work_dir = (scratch / "work").string();
  job.reconstruct.ball_radii = {named.ball_radius, 1.5 * named.ball_radius,
                                2.25 * named.ball_radius};
  return job;
}

RunReport run(const Job& job) {
  RecordingProgress progress;
  const StopToken stop;
  return run_job(job, {"test"}, progress, stop);
}

void run_until(const Job& job, const std::string& stage) {
  RecordingProgress progress;
  StopToken stop;
  progress.at_stage = [&](const std::string& name) {
    if (name == stage) stop.request();
  };
  try {
    run_job(job, {"test"}, progress, stop);
  } catch (const Error& error) {
    INFO(error.what());
    REQUIRE(error.kind() == ErrorKind::kInterrupted);
    return;
  }
  FAIL("there was no stage " << stage);
}

std::string mesh_bytes(const Job& job) {
  run(job);
  return bytes_of(job.output.mesh);
}

int run_with_interruptions(const Job& job, int first_step, int step) {
  constexpr int kMost = 200;
  for (int interruptions = 0; interruptions < kMost; ++interruptions) {
    StopToken stop;
    std::atomic<int> steps{0};
    RecordingProgress progress;
    progress.at_step = [&] {
      if (++steps == first_step + interruptions * step) stop.request();
    };
    try {
      run_job(job, {"test"}, progress, stop);
      return interruptions;
    } catch (const Error& error) {
      REQUIRE(error.kind() == ErrorKind::kInterrupted);
    }
    REQUIRE_FALSE(std::filesystem::exists(job.output.mesh));
    REQUIRE(std::filesystem::exists(job.run.work_dir));
  }
  FAIL("interrupted runs do not get on");
  return kMost;
}

NamedCloud painted_torus(std::size_t points, double noise, std::uint64_t seed) {
  NamedCloud named = noisy_torus(points, noise, seed);
  paint(named.cloud);
  return named;
}

}  // namespace orbweave::test
