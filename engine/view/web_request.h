// What a web server answers to a request for a file of one folder (RFC 9110 and 9112).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace orbweave {

/// The longest head of a request, bytes.
inline constexpr std::size_t kMostRequestBytes = 16384;

struct WebAnswer {
  std::string head;         ///< status line and fields, with the empty line after them
  std::string text;         ///< sent after the head where no file is
  std::string file;         ///< of which bytes are sent; empty: none
  std::uint64_t first = 0;  ///< byte of the file
  std::uint64_t bytes = 0;  ///< how many
  bool closes = false;      ///< the connection, after the answer
};

/// `head`: of the request, to the empty line, inclusive. `size_of`: bytes of the folder's file of
/// this name, a plain one without slashes; empty: there is none. GET, HEAD and single ranges;
/// everything else, and any name of a host but of this machine's loopback, is refused: other
/// sites must not read the folder through the browser by a name of their own.
WebAnswer answer_request(
    std::string_view head,
    const std::function<std::optional<std::uint64_t>(const std::string&)>& size_of);

}  // namespace orbweave
