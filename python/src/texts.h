// Texts of Python and the bytes that the library keeps.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace orbweave::python {

/// Names from files need not be UTF-8: their other bytes become lone surrogates ("\udcff"), as in
/// names of files, so that bytes_of() gives them back.
pybind11::str text_of(const std::string& bytes);
/// Throws Error (usage) where the text has surrogates that stand for no bytes; `place` is for the
/// message.
std::string bytes_of(const pybind11::str& text, const std::string& place);
/// The path of a file, as os.fsdecode() has it.
pybind11::str path_text(const std::string& path);

}  // namespace orbweave::python
