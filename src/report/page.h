#pragma once

#include <string>

#include "report/evidence.h"

namespace trunnion {

/// The evidence of one machine as one HTML file that needs nothing beside itself: readable without scripts and on
/// paper, alive with them. A section stands for what the evidence holds. Throws InputError where the results are of
/// different machines.
std::string page_html(const Evidence& evidence);

}  // namespace trunnion
