#include "geometric_errors/symbol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace trunnion {
namespace {

std::vector<std::string> symbols(char tilt) {
  std::vector<std::string> names;
  for (const LocationError& error : location_errors(tilt)) names.push_back(error.symbol);
  return names;
}

TEST(Symbol, ComponentsRunXYZABC) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < 6; ++k) names.push_back(error_symbol(k, 'C'));
  EXPECT_THAT(names, ::testing::ElementsAre("EXC", "EYC", "EZC", "EAC", "EBC", "ECC"));
  EXPECT_EQ(component_unit(2), Unit::um);
  EXPECT_EQ(component_unit(3), Unit::urad);
}

TEST(Symbol, EightLocationErrorsOfATrunnion) {
  EXPECT_THAT(symbols('A'), ::testing::ElementsAre("EY0A", "EZ0A", "EB0A", "EC0A", "EX0C", "EY0C", "EA0C", "EB0C"));
}

TEST(Symbol, OnABMachineTheTiltingAxisMovesAcrossItself) {
  EXPECT_THAT(symbols('B'), ::testing::ElementsAre("EX0B", "EZ0B", "EA0B", "EC0B", "EX0C", "EY0C", "EA0C", "EB0C"));
}

}  // namespace
}  // namespace trunnion
