// What the program prints for people: errors and aligned tables.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/validation/compare.h"
#include "io/box.h"
#include "io/points/dropped_points.h"
#include "io/report/report.h"

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
std::string table(std::vector<std::vector<std::string>> rows);

/// Distances, one line each: how many were measured, mean, rms, median, 95th
/// percentile, largest.
std::string distance_table(const std::vector<std::pair<std::string, DistanceSummary>>& rows);
/// A table behind an empty line; empty where there is no share.
std::string within_table(std::span<const NearShare> shares);
std::string show_percent(double share);  ///< "12.3 %"

/// "0.00000 .. 1.00000, -2.00000 .. 2.00000, 0.00000 .. 3.00000 (1 x 4 x 3)": as many decimals as a
/// millionth of the largest extent takes.
std::string show_box(const Box& box);
std::string counted(std::uint64_t count, const char* one, const char* many);  ///< "3 loops"
/// "3 vertices, 1 triangle"
std::string show_counts(std::uint64_t vertices, std::uint64_t triangles);
std::string show_mesh(const MeshFacts& mesh);  ///< counts, and whether it is closed
/// Separate pieces that were too small, where there were any.
void add_removed(Facts& facts, std::uint64_t pieces, std::uint64_t triangles);
/// Points of the scans that were left out before, with the reasons, where there are any.
void add_dropped(Facts& facts, const DroppedPoints& dropped);
/// Points of the cloud that the mesh leaves out, where there are any.
void add_unused(Facts& facts, std::uint64_t points);
/// What became of the loops: how many, filled by what, open for what reason. Nothing for none.
void add_holes(Facts& facts, std::span<const HoleFacts> holes, const MeshFacts& mesh,
               const Job& job);

}  // namespace orbweave
