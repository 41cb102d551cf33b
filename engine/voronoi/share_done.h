// The progress of long work, as a share.
#pragma once

#include <functional>

namespace orbweave::voronoi {

/// Hears of the share of some work that is done, from 0 to 1, ascending. May be empty.
using ShareDone = std::function<void(double)>;

/// Of Cocone and Tight Cocone: what is done when the cells are known, as they are on scans, and
/// when everything that takes memory is there.
inline constexpr double kCellsOfCocone = 0.6;
inline constexpr double kArraysOfCocone = 0.9;

}  // namespace orbweave::voronoi
