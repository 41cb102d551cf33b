// A value of a job as the user wrote it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace orbweave {

/// A value as the user wrote it, not yet checked against the key.
struct WrittenValue {
  using Scalar = std::variant<bool, std::int64_t, double, std::string>;
  enum class Shape { kScalar, kList, kOther };

  Shape shape = Shape::kScalar;  ///< kOther: a table, a date, a list of lists, ...
  /// One for a scalar, all of a list; name and value of a table with a single entry.
  std::vector<Scalar> items = {};
  std::string text = {};                      ///< as written, shortened for messages
  std::filesystem::path base_directory = {};  ///< relative paths are relative to it
};

/// The values of a choice, by their names.
using Choices = std::span<const char* const>;

/// Thrown by JobKey::set for an unsuitable value; the caller that knows file and line turns it
/// into an Error.
struct UnsuitableValue {
  std::string problem;   ///< empty: the value is of the wrong type or outside the range
  std::string expected;  ///< empty: the key's range
};

}  // namespace orbweave
