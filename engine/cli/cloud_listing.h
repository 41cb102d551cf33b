// The facts of a cloud as `inspect` shows them: a table for people, JSON with stable keys
// (docs/inspect.md).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "engine/cli/output.h"
#include "engine/validation/cloud_facts.h"

namespace orbweave {

nlohmann::ordered_json cloud_json(const CloudFacts& facts);
std::string cloud_text(const CloudFacts& facts);

/// Lines about what a file holds and no point or mesh has.
void add_not_read(std::span<const std::string> not_read, Facts& lines);

/// "LAS 1.2, point format 3", "PLY 1.0 binary_little_endian", "E57 1.0, 3 scans".
std::string format_text(const FileFacts& file);
/// A coordinate system in few words: the name that its WKT has, or its code; "unknown".
std::string system_text(const std::string& coordinate_system);

}  // namespace orbweave
