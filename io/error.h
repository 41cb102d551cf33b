// Errors that a user can act on, and the exit status each one leads to.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace orbweave {

/// The program's exit statuses; part of the contract with users and scripts.
enum class ExitStatus : int {
  kDone = 0,
  kDefect = 1,        ///< a defect in the program
  kUsage = 2,         ///< wrong usage or job file
  kBadInput = 3,      ///< bad input data
  kResource = 4,      ///< out of memory budget, disk or another resource; work done is kept
  kInterrupted = 130  ///< SIGINT or SIGTERM; work done is kept
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
/// what() reads "<file>: <place>: <problem>; found <found>, expected <expected>. <advice>".
class Error : public std::runtime_error {
 public:
  Error(ExitStatus status, const std::string& problem, ErrorParts parts = {});
  ExitStatus status() const { return status_; }
  const ErrorParts& parts() const { return parts_; }

 private:
  ExitStatus status_;
  ErrorParts parts_;
};

[[noreturn]] void throw_usage(const std::string& problem, ErrorParts parts = {});
[[noreturn]] void throw_bad_input(const std::string& problem, ErrorParts parts = {});
[[noreturn]] void throw_resource(const std::string& problem, ErrorParts parts = {});

}  // namespace orbweave
