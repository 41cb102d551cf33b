// The report of a run: facts with stable keys (JSON) and a page for reading (HTML).
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "io/report/machine.h"
#include "io/report/report_facts.h"

namespace orbweave {

/// JSON text with the stable keys of the interface.
std::string report_json(const RunReport& report);
std::string mesh_facts_json(const MeshFacts& facts);
/// A list, as the report has it: a line per hole. `method` and `reason` are null where empty.
std::string holes_json(std::span<const HoleFacts> holes);
/// `mesh` is the mesh as written, `mesh_before` as read, `holes` as in the report of a run.
std::string fill_report_json(const FillReport& report);
/// The page beside a report; empty where there is none: the report is a device, or named .html.
std::filesystem::path report_page(const std::filesystem::path& report);
/// Writes PATH (JSON) and, beside it, the same as .html. Atomic.
void write_report(const std::filesystem::path& path, const RunReport& report,
                  const std::string& viewer = {});
/// Writes PATH (JSON). Atomic.
void write_fill_report(const std::filesystem::path& path, const FillReport& report);

}  // namespace orbweave
