// The positions that ball pivoting decides about: multiples of a step that follows from the ball
// radii alone, on a lattice fixed in space, in general position.
//
// Coordinates relative to any origin on the lattice are exact, and so are their differences. What
// a decision computes hence follows from differences between neighbouring points: not from the
// chunk, nor from the extent of the cloud. Points of one cell are looked at in canonical order,
// though, which is that of the root cube: where several choices are equally right, as of the ball
// that a walk starts at, the cloud as a whole has a say. docs/dev/ball-pivoting.md.
#pragma once

#include <span>
#include <vector>

#include "io/box.h"
#include "io/vec3.h"

namespace orbweave {

/// Step of the lattice, a power of two: about 1e-12 of the smallest radius, coarser only where the
/// halo of the largest would not fit into exact coordinates otherwise.
double lattice_step(std::span<const double> ball_radii);

/// Points that lie in a box of at most this extent have exact coordinates relative to the lattice
/// point nearest to its centre.
double largest_exact_extent(double step);

/// The nearest lattice point; a point that is too far from zero to lie between lattice points
/// stays.
Vec3 on_lattice(Vec3 p, double step);

/// Positions on the lattice, relative to `origin` (a lattice point), each moved by a pseudo-random
/// vector of at most 2^20 steps per axis that follows from the bits of its coordinates.
/// Parallel on the calling arena.
std::vector<Vec3> general_position(std::span<const Vec3> positions, Vec3 origin, double step);

}  // namespace orbweave
