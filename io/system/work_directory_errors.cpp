#include "io/system/work_directory_errors.h"

#include "io/error.h"
#include "io/system/file_descriptor.h"
#include "io/system/system_advice.h"

namespace orbweave {

void throw_refusal(const char* problem, const std::filesystem::path& path, int reason) {
  throw_resource(problem, {.file = path.string(),
                           .found = reason != 0 ? system_reason(reason) : "an HDF5 failure",
                           .advice = advice_on_work_directory(reason)});
}

void throw_write_error(const std::filesystem::path& path, int reason) {
  throw_refusal("cannot write to the work directory", path, reason);
}

void throw_read_error(const std::filesystem::path& path, int reason) {
  throw_refusal("cannot read from the work directory", path, reason);
}

void throw_directory_error(const std::filesystem::path& path, int reason) {
  throw_refusal("cannot use the work directory", path, reason);
}

void throw_directory_error(const std::filesystem::path& path, const std::string& reason) {
  throw_resource("cannot use the work directory",
                 {.file = path.string(),
                  .found = reason,
                  .advice = "Name another with run.work_dir or --work-dir"});
}

}  // namespace orbweave
