// What a program says, and the status it ends with, when it ends by an exception.
#pragma once

#include <string>

#include "io/error.h"

namespace orbweave {

struct Failure {
  ExitStatus status = ExitStatus::kDefect;
  std::string what;
};

/// Of the exception that is being handled; called in a catch block. What is no Error, no lack of
/// memory and no refusal of the system is a defect, and says how to report it.
Failure current_failure();

}  // namespace orbweave
