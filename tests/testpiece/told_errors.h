#pragma once

#include <nlohmann/json.hpp>

#include "support/undeclared_effects.h"

namespace trunnion {

/// An error of the machine told twice: as an entry of a model, and as the exact machine has it.
struct ToldError {
  nlohmann::json entry;
  std::function<void(testing::VirtualMachine&)> add;
};

/// One of every family of the machine, of a size that a test piece shows. Covariates: load_kg 20, A_clamped 1, 22 C.
std::vector<ToldError> told_errors();

}  // namespace trunnion
