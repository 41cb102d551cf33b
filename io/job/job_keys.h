// The job file's keys: one table that parsing, help texts, command line options and the report
// all come from.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "io/job/job.h"
#include "io/job/written_value.h"

namespace orbweave {

/// A key's value in a Job.
using JobValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>,
                              std::vector<std::string>>;

enum class JobKeyType {
  kTexts,
  kPath,
  kDirectory,  ///< a path, too, of a directory that the program makes
  kPaths,
  kFlag,
  kChoice,
  kInteger,
  kBytes,
  kNumber,
  kNumbers,
  kColor,
  kSimplification
};

/// What a key accepts, for programs: the schema of job files is made of it (io/job/job_schema.h).
/// The `set` of the key decides; a test holds the two against each other.
struct JobKeyLimits {
  double least = -std::numeric_limits<double>::infinity();  ///< of a number, or of each of a list
  double most = std::numeric_limits<double>::infinity();    ///< likewise
  bool is_above = false;                                    ///< `least` itself is not accepted
  bool has_zero = false;                                    ///< 0 as well, below `least`
  bool is_whole = false;                                    ///< the numbers of a list are integers
  Choices words = {};                 ///< texts in the place of a value: "auto"
  std::span<const int> values = {};   ///< the only integers; empty: all between the limits
  std::span<const int> lengths = {};  ///< of a list; empty: any
  int least_length = 0;               ///< of a list
};

/// One key. Texts are for people and in the key's own terms.
struct JobKey {
  const char* section;
  const char* key;
  JobKeyType type;
  const char* range;         ///< what is accepted: "an integer from 1 to 8"; "" of a choice
  Choices choices;           ///< the values of a choice; empty of other types
  const char* help;          ///< one line, without the range
  const char* option;        ///< of `reconstruct`, without dashes; "" where it has none
  const char* option_value;  ///< what the bare option stands for; "" where it takes a value
  void (*set)(Job&, const WrittenValue&);  ///< throws UnsuitableValue
  JobValue (*get)(const Job&);
  JobKeyLimits limits = {};

  std::string name() const { return std::string(section) + "." + key; }
  /// What is accepted, for messages.
  std::string expected() const;
  /// The default as it would be written in a job file.
  std::string default_text() const;
};

/// All keys, those of a section side by side, in the order of the documentation.
std::span<const JobKey> job_keys();

/// A former name of a section, which job files may use.
struct FormerSection {
  std::string_view former;
  std::string_view section;
};
std::span<const FormerSection> former_sections();

/// The section that a name in a job file stands for: a former name of a section, else the name.
std::string_view current_section(std::string_view section);
/// Likewise of a whole key, "section.key".
std::string current_key_name(std::string_view name);
/// The name of a key in what work directories store. A renamed section keeps its first name there,
/// so that work directories of earlier versions resume.
std::string stored_key_name(std::string_view name);

/// "true or false", "text", "list of numbers", ...
const char* type_name(JobKeyType type);

/// The value as it is written in a job file; bytes get their unit.
std::string value_text(const JobValue& value, JobKeyType type);

}  // namespace orbweave
