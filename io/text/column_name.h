// Names of columns in text clouds.
#pragma once

#include <string>
#include <string_view>

namespace orbweave {

/// The name that a column's role goes by ("Normal_X": "nx", "X[m]": "x"); any other name as it
/// stands.
std::string canonical_column_name(std::string_view name);

}  // namespace orbweave
