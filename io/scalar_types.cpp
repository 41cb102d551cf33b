#include "io/scalar_types.h"

#include <array>

namespace orbweave {
namespace {

constexpr std::array<std::size_t, 10> kSizes = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
constexpr std::array<const char*, 10> kNames = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                                "uint32", "int64", "uint64", "float32", "float64"};

}  // namespace

std::size_t size_of(ScalarType type) { return kSizes[static_cast<std::size_t>(type)]; }
const char* name_of(ScalarType type) { return kNames[static_cast<std::size_t>(type)]; }

}  // namespace orbweave
