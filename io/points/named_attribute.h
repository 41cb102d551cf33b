// One attribute of points as numbers, whatever its type and the spelling of its name.
#pragma once

#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

#include "io/point_cloud.h"

namespace orbweave {

/// Where an attribute lies in the rows of a schema.
class NamedAttribute {
 public:
  NamedAttribute() = default;
  NamedAttribute(std::size_t offset, ScalarType type) : offset_(offset), type_(type) {}

  /// The value in a row of the schema.
  double operator()(std::span<const std::byte> row) const {
    double number = 0.0;
    visit_scalar(type_, [&](auto value) {
      std::memcpy(&value, row.data() + offset_, sizeof value);
      number = static_cast<double>(value);
    });
    return number;
  }
  std::size_t offset() const { return offset_; }
  ScalarType type() const { return type_; }

 private:
  std::size_t offset_ = 0;
  ScalarType type_ = ScalarType::kUint8;
};

/// Whether two names stand for the same attribute, in any case, with or without '_', and with or
/// without CloudCompare's "scalar_" in front.
bool have_same_name(std::string_view a, std::string_view b);

/// The first attribute of that name, in any case and with or without '_': "ReturnNumber" of PCD is
/// "return_number" of LAS. Where there is none, the first with "scalar_" in front; else nothing.
std::optional<NamedAttribute> find_attribute(const PointSchema& schema, std::string_view name);

}  // namespace orbweave
