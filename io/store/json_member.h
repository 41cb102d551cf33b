// Members of small JSON documents that may be damaged or a stranger's.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace orbweave {

/// A text of a JSON object; empty: `json` is no object, has no such member, or it is no text.
std::string string_member(const nlohmann::json& json, const char* name);

}  // namespace orbweave
