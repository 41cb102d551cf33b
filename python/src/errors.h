// The library's errors as exceptions of Python.
#pragma once

namespace orbweave::python {

/// From here on an Error that leaves a function of the module is raised as the class of its kind in
/// orbweave._errors, with file, place, found, expected and advice as attributes.
void translate_errors();

}  // namespace orbweave::python
