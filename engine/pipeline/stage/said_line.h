// A line that a run says about its work.
#pragma once

#include <string>

namespace orbweave {

struct SaidLine {
  std::string shown;  ///< on the terminal
  std::string full;   ///< in the report
  bool is_warning = false;
};

}  // namespace orbweave
