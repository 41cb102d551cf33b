// A module of somebody else that lies in the same process: import orbweave leaves its errors alone.
#include <pybind11/pybind11.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

PYBIND11_MODULE(foreign_module, module) {
  module.def("fail_in_the_system",
             [] { throw std::system_error(ENOENT, std::generic_category(), "foreign"); });
  module.def("fail", [] { throw std::runtime_error("foreign"); });
}
