#include "python/src/arrays.h"

#include <cstring>
#include <utility>

#include "io/error.h"
#include "python/src/errors.h"
#include "python/src/texts.h"

namespace py = pybind11;

namespace orbweave::python {
namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double));
static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));

std::string type_name_of(const py::object& value) {
  return py::str(py::type::of(value).attr("__name__")).cast<std::string>();
}

std::string shape_text(const py::array& array) {
  std::string text;
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis)
    text += (axis > 0 ? ", " : "") + std::to_string(array.shape(axis));
  return "(" + text + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void refuse(const std::string& name, const py::array& array,
                         const std::string& expected) {
  throw_usage("an array is of the wrong kind", {.place = name,
                                                .found = "shape " + shape_text(array) + " of " +
                                                         py::str(array.dtype()).cast<std::string>(),
                                                .expected = expected});
}

/// Values that are masked are none; what lies beneath the mask is anything.
void refuse_masked(const py::object& values, const std::string& name) {
  if (!py::hasattr(values, "mask")) return;
  if (py::module_::import("numpy.ma").attr("is_masked")(values).cast<bool>())
    throw_usage("an array has masked values", {.place = name,
                                               .expected = "numbers in all of its rows",
                                               .advice = "Leave masked rows out first."});
}

/// Any sequence as an array, whatever its type.
py::array array_of(const py::object& values, const std::string& name) {
  refuse_masked(values, name);
  try {
    return py::array(values);
  } catch (const py::error_already_set& raised) {
    pass_on_unless_about_value(raised);
    throw_usage("no array",
                {.place = name, .found = words_of(raised), .expected = "an array of numbers"});
  }
}

bool holds_numbers(const py::array& array) {
  const char kind = array.dtype().kind();
  return kind == 'f' || kind == 'i' || kind == 'u';
}

bool holds_integers(const py::array& array) {
  const char kind = array.dtype().kind();
  return kind == 'i' || kind == 'u';
}

/// Whatever numbers a list of none is taken for.
bool is_empty(const py::array& array) { return array.ndim() > 0 && array.shape(0) == 0; }

using Integers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

/// Integers of any type. Throws Error (usage) where one is beyond 63 bits.
Integers integers_of(const py::array& array, const std::string& name) {
  Integers integers(array);
  if (array.dtype().kind() != 'u') return integers;
  for (const std::int64_t number :
       std::span(integers.data(), static_cast<std::size_t>(integers.size())))
    if (number < 0)
      throw_usage("an integer is too large",
                  {.place = name,
                   .found = std::to_string(static_cast<std::uint64_t>(number)),
                   .expected = "integers below 2^63"});
  return integers;
}

/// Bytes of an item, asked of Python: where its type keeps them differs between versions of numpy.
std::size_t item_bytes(const py::array& array) {
  return array.attr("itemsize").cast<std::size_t>();
}

bool holds_floats(const py::array& array) {
  return array.dtype().kind() == 'f' && item_bytes(array) == sizeof(float);
}

ScalarType type_of(const py::array& array, const std::string& name) {
  const char kind = array.dtype().kind();
  const std::size_t bytes = item_bytes(array);
  for (int i = 0; i <= static_cast<int>(ScalarType::kFloat64); ++i) {
    const auto type = static_cast<ScalarType>(i);
    const char first = name_of(type)[0];
    if (first == kind && size_of(type) == bytes) return type;
  }
  refuse(name, array, "integers of 1, 2, 4 or 8 bytes, float32 or float64");
}

py::dtype dtype_of(ScalarType type) { return py::dtype(std::string(name_of(type))); }

/// Puts a column into the rows of packed attributes.
void put_column(PointCloud& cloud, std::size_t offset, std::size_t row_bytes,
                const py::array& column) {
  const std::size_t bytes = item_bytes(column);
  const auto* from = static_cast<const std::byte*>(column.data());
  const py::ssize_t stride = column.strides(0);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    std::memcpy(cloud.attributes.data() + i * row_bytes + offset,
                from + static_cast<py::ssize_t>(i) * stride, bytes);
}

/// In the machine's byte order.
py::array native(const py::array& array) {
  return array.attr("astype")(array.dtype().attr("newbyteorder")("="), py::arg("copy") = false);
}

/// A number for each point, in the machine's byte order.
py::array column_of(const py::handle& values, const std::string& name, std::size_t points) {
  const py::array array = array_of(py::reinterpret_borrow<py::object>(values), name);
  const bool fits = array.ndim() == 1 && static_cast<std::size_t>(array.size()) == points;
  if (!fits || !holds_numbers(array))
    refuse(name, array, "a number for each of " + std::to_string(points) + " points");
  return native(array);
}

py::dict dictionary_of(const py::object& attributes) {
  try {
    return py::dict(attributes);
  } catch (const py::error_already_set& raised) {
    pass_on_unless_about_value(raised);
    throw_usage("no dictionary", {.place = "attributes",
                                  .found = "a value of type " + type_name_of(attributes),
                                  .expected = "names and arrays with a number for each point"});
  }
}

void put_attributes(PointCloud& cloud, const py::dict& attributes) {
  std::vector<py::array> columns;
  for (const auto& [key, values] : attributes) {
    if (!py::isinstance<py::str>(key))
      throw_usage("the name of an attribute is no text",
                  {.place = "attributes",
                   .found = py::repr(key).cast<std::string>(),
                   .expected = "a text such as \"intensity\""});
    const std::string name = bytes_of(py::reinterpret_borrow<py::str>(key), "attributes");
    const std::string place = "attributes[\"" + name + "\"]";
    columns.push_back(column_of(values, place, cloud.size()));
    cloud.schema.attributes.push_back({name, type_of(columns.back(), place)});
  }
  const std::size_t row_bytes = cloud.schema.attribute_bytes();
  cloud.attributes.resize(cloud.size() * row_bytes);
  std::size_t offset = 0;
  for (const py::array& column : columns) {
    put_column(cloud, offset, row_bytes, column);
    offset += item_bytes(column);
  }
}

py::array read_only(py::array view) {
  py::detail::array_proxy(view.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return view;
}

template <class Number>
py::array view_of(const void* data, py::ssize_t rows, py::ssize_t columns,
                  const py::object& owner) {
  const auto bytes = static_cast<py::ssize_t>(sizeof(Number));
  return read_only(
      py::array(py::dtype::of<Number>(), {rows, columns}, {columns * bytes, bytes}, data, owner));
}

}  // namespace

Rows rows_of(const py::object& values, const std::string& name) {
  const py::array given = array_of(values, name);
  if (given.ndim() != 2 || given.shape(1) != 3 || !holds_numbers(given))
    refuse(name, given, "shape (N, 3) of float64");
  Rows rows;
  rows.are_floats = holds_floats(given);
  rows.array = py::array_t<double, py::array::c_style | py::array::forcecast>(given);
  rows.rows = {static_cast<const Vec3*>(rows.array.data()),
               static_cast<std::size_t>(rows.array.shape(0))};
  return rows;
}

std::vector<Triangle> triangles_of(const py::object& values, std::size_t vertices) {
  const py::array given = array_of(values, "triangles");
  if (is_empty(given)) return {};
  if (given.ndim() != 2 || given.shape(1) != 3 || !holds_integers(given))
    refuse("triangles", given, "shape (K, 3) of integers");
  const Integers numbers = integers_of(given, "triangles");
  std::vector<Triangle> triangles(static_cast<std::size_t>(numbers.shape(0)));
  const std::int64_t* number = numbers.data();
  for (Triangle& triangle : triangles) {
    for (std::uint32_t& corner : triangle) {
      if (*number < 0 || static_cast<std::uint64_t>(*number) >= vertices)
        throw_usage("a triangle names a vertex that is not there",
                    {.place = "triangles",
                     .found = std::to_string(*number),
                     .expected = "a number below " + std::to_string(vertices)});
      corner = static_cast<std::uint32_t>(*number++);
    }
  }
  return triangles;
}

std::vector<std::int32_t> holes_of(const py::object& values, std::size_t triangles) {
  const py::array given = array_of(values, "triangle_hole");
  if (is_empty(given) && triangles == 0) return {};
  const bool fits = given.ndim() == 1 && static_cast<std::size_t>(given.size()) == triangles;
  if (!fits || !holds_integers(given))
    refuse("triangle_hole", given,
           "an integer for each of " + std::to_string(triangles) + " triangles");
  const Integers numbers = integers_of(given, "triangle_hole");
  std::vector<std::int32_t> holes;
  for (const std::int64_t number : std::span(numbers.data(), triangles)) {
    if (!std::in_range<std::int32_t>(number))
      throw_usage("the number of a hole is too large", {.place = "triangle_hole",
                                                        .found = std::to_string(number),
                                                        .expected = "integers of 32 bits"});
    holes.push_back(static_cast<std::int32_t>(number));
  }
  return holes;
}

PointCloud cloud_of(const Rows& positions) {
  PointCloud cloud;
  cloud.positions.assign(positions.rows.begin(), positions.rows.end());
  return cloud;
}

PointCloud cloud_of(const Rows& positions, const Rows& normals) {
  PointCloud cloud = cloud_of(positions);
  if (normals.rows.size() != cloud.size())
    refuse("normals", normals.array, "as many rows as points, " + std::to_string(cloud.size()));
  cloud.normals.assign(normals.rows.begin(), normals.rows.end());
  cloud.schema.has_normals = true;
  cloud.schema.normal_type = normals.are_floats ? ScalarType::kFloat32 : ScalarType::kFloat64;
  return cloud;
}

PointCloud cloud_of(const py::object& points, const py::object& normals,
                    const py::object& attributes) {
  const Rows positions = rows_of(points, "points");
  PointCloud cloud =
      normals.is_none() ? cloud_of(positions) : cloud_of(positions, rows_of(normals, "normals"));
  if (!attributes.is_none()) put_attributes(cloud, dictionary_of(attributes));
  return cloud;
}

py::array rows_view(std::span<const Vec3> rows, const py::object& owner) {
  return view_of<double>(rows.data(), static_cast<py::ssize_t>(rows.size()), 3, owner);
}

py::array triangles_view(std::span<const Triangle> triangles, const py::object& owner) {
  return view_of<std::uint32_t>(triangles.data(), static_cast<py::ssize_t>(triangles.size()), 3,
                                owner);
}

py::array numbers_view(std::span<const std::int32_t> numbers, const py::object& owner) {
  return read_only(
      py::array(py::dtype::of<std::int32_t>(), {static_cast<py::ssize_t>(numbers.size())},
                {static_cast<py::ssize_t>(sizeof(std::int32_t))}, numbers.data(), owner));
}

py::dict attribute_views(const PointCloud& cloud, const py::object& owner) {
  py::dict views;
  const auto row_bytes = static_cast<py::ssize_t>(cloud.schema.attribute_bytes());
  std::size_t offset = 0;
  for (const AttributeField& field : cloud.schema.attributes) {
    const std::byte* const first = cloud.attributes.data() + offset;
    views[text_of(field.name)] = read_only(py::array(
        dtype_of(field.type), {static_cast<py::ssize_t>(cloud.size())}, {row_bytes}, first, owner));
    offset += size_of(field.type);
  }
  return views;
}

}  // namespace orbweave::python
