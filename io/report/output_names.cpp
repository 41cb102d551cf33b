#include "io/report/output_names.h"

#include <string>
#include <system_error>

#include "io/error.h"
#include "io/text/lower_case.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

std::string ending_of(const fs::path& path) { return lower_case(path.extension().string()); }

bool is_device(const fs::path& path) {
  std::error_code absent;
  return fs::is_other(fs::status(path, absent));
}

}  // namespace

void check_picture_name(const fs::path& picture) {
  if (picture.empty() || ending_of(picture) == ".png" || is_device(picture)) return;
  const std::string found = picture.extension().string();
  throw_usage("a picture is a PNG file", {.file = picture.string(),
                                          .found = found.empty() ? "no extension" : found,
                                          .expected = "a name that ends in .png"});
}

void check_report_name(const fs::path& report, const std::string& place) {
  if (report == "-")
    throw_usage("a report is not written to standard output",
                {.file = {}, .place = place, .found = "-", .expected = "the name of a file"});
  const std::string ending = ending_of(report);
  if (ending != ".html" && ending != ".htm") return;
  throw_usage("a report is a JSON file", {.file = report.string(),
                                          .found = report.extension().string(),
                                          .expected = "another ending, such as .json"});
}

void check_output_names(const OutputOptions& output, const std::string& place) {
  check_report_name(output.report, place);
  check_picture_name(output.picture);
}

}  // namespace orbweave
