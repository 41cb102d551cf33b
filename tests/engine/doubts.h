// Jobs whose result is in doubt, and what is said of them.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "engine/planning/plan_job.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

namespace orbweave::test {

inline Job job_without_fill(const ScratchDirectory& scratch, const NamedCloud& named) {
  Job job = job_for(scratch, named);
  job.reconstruct.ball_radii.clear();
  job.fill.enabled = false;
  return job;
}

inline bool warns_of(const Job& job, const std::string& what) {
  const std::vector<std::string> warnings = run(job).warnings;
  return std::ranges::any_of(warnings, [&](const std::string& warning) {
    return warning.find(what) != std::string::npos;
  });
}

/// Whether a plan says so beforehand.
inline bool doubts(const Job& job, const std::string& words) {
  RecordingProgress progress;
  const StopToken stop;
  const std::vector<std::string> all = plan_job(job, progress, stop).doubts;
  return std::ranges::any_of(
      all, [&](const std::string& doubt) { return doubt.find(words) != std::string::npos; });
}

/// A sheet of points 0.05 apart, neither on a lattice nor in a row.
inline NamedCloud uneven_sheet(Vec3 corner) {
  Random random(5);
  NamedCloud named;
  named.ball_radius = 0.07;
  named.cloud.schema.has_normals = true;
  for (int i = 0; i < 3600; ++i) {
    const Vec3 place{0.05 * (i % 60) + 0.02 * random.uniform(),
                     0.05 * (i / 60) + 0.02 * random.uniform(), 0.001 * random.uniform()};
    named.cloud.positions.push_back(corner + place);
    named.cloud.normals.push_back({0, 0, 1});
  }
  put_in_order(named.cloud);
  return named;
}

inline PointCloud as_floats(PointCloud cloud) {
  for (Vec3& p : cloud.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<double>(static_cast<float>(p[axis]));
  put_in_order(cloud);
  return cloud;
}

/// The two sides of a plate, exact, a number of grid steps apart.
inline NamedCloud thin_plate(double steps) {
  NamedCloud named;
  named.ball_radius = 1.1;
  named.cloud.schema.has_normals = true;
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j)
      for (const double side : {-1.0, 1.0}) {
        named.cloud.positions.push_back({1.0 * i, 1.0 * j, 0.5 * side * steps});
        named.cloud.normals.push_back({0, 0, side});
      }
  put_in_order(named.cloud);
  return named;
}

/// What reading and cleaning `job` says when it is interrupted at a stage and resumed.
inline RunReport resumed_at(const Job& job, const std::string& stage) {
  run_until(job, stage);
  return run(job);
}

}  // namespace orbweave::test
