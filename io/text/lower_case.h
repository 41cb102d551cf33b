// Letters without their case, whatever the locale.
#pragma once

#include <string>

namespace orbweave {

/// `text` with the capital letters of ASCII as small ones.
inline std::string lower_case(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace orbweave
