// Names of pictures and reports.
#pragma once

#include <filesystem>
#include <string>

#include "io/job/job.h"

namespace orbweave {

/// Throws Error (usage) for the name of a file that is not said to be PNG. Devices and pipes, which
/// may have any name, pass, and so does an empty path.
void check_picture_name(const std::filesystem::path& picture);

/// Throws Error (usage) for standard output and for the name of a page, which lies beside a report.
/// `place`: what the user named it by.
void check_report_name(const std::filesystem::path& report, const std::string& place);

/// Both of a job; `place`: of the report's name.
void check_output_names(const OutputOptions& output, const std::string& place);

}  // namespace orbweave
