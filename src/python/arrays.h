#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace trunnion::python {

namespace py = pybind11;

/// Numbers from Python as they lie in memory: an array of doubles is read in place, whatever its strides.
using Numbers = py::array_t<double, py::array::forcecast>;

/// A read-only array over memory that `owner` keeps alive; nothing is copied. `stride_bytes` from one row to the next.
inline py::array view(const double* first, py::ssize_t rows, std::size_t stride_bytes, py::handle owner) {
  const py::array_t<double> array({rows}, {static_cast<py::ssize_t>(stride_bytes)}, first, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// The same of rows of three numbers, shape (rows, 3).
inline py::array view3(const double* first, py::ssize_t rows, std::size_t stride_bytes, py::handle owner) {
  const py::array_t<double> array({rows, py::ssize_t{3}},
                                  {static_cast<py::ssize_t>(stride_bytes), static_cast<py::ssize_t>(sizeof(double))},
                                  first, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// JSON as dicts, lists and numbers of Python.
py::object from_json(const nlohmann::json& json);

/// Warns as Python does.
inline void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) < 0) throw py::error_already_set();
}

}  // namespace trunnion::python
