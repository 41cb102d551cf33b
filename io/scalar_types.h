// From the type of a value, as a schema names it, to the type that holds it.
#pragma once

#include <cstdint>

#include "io/point_cloud.h"

namespace orbweave {

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
