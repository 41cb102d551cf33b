// What the fields of reports mean: the reference is made of this table, and a test holds that every
// field of a report has its row.
#pragma once

#include <span>
#include <string_view>

namespace orbweave {

struct ReportField {
  /// "mesh.bounds", of what lists hold "holes[].edges".
  std::string_view name;
  std::string_view meaning;  ///< a phrase, with its unit
};

/// Of the report of a run, in the order of the report.
std::span<const ReportField> run_report_fields();
/// Of the report of `orbweave fill`, those that differ from the report of a run: all others mean
/// the same in both, and `mesh_before` has the fields of `mesh`.
std::span<const ReportField> fill_report_fields();

/// Empty where the table does not have the field. Fields below `options` and the reasons of dropped
/// points and triangles are not fields of their own.
std::string_view meaning_of_field(std::string_view name);

}  // namespace orbweave
