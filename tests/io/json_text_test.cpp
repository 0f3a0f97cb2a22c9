#include "io/json_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "error.h"

namespace trunnion {
namespace {

/// `[part,part,…]`
std::string json_list(const std::string& part, std::size_t count) {
  std::string text = "[" + part;
  for (std::size_t k = 1; k < count; ++k) text += "," + part;
  return text + "]";
}

std::string json_refusal(const std::string& text) {
  try {
    parse_json(text, "m.json");
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(JsonText, RefusesWhatWouldTakeHoursToRead) {
  constexpr std::size_t kMostObjects = 65536, kMostKeys = 1048576;
  EXPECT_EQ(parse_json(json_list("{}", 1000), "m.json").size(), 1000U);
  EXPECT_EQ(json_refusal(json_list("{}", kMostObjects + 1)), "m.json: more than 65536 objects found");
  std::string keys = "{\"0\":0";
  for (std::size_t k = 1; k <= kMostKeys; ++k) keys += ",\"" + std::to_string(k) + "\":0";
  EXPECT_EQ(json_refusal(keys + "}"), "m.json: more than 1048576 keys found");
}

TEST(JsonText, RefusesWhatWouldTakeAllMemory) {
  constexpr std::size_t kMostValues = 16777216;
  EXPECT_EQ(json_refusal(json_list("0", kMostValues + 1)), "m.json: more than 16777216 values found");
  EXPECT_EQ(json_refusal(std::string(kLargestJson_bytes + 1, ' ')),
            "m.json: 268435457 bytes found, 268435456 is the most");
  EXPECT_EQ(json_refusal("[" + std::string(1048577, '\n')),
            "m.json: more than 1048576 blanks found one after another");
}

}  // namespace
}  // namespace trunnion
