// What the mesh of a run is worth, in one line.
#pragma once

#include <string>

#include "io/report/report_facts.h"

namespace orbweave {

struct Verdict {
  /// Sentences: whether the surface is closed, how far its patches can be trusted, whether anything
  /// crosses, whether the run warned.
  std::string text;
  bool is_clean = false;  ///< watertight, nothing doubtful, nothing crosses, no warning
};
Verdict verdict_of(const RunReport& report);

}  // namespace orbweave
