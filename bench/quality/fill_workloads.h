// What bench_fill can do; each prints JSON lines.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace orbweave::bench {

/// Discs at random vertices of the main component, cut out, filled by the engine and by CGAL, and
/// both measured. One line per hole.
struct DiscWorkload {
  std::string mesh;
  std::vector<double> radii_spacings = {4.0, 8.0, 16.0};  ///< of the mesh's mean edge length
  int count = 50;
  std::uint64_t seed = 1;
  std::vector<std::uint32_t> centers;  ///< not empty: these vertices instead of random ones
  std::string cases;                   ///< directory for meshes of the holes; empty: none
  std::string kernel = "biharmonic";
  double neighborhood = 2.0;
  unsigned cgal_continuity = 1;  ///< its default
};
void run_discs(const DiscWorkload& work);

/// A hole of a radius at the vertex nearest to each of some places, neighbourhoods of several
/// radii; height errors of the removed points. One line per hole and neighbourhood.
struct HeightWorkload {
  std::string mesh;
  std::vector<double> places;                                   ///< x, y, z of each, world units
  double radius = 0.025;                                        ///< world units
  std::vector<double> neighborhood_radii = {0.03, 0.04, 0.05};  ///< world units
  std::string kernel = "biharmonic";
};
void run_heights(const HeightWorkload& work);

/// Discs of one size, none touching another, cut out at random vertices, and the time it takes to
/// fill them all. One line.
struct CostWorkload {
  std::string mesh;
  double radius_spacings = 2.0;
  int count = 0;
  std::uint64_t seed = 1;
  int repeats = 3;
};
void run_cost(const CostWorkload& work);

}  // namespace orbweave::bench
