// Where the coordinates of a mesh file are counted from, where its numbers are narrower than those
// of the scans.
#pragma once

#include <string>

#include "io/box.h"
#include "io/job/job.h"

namespace orbweave {

/// The origin of a file's coordinates, and what they lose there.
struct OutputOrigin {
  Vec3 origin;                  ///< is subtracted from coordinates; world units
  bool floats = false;          ///< the file's coordinates are floats, else doubles or exact text
  double largest_move = 0.0;    ///< of a vertex, by the rounding of its coordinates; world units
  double spacing = 0.0;         ///< of the points; 0: not known
  double extent = 0.0;          ///< of the points along their longest axis
  bool exceeds_floats = false;  ///< floats hold no number as large as a coordinate
};

/// The most that rounding to floats moves a point of the box whose coordinates are counted from
/// `origin`.
double largest_float_move(const Box& bounds, Vec3 origin);

/// The origin as the job asks for it. `floats`: the file's coordinates are floats. kAuto: zero on
/// the axes where floats lose nothing that matters, on the others a round number close to the
/// middle of the box, so that it depends on the box and the spacing alone. What matters is more
/// than a thousandth of the spacing, or a millionth of the extent where the spacing is not known.
OutputOrigin output_origin(const OutputOptions& output, bool floats, const Box& bounds,
                           double spacing);

/// Throws Error (usage) where coordinates lose too much: with the rule kNone more than a thousandth
/// of the spacing, else more than a tenth; where the spacing is not known, with any other rule more
/// than a ten-thousandth of the extent; and where they exceed floats. Returns a warning where they
/// lose more than a thousandth of the spacing; else nothing.
std::string check_output_origin(const Job& job, const OutputOrigin& chosen);

/// "512000, 4176000, 0"
std::string origin_text(Vec3 origin);

}  // namespace orbweave
