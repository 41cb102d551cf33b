// Raw scans of a known shape, as files with poses.
#pragma once

#include <string>
#include <vector>

#include "engine/synthetic/virtual_scanner.h"
#include "tests/support/jobs.h"

namespace orbweave::test {

struct RawScans {
  std::vector<std::string> files;  ///< each in its scanner's own coordinates, without normals
  std::string poses;               ///< a Stanford .conf
  double spacing = 0.0;            ///< distance between rays
};

/// Six views of a torus, with noise and misregistration in spacings.
RawScans scan_torus(const ScratchDirectory& scratch, std::uint64_t points, double noise,
                    double misregistration);

/// A job on them: estimated normals towards the scanners, automatic radii.
Job job_for(const ScratchDirectory& scratch, const RawScans& scans);

/// The same with everything that is done to raw points, in small chunks.
Job cleaning_job(const ScratchDirectory& scratch, std::uint64_t points);

}  // namespace orbweave::test
