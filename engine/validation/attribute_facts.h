// What the attributes of a cloud hold: ranges of values, classes, returns.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/points/named_attribute.h"
#include "io/points/point_classes.h"

namespace orbweave {

/// Smallest and largest value. Values that are not finite are passed over; empty: there is no
/// other.
struct ValueRange {
  double min = 0.0;
  double max = 0.0;
};

/// Points by their return; return numbers and numbers of returns that are 0 count as 1.
struct ReturnFacts {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t only = 0;
  std::uint64_t most = 0;  ///< largest number of returns of a pulse
};

struct AttributeFacts {
  std::vector<std::optional<ValueRange>> ranges;       ///< in the order of the schema
  bool has_classes = false;                            ///< there is an attribute `classification`
  std::array<std::uint64_t, kPointClasses> classes{};  ///< points by class
  std::uint64_t without_class = 0;                     ///< value is no class from 0 to 255
  std::optional<ReturnFacts> returns;  ///< empty: no `return_number` and `number_of_returns`
};

/// Gathers them, batch by batch of one schema.
class AttributeGatherer {
 public:
  explicit AttributeGatherer(const PointSchema& schema);
  void add(const PointCloud& batch);
  const AttributeFacts& facts() const { return facts_; }

 private:
  void add_ranges(const PointCloud& batch);
  void add_classes(const PointCloud& batch);
  void add_returns(const PointCloud& batch);

  std::optional<NamedAttribute> class_, number_, count_;
  AttributeFacts facts_;
};

}  // namespace orbweave
