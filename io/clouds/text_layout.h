// What the columns of a text cloud mean.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave {

/// How a text cloud's columns are to be understood; everything has a detected default.
struct TextOptions {
  std::vector<std::string> columns;  ///< e.g. {"x","y","z","nx","ny","nz"}; empty: detect
  char separator = '\0';             ///< '\0': detect (comma, semicolon, tab, blanks)
};

struct TextColumn {
  std::string name;  ///< empty: the column is skipped
  ScalarType type = ScalarType::kFloat64;
};

struct TextLayout {
  char separator = ' ';  ///< ' ': any run of blanks and tabs
  std::vector<TextColumn> columns;
  bool has_header_line = false;  ///< the sample's first line names the columns
  /// Where colours are a guess: their columns and those right behind that may as well be colours.
  std::size_t first_color = 0, color_candidates = 0;
  /// Where coordinates are a guess: the first two columns look like rows and columns of a scanner's
  /// grid, with the coordinates behind them.
  bool may_begin_with_grid = false;
};

/// What to do about a text that is numbers alone, with a mark in one of them: a table of a program
/// that writes 1,5 for 1.5, or 1,234.5 or 1'234.5 for 1234.5. Empty for any other text.
const char* number_advice(std::string_view text);
inline constexpr const char* kPointsForCommas = "Write numbers with a decimal point, such as 1.5";

/// What the ending of a text cloud's name says about columns without names.
enum class TextKind {
  kAny,      ///< nothing
  kPts,      ///< x y z [intensity [red green blue [nx ny nz]]], and a count before each scan
  kNormals,  ///< .xyzn: x y z nx ny nz, of any length
  kColors,   ///< .xyzrgb: x y z red green blue, from 0 to 1 or whole numbers
};

/// The first lines of a text cloud, comments and blank lines left out.
struct TextSample {
  std::vector<std::string> lines;  ///< not empty
  std::string comment;             ///< text of a comment right before the first line
  std::string file;                ///< for messages
  std::size_t first_line = 1;      ///< number of lines[0] in the file
  TextKind kind = TextKind::kAny;
};

/// Columns as the options say, else as the header line (or a comment in its place) says, else by
/// their number and values: x y z; then three columns of unit vectors are normals, three of
/// whole numbers from 0 to 255 are red, green and blue; .pts has intensity (float32: its integers
/// from -2048 to 2047, and the fractions that some write) before its colours; .xyzn and .xyzrgb
/// have what they are named after; any other column is an attribute "c4" (by its place). Throws
/// Error: usage for options that make no sense, bad input where x, y and z cannot be found.
TextLayout find_text_layout(const TextSample& sample, const TextOptions& options);

/// The columns of doubles in which the sample has whole numbers that a double rounds, such as
/// nanoseconds since 1970, with the type of 64 bits that keeps them.
std::vector<TextColumn> rounded_columns(const TextSample& sample, const TextLayout& layout);

}  // namespace orbweave
