#pragma once

#include <string>
#include <string_view>

#include "kinematics/machine.h"

namespace trunnion {

/// A machine file (TOML, machines/README.md). Every key is checked: a key that is not known is an error which names the
/// nearest known one. Throws InputError with file and line, what was found and what is wanted.
Machine read_machine(const std::string& path);
/// The same from text; `name` stands for the file in messages.
Machine parse_machine(std::string_view text, const std::string& name);

}  // namespace trunnion
