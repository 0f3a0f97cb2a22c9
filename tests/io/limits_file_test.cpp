#include "io/limits_file.h"

#include <gmock/gmock.h>

#include "error.h"

namespace trunnion {
namespace {

const std::string kHead = "format = \"trunnion-limits\"\nversion = 1\n";

TEST(LimitsFile, ReadsBothTables) {
  const AlarmLimits limits =
      parse_limits(kHead + "[value]\nEX0C = 10\n[change]\n\"linear_scale:X scale\" = 2.5\n", "l");
  EXPECT_EQ(limits, (AlarmLimits{.value = {{"EX0C", 10}}, .change = {{"linear_scale:X scale", 2.5}}}));
}

TEST(LimitsFile, SaysWhereALimitMakesNoSense) {
  for (const auto& [text, place] : std::vector<std::pair<std::string, std::string>>{{"[value]\nEX0C = 0\n", "l:4"},
                                                                                    {"[value]\nEX0C = \"x\"\n", "l:4"},
                                                                                    {"[values]\nEX0C = 1\n", "l:3"},
                                                                                    {"[value]\nEX0C = -1\n", "l:4"}}) {
    try {
      parse_limits(kHead + text, "l");
      FAIL() << text;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), ::testing::HasSubstr(place)) << text;
    }
  }
}

}  // namespace
}  // namespace trunnion
