// What a user can do about a refusal of the system.
#pragma once

#include <exception>
#include <string>

namespace orbweave {

/// What helps where the system refused with `error`, a value of errno: room for a full disk, a
/// higher limit where a limit was reached, `elsewhere` where another place helps. Begins like a
/// sentence and ends without its stop.
std::string advice_on(int error, const std::string& elsewhere = "write it elsewhere");

/// The same about the work directory, which keeps what is done.
std::string advice_on_work_directory(int error);

/// Whether `error` says that a limit of the process or the machine was reached: nothing is wrong
/// with the file then.
bool is_lack(int error);

/// Whether `error` says that a device or a network failed: nothing is known to be wrong with the
/// file then.
bool is_failure(int error);

/// Whether the standard library or the scheduler could start no thread.
bool is_lack_of_threads(const std::exception& error);

}  // namespace orbweave
