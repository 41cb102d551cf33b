// A small file that is written beside others.
#pragma once

#include <string>

namespace orbweave {

struct NamedText {
  std::string name;  ///< of the file, without a folder
  std::string text;
};

}  // namespace orbweave
