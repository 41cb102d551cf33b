// A job file with every key, its explanation and its default: to copy, and to read.
#pragma once

#include <string>

namespace orbweave {

/// The text of the file. parse_job() reads it as the default Job.
std::string commented_job_file();

}  // namespace orbweave
