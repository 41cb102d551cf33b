// What orbweave-mpi says of itself: its help and its manual page.
#pragma once

#include <array>
#include <string_view>

namespace orbweave {

inline constexpr const char* kTeamProgram = "orbweave-mpi";
inline constexpr const char* kTeamHelp =
    "orbweave by several processes, on one machine or many: the same mesh, sooner.";
inline constexpr const char* kTeamExample = "Example:\n  mpirun -n 8 orbweave-mpi run job.toml\n";
/// Its commands, which are those of the program with the same options.
inline constexpr std::array<std::string_view, 2> kTeamCommands = {"run", "reconstruct"};

}  // namespace orbweave
