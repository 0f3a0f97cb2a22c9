#pragma once

#include <vector>

#include "history/database.h"

namespace trunnion {

/// The statements that make version k + 1 of the tables out of version k, at index k.
const std::vector<std::vector<std::string>>& migrations();

/// The version of the tables that stand in `database`; 0 where there are none.
int schema_version(Database& database);

/// Brings the tables to the version of this program, in one transaction; each row stays what it says. Throws InputError
/// for tables of a later program.
void migrate(Database& database);

}  // namespace trunnion
