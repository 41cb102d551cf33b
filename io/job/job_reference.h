// The keys of job files as a page for reading.
#pragma once

#include <string>

namespace orbweave {

/// Markdown: a heading per section, a heading per key, so that each key can be linked to and found.
std::string job_key_reference();

}  // namespace orbweave
