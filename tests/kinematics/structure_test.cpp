#include "kinematics/structure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "error.h"

namespace trunnion {
namespace {

TEST(Structure, RunsFromTheWorkpieceToTheTool) {
  const Structure structure = parse_structure("w C' A' Y' b X Z t");
  const std::vector<Joint> wanted = {
      {'C', Side::workpiece}, {'A', Side::workpiece}, {'Y', Side::workpiece}, {'X', Side::tool}, {'Z', Side::tool}};
  EXPECT_EQ(structure.joints, wanted);
  EXPECT_EQ(structure.code, "w C' A' Y' b X Z t");
}

TEST(Structure, NeedsNoBlanks) {
  EXPECT_EQ(parse_structure("wC'A'Y'bXZt").joints, parse_structure("w C' A' Y' b X Z t").joints);
}

TEST(Structure, KnowsHeads) {
  EXPECT_EQ(parse_structure("w X' b Y Z C A t").joints.back(), (Joint{'A', Side::tool}));
  EXPECT_EQ(parse_structure("w C' X' b Y Z B t").joints.front(), (Joint{'C', Side::workpiece}));
}

struct Refusal {
  const char* code;
  const char* why;
};

class RefusedStructure : public ::testing::TestWithParam<Refusal> {};

TEST_P(RefusedStructure, SaysWhy) {
  const std::string wanted = std::string("structure \"") + GetParam().code + "\": " + GetParam().why +
                             "; wanted is a code like \"w C' A' Y' b X Z t\"";
  try {
    parse_structure(GetParam().code);
    FAIL() << "was taken";
  } catch (const ModelError& error) {
    EXPECT_EQ(error.what(), wanted);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Codes, RefusedStructure,
    ::testing::Values(Refusal{"", "it does not end with the tool t"},
                      Refusal{"w C' A' Y' b X Z", "it does not end with the tool t"},
                      Refusal{"C' A' Y' b X Z t", "it does not begin with the workpiece w"},
                      Refusal{"w C A' Y' b X Z t", "axis C has no prime on the workpiece side"},
                      Refusal{"w C' A' Y' b X' Z t", "axis X' is primed on the tool side"},
                      Refusal{"w C' A' Y' X Z t", "axis X has no prime on the workpiece side"},
                      Refusal{"w C' A' Y' b b X Z t", "'b' was not expected there"},
                      Refusal{"w C' A' Y' b X Z t t", "something follows the tool t"},
                      Refusal{"w C' A' Y' b X Z U t", "'U' was not expected there"},
                      Refusal{"w c' A' Y' b X Z t", "'c' was not expected there"},
                      Refusal{"w C' A' Y' b X Y Z t", "axis Y occurs 2 times"},
                      Refusal{"w C' A' b X Z t", "axis Y occurs 0 times"},
                      Refusal{"w A' Y' b X Z t", "axis C occurs 0 times"},
                      Refusal{"w C' Y' b X Z t", "exactly one of the tilting axes A and B is wanted"},
                      Refusal{"w C' A' B' Y' b X Z t", "exactly one of the tilting axes A and B is wanted"}));

}  // namespace
}  // namespace trunnion
