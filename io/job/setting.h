// Settings as the user of a job gives them: options of the command line or keys of a job file.
#pragma once

#include <string>
#include <string_view>

#include "io/job/job.h"

namespace orbweave {

/// "--smooth-radius" of a job from the command line, "cleaning.smooth_radius" of one from a job
/// file, and of a key without an option.
std::string setting_name(const Job& job, std::string_view key);

/// The setting with a value as the command line takes it: "--normals estimate" or
/// `normals.source = "estimate"`; of an option that stands for the value, "--cleaning" or
/// "cleaning.auto = true". `value` has to be one that the key accepts.
std::string setting(const Job& job, std::string_view key, std::string_view value);

}  // namespace orbweave
