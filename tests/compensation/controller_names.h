#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "compensation/controller.h"

namespace trunnion {

/// The controllers that a test runs over, and how each run is called.
inline std::vector<std::string> controller_names() {
  std::vector<std::string> names;
  for (const Controller& c : controllers()) names.emplace_back(c.name);
  return names;
}
inline std::string controller_label(const ::testing::TestParamInfo<std::string>& named) {
  std::string name = named.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

}  // namespace trunnion
