// Errors that a user can act on.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace orbweave {

/// What kind of failure an Error is. engine/cli/exit_status.h maps kinds to exit statuses.
enum class ErrorKind {
  kNone,        ///< no error; no Error has this kind
  kDefect,      ///< a defect in the program
  kUsage,       ///< wrong usage or job file
  kBadInput,    ///< bad input data
  kResource,    ///< out of memory budget, disk or another resource; work done is kept
  kInterrupted  ///< a request to stop; work done is kept
};

/// What went wrong, in the parts a user needs. Empty parts are left out of the message.
struct ErrorParts {
  std::string file{};      ///< path as the user gave it
  std::string place{};     ///< "line 7, column 3", "byte 1042", "key reconstruct.ball_radii"
  std::string found{};     ///< what was there
  std::string expected{};  ///< what should have been there
  std::string advice{};    ///< what to do
};

/// Every failure that is not a defect is thrown as an Error.
/// what() reads "<file>: <place>: <problem>; found <found>, expected <expected>. <advice>", one
/// line that is safe to print whatever names from files it holds (io/shown_text.h).
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& problem, ErrorParts parts = {});
  ErrorKind kind() const { return kind_; }
  const std::string& problem() const { return problem_; }
  const ErrorParts& parts() const { return parts_; }

 private:
  ErrorKind kind_;
  std::string problem_;
  ErrorParts parts_;
};

[[noreturn]] void throw_usage(const std::string& problem, ErrorParts parts = {});
[[noreturn]] void throw_bad_input(const std::string& problem, ErrorParts parts = {});
[[noreturn]] void throw_resource(const std::string& problem, ErrorParts parts = {});

}  // namespace orbweave
