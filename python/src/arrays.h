// Arrays of numpy and the library's columns of numbers.
#pragma once

#include <pybind11/numpy.h>

#include <span>
#include <string>

#include "io/point_cloud.h"
#include "io/triangle_mesh.h"

namespace orbweave::python {

/// Rows of three doubles. An array that is laid out so already is taken as it is, others are
/// converted; `array` keeps alive what `rows` shows.
struct Rows {
  pybind11::array array;
  std::span<const Vec3> rows;
  bool are_floats = false;  ///< the numbers that were given are of 4 bytes
};

/// Throws Error (usage) where `values` is no array of numbers with three columns. `name` is for
/// messages: "points".
Rows rows_of(const pybind11::object& values, const std::string& name);
/// Rows of three vertex numbers, each below `vertices`. Throws Error (usage).
std::vector<Triangle> triangles_of(const pybind11::object& values, std::size_t vertices);

/// A number of a hole for each triangle. Throws Error (usage).
std::vector<std::int32_t> holes_of(const pybind11::object& values, std::size_t triangles);

/// A cloud of copies. Normals of an array of float32 keep their width. Throws Error (usage) where
/// they are not as many as points.
PointCloud cloud_of(const Rows& positions);
PointCloud cloud_of(const Rows& positions, const Rows& normals);
/// `normals` may be None. `attributes`: None, or a dictionary of names and arrays with a number per
/// point.
PointCloud cloud_of(const pybind11::object& points, const pybind11::object& normals,
                    const pybind11::object& attributes);

/// Read-only views of what `owner` owns, and keep alive.
pybind11::array rows_view(std::span<const Vec3> rows, const pybind11::object& owner);
pybind11::array triangles_view(std::span<const Triangle> triangles, const pybind11::object& owner);
pybind11::array numbers_view(std::span<const std::int32_t> numbers, const pybind11::object& owner);
/// Name to view of the column.
pybind11::dict attribute_views(const PointCloud& cloud, const pybind11::object& owner);

}  // namespace orbweave::python
