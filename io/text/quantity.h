// Quantities as people write and read them: bytes, counts, rates, durations. Locale-independent.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "io/vec3.h"

namespace orbweave {

/// Bytes from "2GiB", "512 MiB", "1.5GB" or "1000000" (then bytes). KiB, MiB, GiB, TiB and their
/// short forms K, M, G, T are powers of 1024; kB, MB, GB, TB are powers of 1000; upper and lower
/// case count the same. Fractions are cut off. Nothing where the text is no quantity, is negative
/// or exceeds 2^63 - 1.
std::optional<std::uint64_t> parse_bytes(std::string_view text);

std::string format_bytes(std::uint64_t bytes);  ///< "17 B", "1.5 GiB"
/// The shortest text that parse_bytes reads back as `bytes`: "4GiB", "1000001".
std::string exact_bytes(std::uint64_t bytes);
std::string format_count(std::uint64_t count);  ///< "437,645"
std::string format_rate(double per_second);   ///< "730", "1.25M": three digits, for a unit after it
std::string format_percent(double share);     ///< "12 %", "under 1 %"
std::string format_duration(double seconds);  ///< "0.4 s", "12 s", "3 min 20 s", "2 h 5 min"
/// A coordinate with ten significant digits: UTM coordinates to the tenth of a millimetre.
std::string format_coordinate(double value);
std::string format_position(Vec3 position);  ///< "(637000.5, 850100, 130)": coordinates as above
std::string format_number(double value);     ///< six significant digits at most
std::string format_exact(double value);      ///< shortest text that reads back as the value

}  // namespace orbweave
