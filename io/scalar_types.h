// The types of stored values, and the C++ types that hold them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace orbweave {

enum class ScalarType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64
};
std::size_t size_of(ScalarType type);  ///< bytes
const char* name_of(ScalarType type);  ///< "int8", "uint8", ... "float32", "float64"

/// Calls `visit` with a value of the C++ type that `type` stands for.
template <class Visitor>
void visit_scalar(ScalarType type, const Visitor& visit) {
  switch (type) {
    case ScalarType::kInt8:
      return visit(std::int8_t{});
    case ScalarType::kUint8:
      return visit(std::uint8_t{});
    case ScalarType::kInt16:
      return visit(std::int16_t{});
    case ScalarType::kUint16:
      return visit(std::uint16_t{});
    case ScalarType::kInt32:
      return visit(std::int32_t{});
    case ScalarType::kUint32:
      return visit(std::uint32_t{});
    case ScalarType::kInt64:
      return visit(std::int64_t{});
    case ScalarType::kUint64:
      return visit(std::uint64_t{});
    case ScalarType::kFloat32:
      return visit(float{});
    case ScalarType::kFloat64:
      return visit(double{});
  }
}

}  // namespace orbweave
