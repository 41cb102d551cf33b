// JSON documents as text: those that other programs read, and those that this one reads back.
// Names and paths in them need not be UTF-8; io/shown_text.h says what becomes of their bytes.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace orbweave {

/// For other programs: bytes that are no UTF-8 become \xNN. `indent`: as of nlohmann's dump().
std::string json_dump(const nlohmann::ordered_json& json, int indent = -1);

/// For documents of the chunk store: document_from(document_text(json)) == json, whatever bytes its
/// strings hold.
std::string document_text(const nlohmann::json& json);
/// Throws nlohmann's exceptions where the text is no JSON, or is nested too deeply.
nlohmann::json document_from(std::string_view text);

}  // namespace orbweave
