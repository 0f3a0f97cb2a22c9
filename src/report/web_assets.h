#pragma once

#include <string_view>

namespace trunnion {

/// The page's style and script as `web/build.sh` bundles them, and the licences of the libraries within.
std::string_view page_style();
std::string_view page_script();
std::string_view page_licences();

}  // namespace trunnion
