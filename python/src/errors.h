// The library's errors as exceptions of Python.
#pragma once

#include <string>

namespace orbweave::python {

/// From here on an Error that leaves a function of the module is raised as the class of its kind in
/// orbweave._errors, with file, place, found, expected and advice as attributes.
void translate_errors();

/// Warns (OrbweaveWarning) the program that called the package; throws what the warning is turned
/// into.
void warn_of(const std::string& text);

}  // namespace orbweave::python
