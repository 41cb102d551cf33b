// Every path that a job reads or writes, and what it is for.
#pragma once

#include <string>
#include <vector>

#include "io/job/job.h"
#include "io/system/path_roles.h"

namespace orbweave {

/// `files`: the job's scans, patterns expanded. `job_file`: empty where there is none. Files that
/// the program writes beside others are among them: the report's page, the coordinate system beside
/// the mesh, the log in the work directory.
std::vector<PathRole> job_paths(const Job& job, const std::vector<std::string>& files,
                                const std::string& job_file = {});

/// Throws where check_paths() does for these, and Error (usage) where the name of the report or of
/// the picture does not fit what is written there.
void check_job_paths(const Job& job, const std::vector<std::string>& files,
                     const std::string& job_file = {});

}  // namespace orbweave
