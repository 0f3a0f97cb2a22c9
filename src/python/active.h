#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <variant>

#include "compensation/verification.h"
#include "kinematics/machine.h"
#include "model/model.h"
#include "probing/observation.h"

namespace trunnion::python {

/// A controller's compensation files, as tables() gives them.
struct Tables {
  TableSet set;
  std::shared_ptr<const nlohmann::json> verification;  ///< verification.json
};

/// The compensation that was switched on while measuring: a value, or the path of its file or folder.
using Active = std::optional<std::variant<Model, const Tables*, std::filesystem::path>>;

/// The readings as the bare machine would have given them. Throws RefusalError for another machine's compensation.
std::shared_ptr<const ObservationSet> without(const Active& active, const ObservationSet& set, const Machine& machine);

}  // namespace trunnion::python
