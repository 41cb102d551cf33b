// Names of columns in text clouds.
#pragma once

#include <string>
#include <string_view>

namespace orbweave {

/// The name of a column without the unit in brackets behind it: "X" of "X[m]" and "X (m)".
std::string_view without_unit(std::string_view name);

/// The name that a column's role goes by ("Normal_X": "nx", "X[m]": "x"); any other name as it
/// stands.
std::string canonical_column_name(std::string_view name);

}  // namespace orbweave
