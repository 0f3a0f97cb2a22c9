#pragma once

#include <string>
#include <string_view>

#include "model/model.h"

namespace trunnion {

/// A model file (JSON, CONTRACT: Model) for `machine`. Throws InputError with file, line and column for text that is no
/// JSON, or with file and key for what a model must not say.
Model read_model(const std::string& path, const Machine& machine);
/// The same from text; `name` stands for the file in messages.
Model parse_model(std::string_view text, const std::string& name, const Machine& machine);

/// The text of a model's file.
std::string model_text(const Model& model);

/// Throws RefusalError where the model was made for another machine or serial number, ModelError where for another
/// structure.
void check_same_machine(const Model& model, const Machine& machine, const std::string& name);

}  // namespace trunnion
