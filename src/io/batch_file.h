#pragma once

#include <string>

#include "batch/batch_plan.h"

namespace trunnion {

/// A batch plan (TOML, format = "trunnion-batch", version = 1): `seed`; [machines] with `folder`, each folder below it
/// being one machine (machine.toml, and observations.csv or model.json), or those that `names` lists; [tables] with
/// `controllers`; [[program]] with `name`, `file`, `job`; [[piece]] with `name`, `file`, `draws`, `first_order`,
/// `corrected`, `tables`. Files are told from the plan's own folder. Throws InputError with file and line.
BatchPlan read_batch_plan(const std::string& path);

}  // namespace trunnion
