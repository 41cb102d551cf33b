#include "engine/validation/attribute_facts.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace orbweave {
namespace {

/// The range of one attribute over the rows of a batch.
template <class T>
void widen(const std::byte* value, std::size_t row_bytes, std::size_t rows,
           std::optional<ValueRange>& range) {
  for (std::size_t i = 0; i < rows; ++i, value += row_bytes) {
    T stored;
    std::memcpy(&stored, value, sizeof stored);
    const auto number = static_cast<double>(stored);
    if (!std::isfinite(number)) continue;
    if (!range) range = ValueRange{number, number};
    range->min = std::min(range->min, number);
    range->max = std::max(range->max, number);
  }
}

}  // namespace

AttributeGatherer::AttributeGatherer(const PointSchema& schema)
    : class_(find_attribute(schema, "classification")),
      number_(find_attribute(schema, "return_number")),
      count_(find_attribute(schema, "number_of_returns")) {
  facts_.ranges.resize(schema.attributes.size());
  facts_.has_classes = class_.has_value();
  if (number_ && count_) facts_.returns.emplace();
}

void AttributeGatherer::add(const PointCloud& batch) {
  if (batch.empty() || facts_.ranges.empty()) return;
  add_ranges(batch);
  if (class_) add_classes(batch);
  if (facts_.returns) add_returns(batch);
}

void AttributeGatherer::add_ranges(const PointCloud& batch) {
  const std::byte* value = batch.attributes.data();
  const std::size_t row_bytes = batch.schema.attribute_bytes();
  for (std::size_t i = 0; i < facts_.ranges.size(); ++i) {
    const ScalarType type = batch.schema.attributes[i].type;
    visit_scalar(type, [&](auto zero) {
      widen<decltype(zero)>(value, row_bytes, batch.size(), facts_.ranges[i]);
    });
    value += size_of(type);
  }
}

void AttributeGatherer::add_classes(const PointCloud& batch) {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const double number = (*class_)(batch.attribute_row(i));
    if (number >= 0.0 && number < static_cast<double>(kPointClasses))
      ++facts_.classes[static_cast<std::size_t>(number)];
    else
      ++facts_.without_class;
  }
}

/// As the selection of returns takes them (io/clouds/scan_selection.h).
void AttributeGatherer::add_returns(const PointCloud& batch) {
  ReturnFacts& returns = *facts_.returns;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const double number = (*number_)(batch.attribute_row(i));
    const double count = (*count_)(batch.attribute_row(i));
    if (number <= 1.0) ++returns.first;
    if (number >= count) ++returns.last;
    if (count <= 1.0) ++returns.only;
    if (count > static_cast<double>(returns.most) && count < 1e6)
      returns.most = static_cast<std::uint64_t>(count);
  }
}

}  // namespace orbweave
