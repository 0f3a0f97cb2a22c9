#include "error.h"
#include "python/bindings.h"

PYBIND11_MODULE(_trunnion, module) {
  namespace py = pybind11;
  using namespace trunnion;
  module.doc() = "Rotary-axis errors of five-axis machines; see the package trunnion";
  module.attr("__version__") = TRUNNION_VERSION;
  // An exception is told by the last one registered that fits: the base comes first.
  auto& base = py::register_exception<Error>(module, "Error");
  base.doc() = "Whatever goes wrong: one line that says where, what was found and what was wanted";
  py::register_exception<InputError>(module, "InputError", base).doc() =
      "A file or text that does not say what it must";
  py::register_exception<UsageError>(module, "UsageError", base).doc() = "Arguments that make no sense together";
  py::register_exception<ModelError>(module, "ModelError", base).doc() = "A machine or model that contradicts itself";
  py::register_exception<RangeError>(module, "RangeError", base).doc() =
      "A request beyond what was measured, or beyond a limit that protects a machine";
  py::register_exception<RefusalError>(module, "RefusalError", base).doc() =
      "A check that protects a machine was not passed";
  python::bind_values(module);
  python::bind_tasks(module);
  python::bind_closure(module);
}
