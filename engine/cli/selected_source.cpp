#include "engine/cli/selected_source.h"

#include <CLI/CLI.hpp>
#include <array>
#include <string_view>

#include "io/clouds/open_point_source.h"
#include "io/job/selected_points.h"

namespace orbweave {
namespace {

constexpr std::array<std::string_view, 8> kKeys = {
    "input.columns", "input.separator", "input.las_classes", "input.drop_classes",
    "input.returns", "input.crop",      "input.crop_area",   "input.every"};

}  // namespace

void add_selection_options(CLI::App& command, JobArguments& arguments) {
  arguments.settings.emplace_back("input.drop_classes", "none");  // what follows wins over it
  add_key_options(command, kKeys, arguments);
  command.get_option("--drop-classes")
      ->description("Point classes to leave out, such as 7,18 (noise); the default is none");
}

SelectedSource::SelectedSource(const JobArguments& arguments) {
  const InputOptions input = settings_of(arguments).input;
  reading_.text = input.text;
  options_ = selection_of(input, area_of(input));
  takes_all_ = options_.classes.empty() && options_.dropped_classes.empty() &&
               options_.returns == ReturnFilter::kAll && !options_.crop &&
               options_.area == nullptr && options_.every == 1;
}

std::unique_ptr<PointSource> SelectedSource::open(const std::string& file) const {
  auto source = open_point_source(file, reading_);
  if (takes_all_) return source;
  return open_scan_source(std::move(source), options_, file);
}

}  // namespace orbweave
