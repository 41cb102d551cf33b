#include "engine/cli/failure.h"

#include <exception>
#include <new>
#include <system_error>

namespace orbweave {
namespace {

Failure defect(const std::string& what) {
  return {ExitStatus::kDefect, "a defect in orbweave: " + what +
                                   "; please report it with the command line and the version "
                                   "(orbweave --version)"};
}

}  // namespace

Failure current_failure() {
  try {
    throw;
  } catch (const Error& error) {
    return {error.status(), error.what()};
  } catch (const std::bad_alloc&) {
    return {ExitStatus::kResource,
            "out of memory; give a smaller --memory or --chunk-points, or fewer --threads. "
            "What is done is kept, the same command resumes"};
  } catch (const std::system_error& error) {
    return {ExitStatus::kResource, std::string("the system refused: ") + error.what() +
                                       ". What is done is kept, the same command resumes"};
  } catch (const std::exception& error) {
    return defect(error.what());
  } catch (...) {
    return defect("an unknown exception");
  }
}

}  // namespace orbweave
