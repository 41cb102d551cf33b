// The mark that some programs put before UTF-8.
#pragma once

#include <string_view>

namespace orbweave {

inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// The text behind the mark, where it begins with one.
inline std::string_view without_byte_order_mark(std::string_view text) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return text;
}

}  // namespace orbweave
