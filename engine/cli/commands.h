// The commands: each adds itself, with its options and its example, to the program's parser.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/cli/command_action.h"
#include "partition/executor.h"

namespace CLI {
class App;
}

namespace orbweave {

/// What a command gets to work with.
struct CommandContext {
  std::vector<std::string> arguments;       ///< as given, the program's name first
  const StopToken& stop;                    ///< set by a signal; long loops look at it
  Communicator& communicator;               ///< the processes that were given this command
  std::function<void(CommandAction)> then;  ///< called when this command was asked for
};

/// Each throws nothing itself; the actions that they hand to `then` throw Error.
void add_run_command(CLI::App& program, const CommandContext& context);
void add_reconstruct_command(CLI::App& program, const CommandContext& context);
void add_fill_command(CLI::App& program, const CommandContext& context);
void add_plan_command(CLI::App& program, const CommandContext& context);
void add_status_command(CLI::App& program, const CommandContext& context);
void add_inspect_command(CLI::App& program, const CommandContext& context);
void add_compare_command(CLI::App& program, const CommandContext& context);
void add_simplify_command(CLI::App& program, const CommandContext& context);
void add_tileset_command(CLI::App& program, const CommandContext& context);
void add_view_command(CLI::App& program, const CommandContext& context);
void add_convert_command(CLI::App& program, const CommandContext& context);
void add_generate_command(CLI::App& program, const CommandContext& context);
void add_config_command(CLI::App& program, const CommandContext& context);

}  // namespace orbweave
