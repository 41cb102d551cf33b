// Jobs by several processes: mpirun on this machine, whoever runs the tests and however few cores
// it has.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave::test {

/// True, after printing "SKIPPED: <file>", where orbweave-mpi was not built or there is no mpirun.
bool skipped_without_mpi();

/// What to run to have `ranks` processes of orbweave-mpi, as arguments of mpirun.
std::vector<std::string> by_ranks(int ranks, const std::vector<std::string>& arguments);
/// For the arguments of mpirun; `environment` beside what lets it run here.
ProgramSetting mpi_setting(const std::filesystem::path& directory,
                           std::vector<std::string> environment = {});
ProgramResult run_by_ranks(int ranks, const std::vector<std::string>& arguments,
                           const std::filesystem::path& directory,
                           std::vector<std::string> environment = {});

/// The processes that mpirun started and that still run.
std::vector<pid_t> ranks_of(const RunningProgram& mpirun);

void signal_all(const std::vector<pid_t>& processes, int signal);
/// Kills them (SIGKILL) and returns when they are gone, whoever inherits what is left of them: on a
/// busy machine mpirun is sooner gone than its ranks, and their locks.
void kill_all(const std::vector<pid_t>& processes);

/// Runs the job a moment at a time, whatever the machine's speed and load, until `reached`: its
/// ranks are returned, and stand still (SIGSTOP). Nothing where the job ended before.
std::vector<pid_t> hold_ranks_when(RunningProgram& mpirun, std::size_t ranks,
                                   const std::function<bool()>& reached);

std::size_t count_of(const std::string& text, const std::string& part);

/// A job of every stage that an oriented cloud goes through: arguments after the program's name,
/// the mesh is mesh.ply. The cloud has noise and holes.
std::vector<std::string> oriented_job(const ScratchDirectory& in, std::size_t points);
/// The same of raw scans: poses, clean-up, estimated normals, their propagation.
std::vector<std::string> raw_job(const ScratchDirectory& in, std::size_t points);

/// The mesh that one process makes of a job; its work directory is gone afterwards, and so is it.
std::string mesh_of_one(const ScratchDirectory& in, const std::vector<std::string>& job);
/// The mesh in the directory, which is then removed.
std::string take_mesh(const ScratchDirectory& in);

std::vector<std::string> operator+(std::vector<std::string> words,
                                   const std::vector<std::string>& more);

}  // namespace orbweave::test
