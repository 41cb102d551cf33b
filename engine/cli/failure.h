// What a program says, and the kind of failure that decides its exit status, when it ends by an
// exception.
#pragma once

#include <string>

#include "io/error.h"

namespace orbweave {

struct Failure {
  ErrorKind kind = ErrorKind::kDefect;
  std::string what;
};

/// Of the exception that is being handled; called in a catch block. What is no Error, no lack of
/// memory and no refusal of the system is a defect, and says how to report it.
Failure current_failure();

/// To be called by a command that has a work directory and resumes from it. Messages about an
/// interruption or a lack of memory or threads then say that what is done is kept. Without it an
/// interruption says what was written (engine/cli/signals.h).
void promise_to_resume();

/// From now on an exception that nothing catches ends the process with a plain message and the
/// status that current_failure() has for it, without a core: such as that a thread cannot be
/// started in a library that lets no exception out, or that no memory is left to say what happened.
/// Where the address space is limited (ulimit -v), so does a library's crash when it is used up.
void end_plainly_when_nothing_catches();

/// Put in front of a program's main(), has that happen before shared libraries are initialised: one
/// that OpenVDB needs starts threads then.
#define ORBWEAVE_END_PLAINLY_FROM_THE_START                                     \
  [[gnu::section(".preinit_array"), gnu::used]] void (*const before_libraries)( \
      int, char**, char**) = [](int, char**, char**) {                          \
    orbweave::end_plainly_when_nothing_catches();                               \
  }

}  // namespace orbweave
