// The report of a run as a page for reading.
#pragma once

#include <string>

#include "io/report/report_facts.h"

namespace orbweave {

/// One self-contained page: the report's facts in tables, and the picture where its file is there.
/// `viewer`: a page that shows the mesh, for a frame of its own; empty: none.
std::string report_html(const RunReport& report, const std::string& viewer = {});

/// Text as it may stand in a page or an attribute: &, <, >, " and ' escaped.
std::string html_text(std::string_view text);

}  // namespace orbweave
