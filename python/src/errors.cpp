#include "python/src/errors.h"

#include <exception>
#include <new>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/system/system_advice.h"
#include "python/src/texts.h"

namespace py = pybind11;

namespace orbweave::python {
namespace {

const char* class_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kUsage:
      return "UsageError";
    case ErrorKind::kBadInput:
      return "BadInputError";
    case ErrorKind::kResource:
      return "ResourceError";
    case ErrorKind::kInterrupted:
      return "Interrupted";
    case ErrorKind::kNone:
    case ErrorKind::kDefect:
      break;
  }
  return "DefectError";
}

/// What is no Error, as the program tells of it.
Error as_error(const std::exception& error) {
  if (is_lack_of_threads(error))
    return {ErrorKind::kResource,
            "the system starts no more threads",
            {.found = error.what(),
             .advice = "Raise the limits of memory (ulimit -v) and processes (ulimit -u), or take "
                       "fewer threads."}};
  if (dynamic_cast<const std::system_error*>(&error) != nullptr)
    return {ErrorKind::kResource, std::string("the system refused: ") + error.what()};
  return {ErrorKind::kDefect,
          std::string("a defect in orbweave: ") + error.what(),
          {.advice = "Please report it with the call and orbweave.__version__."}};
}

void raise(const Error& error) {
  const py::object type = py::module_::import("orbweave._errors").attr(class_of(error.kind()));
  const ErrorParts& parts = error.parts();
  const py::object raised = type(
      path_text(error.what()), py::arg("problem") = path_text(error.problem()),
      py::arg("file") = path_text(parts.file), py::arg("place") = path_text(parts.place),
      py::arg("found") = path_text(parts.found), py::arg("expected") = path_text(parts.expected),
      py::arg("advice") = path_text(parts.advice));
  PyErr_SetObject(type.ptr(), raised.ptr());
}

}  // namespace

void translate_errors() {
  // Of this module alone: other modules keep their own ways.
  py::register_local_exception_translator([](std::exception_ptr failure) {
    try {
      if (failure) std::rethrow_exception(std::move(failure));
    } catch (const Error& error) {
      raise(error);
    } catch (const std::bad_alloc&) {
      throw;  // MemoryError, as pybind11 has it
    } catch (const py::builtin_exception&) {
      throw;
    } catch (const std::exception& error) {
      raise(as_error(error));
    }
  });
}

void pass_on_unless_about_value(const py::error_already_set& raised) {
  if (!raised.matches(PyExc_Exception) || raised.matches(PyExc_MemoryError)) throw;
}

std::string words_of(const py::error_already_set& raised) {
  const auto type = py::str(raised.type().attr("__name__")).cast<std::string>();
  const py::object text = py::module_::import("builtins").attr("str")(raised.value());
  return type + ": " + bytes_of(text, "the words of " + type);
}

void warn_of(const std::string& text) {
  // The function of the package is the innermost frame, its caller the next one.
  constexpr int kCallerOfThePackage = 2;
  py::module_::import("warnings")
      .attr("warn")(text_of(text), py::module_::import("orbweave._errors").attr("OrbweaveWarning"),
                    py::arg("stacklevel") = kCallerOfThePackage);
}

}  // namespace orbweave::python
