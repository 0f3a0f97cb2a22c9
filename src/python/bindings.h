#pragma once

#include <pybind11/pybind11.h>

namespace trunnion::python {

/// Machine, Model, Observations, Piece, Job.
void bind_values(pybind11::module_& module);
/// identify, evaluate, correct, tables, predict, and their results.
void bind_tasks(pybind11::module_& module);
/// close and its result.
void bind_closure(pybind11::module_& module);

}  // namespace trunnion::python
