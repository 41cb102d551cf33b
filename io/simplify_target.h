// How far a mesh is to be simplified, as users write it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "io/surface_options.h"

namespace orbweave {

/// What each kind accepts, for messages: "a number above 0 and at most 1".
const char* accepted_by(SimplifyTarget::Kind kind);
bool is_accepted(const SimplifyTarget& target);

/// Of "ratio=0.1", "triangles=50000" or "error=0.02", blanks and a pair of braces aside. Nothing
/// where the text is none of these, or the number is not accepted.
std::optional<SimplifyTarget> parse_simplify_target(std::string_view text);
/// "ratio=0.1": what parse_simplify_target() reads back.
std::string simplify_target_text(const SimplifyTarget& target);

/// Most triangles of a mesh of `triangles`, at least 1. Precondition: the target is no error.
std::uint64_t most_triangles(const SimplifyTarget& target, std::uint64_t triangles);

}  // namespace orbweave
