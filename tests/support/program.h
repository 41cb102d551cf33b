// Runs the built program as a user would: arguments in, output and exit status out.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/data.h"

namespace orbweave::test {

struct ProgramResult {
  int status = -1;  ///< exit status; 128 + signal where a signal ended it
  std::string out;  ///< standard output
  std::string err;  ///< standard error
};

struct ProgramSetting {
  std::filesystem::path directory = {};       ///< to run in; empty: the current one
  std::vector<std::string> environment = {};  ///< "NAME=value", beside the inherited ones
  std::filesystem::path out_to = {};   ///< standard output goes to this device; empty: captured
  std::filesystem::path program = {};  ///< that is run; empty: orbweave of this build
};

/// A program that runs; its output goes to files that nobody else sees. Destroyed while it
/// still runs, it is killed.
class RunningProgram {
 public:
  explicit RunningProgram(const std::vector<std::string>& arguments,
                          const ProgramSetting& setting = {});
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  void send(int signal);
  pid_t process() const { return process_; }
  bool running();
  /// Waits for its end.
  ProgramResult wait();

  /// Stops it (SIGSTOP): all of it stands still on return. False where it has ended.
  bool hold();
  /// Lets it go on; what was sent meanwhile reaches it first.
  void release();
  /// Releases it until it has used a millisecond of processor time, or had time enough for that.
  void run_a_moment();
  /// Runs it a moment at a time, whatever the machine's speed and load, until `reached`: it is held
  /// then. False where it ended before; on a busy machine a moment may be a long one, so that
  /// tests try again. `pause_ms`: how long it is held between two moments.
  bool hold_when(const std::function<bool()>& reached, int pause_ms = 0);

 private:
  void collect(int options);

  pid_t process_ = -1;
  bool ended_ = false;
  bool held_ = false;
  int status_ = -1;
  int out_ = -1;  ///< unlinked files that standard output and error go to
  int err_ = -1;
};

/// Runs orbweave to its end.
ProgramResult run_program(const std::vector<std::string>& arguments,
                          const ProgramSetting& setting = {});
/// The same in a scratch directory.
ProgramResult run_in(const ScratchDirectory& in, const std::vector<std::string>& arguments);

/// The same after a limit of the shell, such as "ulimit -n 12".
ProgramResult run_limited(const ScratchDirectory& in, const std::string& limit,
                          const std::vector<std::string>& arguments);

/// Names of what a scratch directory holds, sorted.
std::vector<std::string> names_in(const ScratchDirectory& in);

/// The whole content of a file; empty where it cannot be read.
std::string file_text(const std::filesystem::path& path);
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace orbweave::test
