// What the program prints for people: errors and aligned tables.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "io/box.h"

namespace orbweave {

/// "orbweave: error: <what>" on standard error; coloured on a terminal without NO_COLOR.
void print_error(const std::string& what);
/// "orbweave: warning: <what>", likewise.
void print_warning(const std::string& what);
/// Flushes standard output. Throws Error (resource) where what was printed could not be written.
void flush_output();

/// Names and values, one pair per line, values aligned: "points     437,645".
using Facts = std::vector<std::pair<std::string, std::string>>;
std::string facts_table(const Facts& facts);
/// Rows of cells under headings: the first column flush left, the others flush right.
std::string table(const std::vector<std::vector<std::string>>& rows);

std::string show_box(const Box& box);  ///< "0 .. 1, -2 .. 2, 0 .. 3 (1 x 4 x 3)"
std::string show_list(const std::vector<double>& values);  ///< "0.001, 0.002"

std::string joined(const std::vector<std::string>& words);  ///< "a, b, c"

}  // namespace orbweave
