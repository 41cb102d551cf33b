#include "tests/mpi/mpi_jobs.h"

#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <thread>

#include "io/meshes/mesh_writer.h"
#include "io/text/quantity.h"
#include "tests/support/jobs.h"
#include "tests/support/raw_scans.h"

namespace orbweave::test {
namespace {

const std::vector<std::string> kHere = {
    "OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
    "OMPI_MCA_rmaps_base_oversubscribe=1", "OMPI_MCA_plm_rsh_agent="};

std::string list_of(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ",") + format_exact(value);
  return text;
}

/// The state of a thread, the word after its name; 'X' where it is gone.
char state_of(const std::filesystem::path& thread) {
  std::string text;
  std::getline(std::ifstream(thread / "stat"), text);  // nothing where it has ended meanwhile
  const std::size_t name_ends = text.rfind(')');
  return name_ends + 2 < text.size() ? text[name_ends + 2] : 'X';
}

/// Whether all threads that are left of a process are in one of these states.
bool is_wholly(pid_t process, const std::string& states) {
  std::error_code ignored;
  const std::filesystem::path tasks = "/proc/" + std::to_string(process) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks, ignored))
    if (states.find(state_of(task.path())) == std::string::npos) return false;
  return true;
}

bool stands_still(pid_t process) { return is_wholly(process, "TtZX"); }
bool is_gone(pid_t process) { return is_wholly(process, "ZX"); }

}  // namespace

bool skipped_without_mpi() {
  return skipped_without(ORBWEAVE_MPIRUN) || skipped_without(ORBWEAVE_MPI_PROGRAM);
}

std::vector<std::string> operator+(std::vector<std::string> words,
                                   const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::vector<std::string> by_ranks(int ranks, const std::vector<std::string>& arguments) {
  return std::vector<std::string>{"-n", std::to_string(ranks), "--bind-to", "none",
                                  ORBWEAVE_MPI_PROGRAM} +
         arguments;
}

ProgramSetting mpi_setting(const std::filesystem::path& directory,
                           std::vector<std::string> environment) {
  return {.directory = directory,
          .environment = std::move(environment) + kHere,
          .out_to = {},
          .program = ORBWEAVE_MPIRUN};
}

ProgramResult run_by_ranks(int ranks, const std::vector<std::string>& arguments,
                           const std::filesystem::path& directory,
                           std::vector<std::string> environment) {
  return run_program(by_ranks(ranks, arguments), mpi_setting(directory, std::move(environment)));
}

std::vector<pid_t> ranks_of(const RunningProgram& mpirun) {
  std::vector<pid_t> ranks;
  std::error_code ignored;
  const std::filesystem::path tasks = "/proc/" + std::to_string(mpirun.process()) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks, ignored)) {
    std::ifstream children(task.path() / "children");
    for (pid_t child = 0; children >> child;) ranks.push_back(child);
  }
  return ranks;
}

void signal_all(const std::vector<pid_t>& processes, int signal) {
  for (const pid_t process : processes) kill(process, signal);
}

void kill_all(const std::vector<pid_t>& processes) {
  signal_all(processes, SIGKILL);
  while (!std::all_of(processes.begin(), processes.end(), is_gone))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

std::vector<pid_t> hold_ranks_when(RunningProgram& mpirun, std::size_t ranks,
                                   const std::function<bool()>& reached) {
  constexpr std::chrono::milliseconds kMoment{1};
  while (mpirun.running()) {
    std::vector<pid_t> processes = ranks_of(mpirun);
    // A process that is about to become a rank may be continued by mpirun: the signal is repeated.
    do {
      signal_all(processes, SIGSTOP);
      std::this_thread::sleep_for(kMoment / 10.0);
    } while (!std::all_of(processes.begin(), processes.end(), stands_still));
    if (processes.size() == ranks && reached()) return processes;
    signal_all(processes, SIGCONT);
    std::this_thread::sleep_for(kMoment);
  }
  return {};
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::vector<std::string> oriented_job(const ScratchDirectory& in, std::size_t points) {
  const NamedCloud torus = painted_torus(points, 0.4, 11);
  const double rho = torus.ball_radius;
  write_cloud((in / "cloud.ply").string(), torus.cloud);
  return {"reconstruct",
          "cloud.ply",
          "-o",
          "mesh.ply",
          "--radii",
          list_of({rho, 1.5 * rho}),
          "--chunk-points",
          std::to_string(points / 16),
          "--progress",
          "none"};
}

std::vector<std::string> raw_job(const ScratchDirectory& in, std::size_t points) {
  const RawScans scans = scan_torus(in, points, 0.3, 0.2);
  return std::vector<std::string>{"reconstruct"} + scans.files +
         std::vector<std::string>{"--poses",
                                  scans.poses,
                                  "-o",
                                  "mesh.ply",
                                  "--orientation",
                                  "propagate",
                                  "--outlier-sigma",
                                  "4",
                                  "--merge-tolerance",
                                  format_exact(0.2 * scans.spacing),
                                  "--smooth-radius",
                                  format_exact(2.5 * scans.spacing),
                                  "--thin-to-spacing",
                                  format_exact(0.8 * scans.spacing),
                                  "--levels",
                                  "2",
                                  "--chunk-points",
                                  std::to_string(points / 12),
                                  "--progress",
                                  "none"};
}

std::string take_mesh(const ScratchDirectory& in) {
  std::string bytes = file_text(in / "mesh.ply");
  std::filesystem::remove(in / "mesh.ply");
  return bytes;
}

std::string mesh_of_one(const ScratchDirectory& in, const std::vector<std::string>& job) {
  const ProgramResult result = run_program(job, {.directory = in.path()});
  INFO(result.err);
  REQUIRE(result.status == 0);
  std::string bytes = take_mesh(in);
  REQUIRE(bytes.size() > 1000);
  return bytes;
}

}  // namespace orbweave::test
