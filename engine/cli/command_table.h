// The commands and options of a program as a plain table: what manual pages, completion of shells
// and the reference are made of. The parser that reads command lines is the only source.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace orbweave {

struct OptionFacts {
  std::vector<std::string> names;    ///< with dashes, short ones first; of an argument: its name
  std::string value;                 ///< what it takes, as help shows it; empty: nothing
  std::vector<std::string> choices;  ///< the only values, where there are such
  std::string help;                  ///< one line
  bool is_argument = false;          ///< has a place instead of a name
  bool is_required = false;
};

struct CommandFacts {
  std::string name;
  std::string help;     ///< one line
  std::string example;  ///< the last lines of its help
  std::vector<OptionFacts> options{};
};

struct ProgramFacts {
  std::string name;
  std::string help;
  std::string example;
  std::vector<OptionFacts> options{};
  std::vector<CommandFacts> commands{};
};

/// Options that help does not show are left out.
ProgramFacts program_facts(const CLI::App& program);

}  // namespace orbweave
