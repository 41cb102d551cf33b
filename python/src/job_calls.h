// Jobs, and what else has options with the names of a job's keys.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>
#include <vector>

#include "io/job/job.h"

namespace orbweave::python {

/// Keys and values: ("fill.max_edges", "200"), values as TOML has them.
using Settings = std::vector<std::pair<std::string, std::string>>;

/// Throws Error (usage) where a key is unknown or its value does not suit it.
void apply(Job& job, const Settings& settings);

/// Adds run and plan.
void add_job_calls(pybind11::module_& module);

}  // namespace orbweave::python
