#include "python/src/texts.h"

#include "io/error.h"

namespace py = pybind11;

namespace orbweave::python {
namespace {

constexpr const char* kKeepsBytes = "surrogateescape";

}  // namespace

py::str text_of(const std::string& bytes) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), kKeepsBytes));
}

std::string bytes_of(const py::str& text, const std::string& place) {
  const auto bytes =
      py::reinterpret_steal<py::bytes>(PyUnicode_AsEncodedString(text.ptr(), "utf-8", kKeepsBytes));
  if (bytes) return bytes;
  PyErr_Clear();
  throw_usage("a text is no Unicode", {.place = place, .found = py::repr(text)});
}

py::str path_text(const std::string& path) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeFSDefaultAndSize(path.data(), static_cast<Py_ssize_t>(path.size())));
}

}  // namespace orbweave::python
