#include <gmock/gmock.h>

#include <algorithm>

#include "compensation/controller_names.h"
#include "compensation/projection.h"
#include "compensation/verification.h"
#include "error.h"
#include "sample_models.h"
#include "support/noise.h"

// What holds of every controller's tables, and what each may leave: the bounds are unquantised least squares on four
// times denser nodes of the same structure, judged on poses that no emitter has used.

namespace trunnion {
namespace {

using compensation_test::random_model;
using compensation_test::replica_model;
using compensation_test::trunnion_machine;

Machine confirmed_machine(const std::string& controller) {
  Machine machine = trunnion_machine(controller);
  for (const ProfileItem& item : controller_named(controller).questions.items)
    machine.profile[item.key] = std::string("confirmed");
  return machine;
}

/// Position rms of the set at poses of our own.
double left_mm(const Controller& controller, const CompensationTask& task, Angle spacing, Emission emission) {
  const auto played = controller.play(controller.emit(task, spacing, emission), task);
  return spread(task.model, task.chain, pose_sample(task.volume, task.model, 800, 500000), *played).position_rms_mm;
}

class EveryController : public ::testing::TestWithParam<std::string> {
 protected:
  const Controller& controller = controller_named(GetParam());
  Machine machine = confirmed_machine(GetParam());
};

TEST_P(EveryController, StaysWithinFivePercentOfTheBestItsFormatCouldDo) {
  constexpr double kFloor_mm = 0.05e-3;
  for (const Model& model : {replica_model(machine), random_model(machine, 31)}) {
    const TableSet set = make_tables(controller, machine, model, {});
    const CompensationTask task(machine, model, {}, controller.questions);
    const double tables = left_mm(controller, task, set.verification.spacing, {});
    const double bound = left_mm(controller, task, set.verification.spacing, {4, false});
    EXPECT_LT(tables, 1.05 * bound + kFloor_mm);
    EXPECT_LT(tables, 0.9 * set.verification.before.position_rms_mm);
    RecordProperty("left_um", std::to_string(tables * 1e3) + " of " +
                                  std::to_string(set.verification.before.position_rms_mm * 1e3));
  }
}

TEST_P(EveryController, IsADraftUntilEveryQuestionIsConfirmed) {
  if (controller.questions.items.empty()) {  // nothing of it is unverified
    EXPECT_TRUE(make_tables(controller, machine, replica_model(machine), {}).verification.load_ready());
    return;
  }
  machine.profile.erase(controller.questions.items.front().key);
  const TableSet set = make_tables(controller, machine, replica_model(machine), {.date = "2026-11-23"});
  EXPECT_FALSE(set.verification.load_ready());
  EXPECT_EQ(set.verification.unconfirmed, std::vector{controller.questions.items.front().key});
  for (const std::string& name : set.verification.files) EXPECT_NE(name.find(".DRAFT"), std::string::npos) << name;
  EXPECT_NE(std::ranges::find(set.files, "COMMISSIONING.md", &TableFile::name), set.files.end());
  // Played from the folder, drafts and all.
  const auto played = play_tables(set.files, machine, Model{});
  const Model model = replica_model(machine);
  const CompensationTask task(machine, model, {}, controller.questions);
  const auto sample = pose_sample(task.volume, model, 200, 0);
  EXPECT_LT(spread(model, task.chain, sample, *played).position_rms_mm, set.verification.before.position_rms_mm);
}

TEST_P(EveryController, TheOtherAnswerGivesAnotherFileAndTheSameMotion) {
  // Whatever the control is said to do with a sign, files made for that are right on it, and wrong on the other.
  Model model = random_model(machine, 50);
  compensation_test::add_effect(model, machine, "backlash:C", "reversal", 240, "urad");
  for (const ProfileItem& item : controller.questions.items) {
    if (item.answers.size() < 2) continue;
    Machine other = machine;
    other.profile[item.key] = item.answers[1] + " confirmed";
    const CompensationTask here(machine, model, {}, controller.questions),
        there(other, model, {}, controller.questions);
    const Angle spacing = Angle::degrees(15);
    const auto files = controller.emit(there, spacing, {});
    const auto sample = pose_sample(there.volume, model, 100, 0);
    const double right = spread(model, here.chain, sample, *controller.play(files, there)).position_rms_mm;
    // Files made for the cautious answer may be right on both; then those for the other are not, or are not taken.
    const auto played_wrong = [&](const std::vector<TableFile>& set, const CompensationTask& on) {
      try {
        return spread(model, here.chain, sample, *controller.play(set, on)).position_rms_mm;
      } catch (const InputError&) {
        return 1.0;
      }
    };
    const double wrong = std::max(played_wrong(files, here), played_wrong(controller.emit(here, spacing, {}), there));
    const double usual =
        spread(model, here.chain, sample, *controller.play(controller.emit(here, spacing, {}), here)).position_rms_mm;
    EXPECT_NEAR(right, usual, 0.1 * usual + 0.2e-3) << item.key;
    EXPECT_GT(wrong, 1.05 * right) << item.key << ": the emulator does not notice";
  }
}

TEST_P(EveryController, GivesTheSameBytesEveryTime) {
  const Model model = random_model(machine, 51);
  EXPECT_EQ(make_tables(controller, machine, model, {}).files, make_tables(controller, machine, model, {}).files);
}

TEST_P(EveryController, RefusesACorrectionBeyondTheLimits) {
  machine.limits.deviation = Length::micrometres(1);
  machine.limits.tilt = Angle::microradians(1);
  machine.limits.rotary_word = Angle::microradians(1);
  EXPECT_THROW(make_tables(controller, machine, random_model(machine, 52), {}), RangeError);
}

TEST_P(EveryController, RefusesGarbageWithALineAndNeverCrashes) {
  const Model model = random_model(machine, 53);
  const CompensationTask task(machine, model, {}, controller.questions);
  const auto files = controller.emit(task, Angle::degrees(30), {});
  testing::Noise noise(5);
  int refused = 0;
  for (int round = 0; round < 60; ++round) {
    auto broken = files;
    TableFile& file = broken[noise.below(broken.size())];
    for (int k = 0; k < 3 && !file.text.empty(); ++k) {
      const std::size_t at = noise.below(file.text.size());
      switch (noise.below(3)) {
        case 0:
          file.text.erase(at, 1 + noise.below(200));
          break;
        case 1:
          file.text[at] = static_cast<char>(noise.below(256));
          break;
        default:
          file.text.insert(at, "1e99 ");
      }
    }
    try {
      const auto played = controller.play(broken, task);
      for (const Situation& s : pose_sample(task.volume, model, 5, 0)) played->at(s);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
}

INSTANTIATE_TEST_SUITE_P(Tables, EveryController, ::testing::ValuesIn(controller_names()), controller_label);

/// Errors stand where their axis does: on a machine whose axes do not cross, tables leave as little as where they do.
TEST_P(EveryController, LeavesAsLittleWhereTheAxesDoNotCross) {
  Machine apart = machine;
  apart.axes.at('A').origin_mm = {3, -40, 60};
  apart.axes.at('C').origin_mm = {-25, 32, 80};
  const auto left = [&](const Machine& on) {
    const Model model = random_model(on, 54);
    const CompensationTask task(on, model, {}, controller.questions);
    return left_mm(controller, task, Angle::degrees(15), {1, false});
  };
  EXPECT_LT(left(apart), 1.25 * left(machine) + 0.05e-3);
}

TEST(IsgTables, LeaveLessThanThreeTenthsOfAMicrometre) {
  const Machine machine = confirmed_machine("isg-twincat");
  for (const Model& model : {replica_model(machine), random_model(machine, 31)})
    EXPECT_LT(make_tables(controller_named("isg-twincat"), machine, model, {}).verification.tables.position_rms_mm,
              0.3e-3);
}

}  // namespace
}  // namespace trunnion
