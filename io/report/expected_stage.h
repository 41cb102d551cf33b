// A stage that a job is still to run.
#pragma once

#include <string>

namespace orbweave {

struct ExpectedStage {
  std::string name;
  double seconds = 0.0;  ///< that it typically takes
};

}  // namespace orbweave
