// Jobs on small clouds, for tests of the pipeline.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/pipeline/pipeline.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"

namespace orbweave::test {

/// Collects what a user would be told; calls back when a stage begins, and at every step.
class RecordingProgress : public Progress {
 public:
  std::function<void(const std::string& stage)> at_stage;
  std::function<void()> at_step;
  std::vector<std::string> stages;
  std::vector<std::string> lines;

  void begin_stage(const std::string& name, std::uint64_t, const std::string&) override {
    stages.push_back(name);
    if (at_stage) at_stage(name);
    step();
  }
  void advance(std::uint64_t) override { step(); }
  void add_points(std::uint64_t) override {}
  void end_stage() override { step(); }
  void note(const std::string& line) override { lines.push_back(line); }
  void warn(const std::string& line) override { lines.push_back(line); }

 private:
  void step() {
    if (at_step) at_step();
  }
};

std::string bytes_of(const std::filesystem::path& file);
/// Flips a bit in the middle of the file.
void damage(const std::filesystem::path& file);
/// Results that are committed in a work directory, or in a stage of it; 0 where there is none.
std::size_t results_in(const std::filesystem::path& directory);

/// Colours that follow from the position, so that a mix-up of rows shows.
void paint(PointCloud& cloud);
void shuffle(PointCloud& cloud, std::uint64_t seed);
NamedCloud painted_torus(std::size_t points, double noise, std::uint64_t seed);

/// A job in the scratch directory at three radii; writes the cloud there unless files are given.
Job job_for(const ScratchDirectory& scratch, const NamedCloud& named,
            std::vector<std::string> files = {});
RunReport run(const Job& job);
/// Runs the job until a stage begins, and stops it there.
void run_until(const Job& job, const std::string& stage);
/// Runs the job and returns the bytes of its mesh file.
std::string mesh_bytes(const Job& job);

/// Runs the job again and again, each time interrupted some steps later, until it ends. Returns how
/// often it was interrupted; every interrupted run has to keep its work directory and leave no
/// mesh.
int run_with_interruptions(const Job& job, int first_step, int step);

}  // namespace orbweave::test
