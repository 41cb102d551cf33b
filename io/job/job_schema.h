// The schema of job files, made from the table of keys: for editors and for programs that write
// jobs.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace orbweave {

/// JSON Schema, draft 2020-12, of a job file as TOML reads it. What it refuses, the program refuses
/// as well. It cannot tell that numbers ascend, that a direction has a length, what a text says
/// (a pose, polygons), how many bytes a quantity is and that 8.0 is no integer in TOML; the program
/// looks at these by itself.
nlohmann::ordered_json job_schema();

}  // namespace orbweave
