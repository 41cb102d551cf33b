// The library's errors as exceptions of Python.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace orbweave::python {

/// From here on an Error that leaves a function of the module is raised as the class of its kind in
/// orbweave._errors, with file, place, found, expected and advice as attributes; so is a refusal of
/// the system, and a defect.
void translate_errors();

/// In a handler of what Python raised while it took a value: throws again what is no objection to
/// the value, Ctrl-C or a lack of memory.
void pass_on_unless_about_value(const pybind11::error_already_set& raised);
/// "TypeError: must be real number, not str".
std::string words_of(const pybind11::error_already_set& raised);

/// Warns (OrbweaveWarning) the program that called the package; throws what the warning is turned
/// into.
void warn_of(const std::string& text);

}  // namespace orbweave::python
