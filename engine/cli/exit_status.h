// The exit statuses of the programs.
#pragma once

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
