// bench_advancing_front CLOUD MESH: CGAL's advancing front (Cohen-Steiner, Da 2004) on the points
// of a PLY file, for raw_peers.py. It needs no normals and no radius. Prints the numbers of points
// and triangles and the seconds that reading, the surface and writing took.
#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/read_ply_points.h>

#include <array>
#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

namespace {

using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using Triangle = std::array<std::size_t, 3>;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: bench_advancing_front CLOUD MESH\n";
    return 2;
  }
  auto begin = std::chrono::steady_clock::now();
  std::vector<Point> points;
  std::ifstream in(argv[1], std::ios::binary);
  if (!CGAL::IO::read_PLY(in, std::back_inserter(points))) {
    std::cerr << argv[1] << ": CGAL cannot read this cloud\n";
    return 1;
  }
  const double read_seconds = seconds_since(begin);
  begin = std::chrono::steady_clock::now();
  std::vector<Triangle> triangles;
  CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(),
                                               std::back_inserter(triangles));
  const double surface_seconds = seconds_since(begin);
  begin = std::chrono::steady_clock::now();
  std::ofstream out(argv[2], std::ios::binary);
  CGAL::IO::set_binary_mode(out);
  if (!CGAL::IO::write_PLY(out, points, triangles)) {
    std::cerr << argv[2] << ": CGAL cannot write the mesh\n";
    return 1;
  }
  std::cout << points.size() << " " << triangles.size() << " " << read_seconds << " "
            << surface_seconds << " " << seconds_since(begin) << "\n";
  return 0;
}
