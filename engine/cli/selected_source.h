// Options that tell how a cloud is read and which of its points, for commands that are no jobs.
#pragma once

#include <memory>
#include <string>

#include "engine/cli/job_arguments.h"
#include "io/clouds/open_point_source.h"
#include "io/clouds/scan_source.h"

namespace orbweave {

/// Options for the keys that name the columns of text and those that select points. Unlike a job,
/// the command leaves out no class unless it is told to.
void add_selection_options(CLI::App& command, JobArguments& arguments);

/// Opens clouds of which only the selected points come out.
class SelectedSource {
 public:
  /// Reads the file of the area. Throws Error.
  explicit SelectedSource(const JobArguments& arguments);
  /// Every point is selected.
  bool takes_all() const { return takes_all_; }
  std::unique_ptr<PointSource> open(const std::string& file) const;

 private:
  PointSourceOptions reading_;
  ScanOptions options_;
  bool takes_all_ = true;
};

}  // namespace orbweave
