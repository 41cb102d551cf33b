#include "python/src/job_calls.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>

#include "engine/planning/plan_job.h"
#include "engine/run_job.h"
#include "io/error.h"
#include "io/job/job_file.h"
#include "io/report/job_pace.h"
#include "python/src/texts.h"
#include "python/src/watched_call.h"

namespace py = pybind11;

namespace orbweave::python {
namespace {

/// Passes on where a job is: the stage and the share of the job's time, a tenth of a second apart.
class ToldProgress final : public Progress {
 public:
  explicit ToldProgress(WatchedCall& call) : call_(call) {}

  void expect(std::span<const ExpectedStage> stages) override {
    const std::scoped_lock lock(mutex_);
    pace_.expect(stages);
  }
  void begin_stage(const std::string& name, std::uint64_t total, const std::string&) override {
    const std::scoped_lock lock(mutex_);
    name_ = name;
    done_ = 0;
    total_ = total;
    pace_.begin_stage(name, now());
    tell();
  }
  void advance(std::uint64_t amount) override {
    const std::scoped_lock lock(mutex_);
    done_ += amount;
    constexpr double kBetweenCalls = 0.1;
    if (now() - last_told_ >= kBetweenCalls) tell();
  }
  void add_points(std::uint64_t) override {}
  void end_stage() override {
    const std::scoped_lock lock(mutex_);
    pace_.end_stage(now());
  }
  void note(const std::string&) override {}
  void warn(const std::string& line) override { call_.warn(line); }

 private:
  double now() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  void tell() {
    last_told_ = now();
    // Where stages turn out longer than expected the share of the time would fall.
    if (pace_.is_known()) share_ = std::max(share_, pace_.at(last_told_, done_, total_).share());
    call_.tell(name_, share_);
  }

  WatchedCall& call_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
  JobPace pace_;
  std::string name_;
  std::uint64_t done_ = 0;
  std::uint64_t total_ = 0;
  double last_told_ = 0.0;
  double share_ = 0.0;  ///< that was told last
};

/// A job as Python gives it: the path of a job file, or its text, or settings alone.
struct WrittenJob {
  std::string file;
  std::string text;
  Settings settings;
};

Job job_of(const WrittenJob& written) {
  Job job;
  if (!written.file.empty())
    job = read_job_file(written.file);
  else if (!written.text.empty())
    job = parse_job(written.text, "the text of the job");
  apply(job, written.settings);
  if (job.input.files.empty())
    throw_usage("names no scans", {.file = written.file,
                                   .place = "input.files",
                                   .expected = "[input] files = [\"scan.ply\"]"});
  return job;
}

py::object loaded(const std::string& json) {
  return py::module_::import("json").attr("loads")(json);
}

py::object run(const std::string& file, const std::string& text, const Settings& settings,
               bool fresh, const py::object& progress) {
  WatchedCall call(progress);
  std::string report;
  call.run([&] {
    Job job = job_of({file, text, settings});
    job.run.fresh = fresh;
    ToldProgress told(call);
    report = report_json(
        run_job(job, {.progress = &told, .stop = &call.stop(), .command = {"orbweave.run"}}));
  });
  return loaded(report);
}

py::object box_object(const Box& box) {
  if (box.empty()) return py::none();
  py::dict bounds;
  bounds["min"] = py::make_tuple(box.min.x, box.min.y, box.min.z);
  bounds["max"] = py::make_tuple(box.max.x, box.max.y, box.max.z);
  return bounds;
}

py::list list_of(const std::vector<std::string>& texts, py::str (*text)(const std::string&)) {
  py::list list;
  for (const std::string& one : texts) list.append(text(one));
  return list;
}

py::dict plan_object(const JobPlan& plan) {
  py::dict facts;
  facts["files"] = list_of(plan.files, path_text);
  facts["points"] = plan.points;
  facts["points_read"] = plan.points_read;
  facts["points_dropped"] = plan.points_dropped;
  facts["bounds"] = box_object(plan.bounds);
  facts["chunks"] = plan.chunks;
  facts["chunk_points"] = plan.chunk_points;
  facts["largest_chunk_points"] = plan.largest_chunk_points;
  facts["chunks_in_flight"] = plan.chunks_in_flight;
  facts["halo_width"] = plan.halo_width;
  facts["doubts"] = list_of(plan.doubts, text_of);
  facts["ball_radii"] = plan.radii;
  facts["peak_memory_bytes"] = plan.peak_memory_bytes;
  facts["disk_bytes"] = plan.disk_bytes;
  facts["seconds"] = plan.seconds;
  facts["holes"] = py::none();
  if (plan.loops) facts["holes"] = *plan.loops;
  return facts;
}

py::dict plan(const std::string& file, const std::string& text, const Settings& settings,
              const py::object& progress) {
  WatchedCall call(progress);
  JobPlan planned;
  call.run([&] {
    ToldProgress told(call);
    planned = plan_job(job_of({file, text, settings}), told, call.stop());
  });
  return plan_object(planned);
}

}  // namespace

void apply(Job& job, const Settings& settings) {
  for (const auto& [key, text] : settings) set_job_key(job, key, text);
}

void add_job_calls(py::module_& module) {
  module.def("run", &run, py::arg("file"), py::arg("text"), py::arg("settings"), py::arg("fresh"),
             py::arg("progress"));
  module.def("plan", &plan, py::arg("file"), py::arg("text"), py::arg("settings"),
             py::arg("progress"));
}

}  // namespace orbweave::python
