// The exit statuses of the programs.
#pragma once

#include <array>

#include "io/error.h"

namespace orbweave {

/// Part of the contract with users and scripts (docs).
enum class ExitStatus : int {
  kDone = 0,
  kDefect = 1,
  kUsage = 2,
  kBadInput = 3,
  kResource = 4,
  kInterrupted = 130
};

/// What each says, as manual pages and the reference have it.
struct ExitStatusFacts {
  ExitStatus status;
  const char* meaning;
};
inline constexpr std::array<ExitStatusFacts, 6> kExitStatuses = {{
    {ExitStatus::kDone, "done"},
    {ExitStatus::kDefect, "a defect in the program"},
    {ExitStatus::kUsage, "wrong usage or job file"},
    {ExitStatus::kBadInput, "bad input data"},
    {ExitStatus::kResource,
     "out of memory budget, disk or another resource; a job keeps what is done, and the same "
     "command resumes it"},
    {ExitStatus::kInterrupted,
     "interrupted; a job keeps what is done, and the same command resumes it"},
}};

constexpr ExitStatus exit_status(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kNone:
      return ExitStatus::kDone;
    case ErrorKind::kUsage:
      return ExitStatus::kUsage;
    case ErrorKind::kBadInput:
      return ExitStatus::kBadInput;
    case ErrorKind::kResource:
      return ExitStatus::kResource;
    case ErrorKind::kInterrupted:
      return ExitStatus::kInterrupted;
    case ErrorKind::kDefect:
      break;
  }
  return ExitStatus::kDefect;
}

}  // namespace orbweave
