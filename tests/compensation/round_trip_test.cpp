#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <regex>

#include "compensation/controller_names.h"
#include "compensation/number_text.h"
#include "compensation/verification.h"
#include "error.h"
#include "sample_models.h"
#include "units/angle.h"

// What is written is what was meant, to half of the last digit of every number; and what is read back is what is
// written.

namespace trunnion {
namespace {

using compensation_test::random_model;
using compensation_test::trunnion_machine;

/// A random map, a lost motion of both rotary axes, a scale of X.
Model everything(const Machine& machine, std::uint64_t seed) {
  Model model = random_model(machine, seed);
  compensation_test::add_effect(model, machine, "backlash:C", "reversal", 24, "urad");
  compensation_test::add_effect(model, machine, "backlash:A", "reversal", -17, "urad");
  compensation_test::add_effect(model, machine, "linear_scale:X", "EXX", 60, "um/m");
  return model;
}

struct Number {
  double value;
  int decimals;  ///< of its text
};

/// The numbers of a text; in `words` what stands between them, blanks made one.
std::vector<Number> numbers_of(std::string text, std::string& words) {
  text = std::regex_replace(text, std::regex("model [0-9a-f]{16}"), "model");
  static const std::regex kNumber(R"([-+]?\d+(\.\d+)?(e[-+]?\d+)?)"), kBlanks(R"([ \n]+)");
  std::vector<Number> numbers;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), kNumber); it != std::sregex_iterator(); ++it)
    numbers.push_back({number_from(it->str()).value(), static_cast<int>(std::max<long>(0, it->length(1) - 1))});
  words = std::regex_replace(std::regex_replace(text, kNumber, "#"), kBlanks, " ");
  words = std::regex_replace(words, std::regex(" UNROUNDED"), "");
  return numbers;
}

class RoundTrip : public ::testing::TestWithParam<std::string> {
 protected:
  const Controller& controller = controller_named(GetParam());
  Machine machine = trunnion_machine(GetParam());
};

TEST_P(RoundTrip, EveryNumberIsTheOneMeantToHalfItsLastDigit) {
  constexpr double kBinary = 1e-9;  // of a digit: decimal text of a binary number
  for (std::uint64_t seed = 40; seed < 46; ++seed) {
    const Model model = everything(machine, seed);
    const CompensationTask task(machine, model, {}, controller.questions);
    const auto rounded_set = controller.emit(task, Angle::degrees(30), {1, true}),
               full = controller.emit(task, Angle::degrees(30), {1, false});
    std::size_t fractions = 0;
    for (std::size_t n = 0; n < full.size(); ++n) {
      std::string words, full_words;
      const auto found = numbers_of(rounded_set[n].text, words), meant = numbers_of(full[n].text, full_words);
      ASSERT_EQ(words, full_words);
      ASSERT_EQ(found.size(), meant.size());
      // FANUC's increments are the differences of rounded totals: totals are what half a unit is asked of.
      const bool pitch = rounded_set[n].name == "PARAM.TXT";
      double total = 0, meant_total = 0;
      for (std::size_t k = 0; k < found.size(); ++k) {
        const bool increment = pitch && k > 0 && found[k - 1].value >= 10000 && found[k - 1].value < 19000;
        const bool first = increment && (k < 4 || found[k - 3].value != found[k - 1].value - 1);
        if (increment) {
          total = first ? 0 : total + found[k].value;
          meant_total = first ? 0 : meant_total + meant[k].value;
          ASSERT_NEAR(total, meant_total, 1 + kBinary) << words;  // both ends of the way are rounded
          continue;
        }
        const double half = found[k].decimals == 0 && !pitch ? 0 : 0.5 * std::pow(10.0, -found[k].decimals);
        ASSERT_NEAR(found[k].value, meant[k].value, half * (1 + kBinary) + 1e-15) << full[n].name << " number " << k;
        fractions += found[k].decimals > 2 ? 1 : 0;
      }
    }
    EXPECT_GT(fractions, 5U);
  }
}

/// The largest magnification of a FANUC's parameter file.
double magnification(const std::vector<TableFile>& files) {
  static const std::regex kMagnification(R"(N3623A\dP(\d+);)");
  double most = 1;
  const std::string& text = files.front().text;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), kMagnification); it != std::sregex_iterator(); ++it)
    most = std::max(most, number_from(it->str(1)).value());
  return most;
}

TEST_P(RoundTrip, WhatIsPlayedIsWhatWasMeantToTheHalfDigitsThatItIsMadeOf) {
  // Three components of one number each make sqrt(3) of it; a rotation acts at 260 mm, the far corner.
  const double three = std::sqrt(3.0), corner_mm = 260;
  for (std::uint64_t seed = 40; seed < 46; ++seed) {
    const Model model = everything(machine, seed);
    const CompensationTask task(machine, model, {}, controller.questions);
    const auto files = controller.emit(task, Angle::degrees(30), {1, true});
    const auto rounded_set = controller.play(files, task);
    const auto full = controller.play(controller.emit(task, Angle::degrees(30), {1, false}), task);
    double linear_mm = 1e-9, rotary_rad = 1e-12;  // linuxcnc: the map's numbers are the same in both
    // A function of A, one of C and one of X with 7 decimals; offsets of two axes, seen twice as far after half a turn.
    if (GetParam() == "sinumerik-840d") linear_mm = three * (3 + 4) * 0.5e-7, rotary_rad = 3 * 0.5e-7 * kDegree_rad;
    // Constants, A's and C's errors, X's: 7 decimals of mm, 10 of rad.
    if (GetParam() == "isg-twincat") linear_mm = three * (4 * 0.5e-7 + 3 * 0.5e-10 * corner_mm);
    // A's and C's errors: 4 decimals of mm and of deg.
    if (GetParam() == "heidenhain")
      linear_mm = three * 2 * (0.5e-4 + 0.5e-4 * kDegree_rad * corner_mm), rotary_rad = 0.5e-4 * kDegree_rad;
    // Half a unit of 3623 wherever the axis stands and on either way; places with 4 decimals.
    if (GetParam() == "fanuc-30i")
      linear_mm = three * 4 * 0.5e-4, rotary_rad = 0.5e-4 * magnification(files) * kDegree_rad;
    // The map and six tables of levers: thousandths of um and of mdeg, 4 decimals.
    if (GetParam() == "aerotech") linear_mm = three * 7 * 0.5e-7, rotary_rad = 0.5e-7 * kDegree_rad;
    if (GetParam() == "linuxcnc")
      rotary_rad = 0.5e-9 * kDegree_rad + 1e-11;  // joint tables: 9 decimals of deg, single precision
    for (const Situation& s : pose_sample(task.volume, model, 50, 10)) {
      const AxisCorrection a = rounded_set->at(s), b = full->at(s);
      EXPECT_LT((a.linear_mm - b.linear_mm).norm(), linear_mm);
      EXPECT_NEAR(a.tilt_rad, b.tilt_rad, rotary_rad);
      EXPECT_NEAR(a.turn_rad, b.turn_rad, rotary_rad);
    }
  }
}

/// A model of one kind of error and nothing else.
struct Alone {
  Machine machine;
  Model model;
  TableSet set;
  Alone(const std::string& controller, const std::function<void(Model&, const Machine&)>& add)
      : machine(trunnion_machine(controller)) {
    add(model, machine);
    set = make_tables(controller_named(controller), machine, model, {});
  }
  double left() const { return set.verification.tables.position_rms_mm / set.verification.before.position_rms_mm; }
};

TEST_P(RoundTrip, ACyclicErrorOfOrderSixSurvives) {
  const Alone alone(GetParam(),
                    [](Model& model, const Machine& on) { compensation_test::add_cyclic_error(model, on, 30); });
  EXPECT_GT(alone.set.verification.before.position_rms_mm, 2e-3);
  EXPECT_LT(alone.left(), 0.06);
  EXPECT_LE(alone.set.verification.spacing.in_degrees(), 10) << "six nodes a period at least";
}

TEST_P(RoundTrip, BacklashIsHeldWhereTheControlKnowsTheSenseOfMotionAndNamedWhereItDoesNot) {
  const Alone alone(GetParam(), [](Model& model, const Machine& on) {
    compensation_test::add_effect(model, on, "backlash:C", "reversal", 60, "urad");
    compensation_test::add_effect(model, on, "backlash:A", "reversal", -45, "urad");
  });
  EXPECT_GT(alone.set.verification.before.position_rms_mm, 3e-3);
  if (GetParam() == "isg-twincat" || GetParam() == "aerotech") {
    EXPECT_GT(alone.left(), 0.6);
    const auto& terms = alone.set.verification.lost_terms;
    ASSERT_GE(terms.size(), 2U);
    EXPECT_EQ(terms[0].term, "C_dir");
    EXPECT_EQ(terms[1].term, "A_dir");
  } else {
    EXPECT_LT(alone.left(), 0.03);
  }
}

INSTANTIATE_TEST_SUITE_P(Tables, RoundTrip, ::testing::ValuesIn(controller_names()), controller_label);

/// EBC alone: FANUC has nothing for it but A, which it would turn the wrong way at most turns of C.
TEST(LostTerms, NameTheErrorThatTheFormatCannotSay) {
  const Alone alone("fanuc-30i", [](Model& model, const Machine& machine) {
    RotaryMapContent content;
    content.grid.a_stations = {Angle::degrees(-90), Angle::degrees(0)};
    for (double c = 0; c < 360; c += 15) content.grid.c_stations.push_back(Angle::degrees(c));
    content.grid.tilt.resize(2);
    for (int i = 0; i < 2; ++i)
      for (const Angle c : content.grid.c_stations)
        content.grid.turn.push_back({.rotation_rad = {0, 40e-6 * std::sin(c.in_radians()), 0}});
    model.effects.push_back(std::make_shared<RotaryErrorMap>(std::move(content), effect_context(machine)));
  });
  const Verification& v = alone.set.verification;
  ASSERT_FALSE(v.lost_terms.empty());
  EXPECT_EQ(v.lost_terms.front().term, "EBC");
  EXPECT_NEAR(v.lost_terms.front().position_rms_mm, v.lost_to_format_mm, 0.1 * v.lost_to_format_mm);
  EXPECT_THAT(verification_json(v, alone.machine), ::testing::HasSubstr("\"lost_terms\""));
  EXPECT_THAT(verification_text(v, alone.machine), ::testing::HasSubstr("does not take, um rms each by itself: EBC "));
}

TEST(LostTerms, AreNoneWhereAllIsTaken) {
  const Alone alone("linuxcnc", [](Model& model, const Machine& machine) { model = random_model(machine, 9); });
  EXPECT_TRUE(alone.set.verification.lost_terms.empty());
}

TEST(TableLimits, ASteepTableIsRefusedWithWhereAndWhat) {
  Machine machine = trunnion_machine("aerotech");
  machine.profile["table_slope"] = 1e-5;
  try {
    make_tables(controller_named("aerotech"), machine, random_model(machine, 9), {});
    ADD_FAILURE() << "taken";
  } catch (const RangeError& error) {
    EXPECT_THAT(error.what(),
                ::testing::MatchesRegex("the tables' [XYZAC] changes by [0-9.e-]+ (mm|deg) per deg of [AC] "
                                        "at A -?[0-9.]+ C [0-9.]+ deg, profile.table_slope allows 1e-05"));
  }
}

}  // namespace
}  // namespace trunnion
