// The job file's keys: one table that parsing, help texts, command line options and the report
// all come from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "io/job.h"

namespace orbweave {

/// A key's value in a Job.
using JobValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>,
                              std::vector<std::string>>;

/// A value as somebody wrote it, before anyone knows whether it suits the key.
struct WrittenValue {
  using Scalar = std::variant<bool, std::int64_t, double, std::string>;
  enum class Shape { kScalar, kList, kOther };

  Shape shape = Shape::kScalar;               ///< kOther: a table, a date, a list of lists, ...
  std::vector<Scalar> items = {};             ///< one for a scalar, all of a list
  std::string text = {};                      ///< as written, shortened for messages
  std::filesystem::path base_directory = {};  ///< relative paths are relative to it
};

/// Thrown by JobKey::set for a value that does not suit; whoever knows file and line turns it
/// into an Error.
struct UnsuitableValue {
  std::string problem;   ///< empty: the value is of the wrong type or outside the range
  std::string expected;  ///< empty: the key's range
};

enum class JobKeyType {
  kTexts,
  kPath,
  kPaths,
  kFlag,
  kChoice,
  kInteger,
  kBytes,
  kNumber,
  kNumbers,
  kColor
};

/// One key. Texts are for people and in the key's own terms.
struct JobKey {
  const char* section;
  const char* key;
  JobKeyType type;
  const char* range;         ///< what is accepted: "an integer from 1 to 8"
  const char* help;          ///< one line, without the range
  const char* option;        ///< of `reconstruct`, without dashes; "" where it has none
  const char* option_value;  ///< what the bare option stands for; "" where it takes a value
  void (*set)(Job&, const WrittenValue&);  ///< throws UnsuitableValue
  JobValue (*get)(const Job&);

  std::string name() const { return std::string(section) + "." + key; }
  /// The default as it would be written in a job file.
  std::string default_text() const;
};

/// All keys, those of a section side by side, in the order of the documentation.
std::span<const JobKey> job_keys();

/// "true or false", "text", "list of numbers", ...
const char* type_name(JobKeyType type);

/// The value as it is written in a job file; bytes get their unit.
std::string value_text(const JobValue& value, JobKeyType type);

}  // namespace orbweave
