// The program: parses, builds, runs, and maps what went wrong to an exit status, here only.
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "engine/cli/command_line.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "io/error.h"

namespace {

using orbweave::ExitStatus;

int fail(ExitStatus status, const std::string& what) {
  orbweave::print_error(what);
  return static_cast<int>(status);
}

int fail_as_defect(const std::string& what) {
  return fail(ExitStatus::kDefect, "a defect in orbweave: " + what +
                                       "; please report it with the command line and the version "
                                       "(orbweave --version)");
}

orbweave::StopToken stop;

}  // namespace

int main(int argc, char** argv) {
  try {
    orbweave::handle_signals(stop);
    orbweave::parse_command_line({argv, argv + argc}, stop)();
    orbweave::flush_output();
    return static_cast<int>(ExitStatus::kDone);
  } catch (const orbweave::Error& error) {
    return fail(error.status(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(ExitStatus::kResource,
                "out of memory; give a smaller --memory or --chunk-points, or fewer --threads. "
                "What is done is kept, the same command resumes");
  } catch (const std::exception& error) {
    return fail_as_defect(error.what());
  } catch (...) {
    return fail_as_defect("an unknown exception");
  }
}
