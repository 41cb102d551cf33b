// Names that no other process chooses.
#pragma once

#include <string>

namespace orbweave {

/// 64 random bits as 16 hexadecimal digits.
std::string random_word();

}  // namespace orbweave
