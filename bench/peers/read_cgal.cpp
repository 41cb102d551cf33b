// bench_read_cgal MESH DUMP: what CGAL reads from a mesh file, for round_trip.py. DUMP gets three
// doubles per vertex, then three bytes of colour where CGAL has colours. Prints the number of
// vertices, of triangles, whether there are colours, and the names of the properties of vertices.
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh/IO/PLY.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

void dump(std::ofstream& file, const Point& point) {
  for (int axis = 0; axis < 3; ++axis) {
    const double value = point[axis];
    file.write(reinterpret_cast<const char*>(&value), sizeof value);
  }
}

int read_ply(const std::string& name, std::ofstream& file) {
  Mesh mesh;
  std::ifstream in(name, std::ios::binary);
  std::string comments;
  if (!CGAL::IO::read_PLY(in, mesh, comments)) return 1;
  for (const Mesh::Vertex_index v : mesh.vertices()) dump(file, mesh.point(v));
  const auto [colors, has_colors] =
      mesh.property_map<Mesh::Vertex_index, CGAL::IO::Color>("v:color");
  if (has_colors)
    for (const Mesh::Vertex_index v : mesh.vertices())
      for (const unsigned char channel : {colors[v].red(), colors[v].green(), colors[v].blue()})
        file.put(static_cast<char>(channel));
  std::cout << mesh.number_of_vertices() << " " << mesh.number_of_faces() << " " << has_colors;
  for (const std::string& property : mesh.properties<Mesh::Vertex_index>())
    std::cout << " " << property;
  std::cout << "\n";
  return 0;
}

int read_soup(const std::string& name, std::ofstream& file) {
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> polygons;
  if (!CGAL::IO::read_polygon_soup(name, points, polygons)) return 1;
  for (const Point& point : points) dump(file, point);
  std::cout << points.size() << " " << polygons.size() << " 0\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::string name = argv[1];
  std::ofstream file(argv[2], std::ios::binary);
  return name.ends_with(".ply") ? read_ply(name, file) : read_soup(name, file);
}
