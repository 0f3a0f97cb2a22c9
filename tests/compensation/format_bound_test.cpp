#include "format_bound.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "compensation/verification.h"
#include "sample_models.h"

// Each controller's tables against the best that its format could do, on poses that no emitter has used.

namespace trunnion {
namespace {

using compensation_test::best_of;
using compensation_test::Format;
using compensation_test::random_model;
using compensation_test::replica_model;
using compensation_test::trunnion_machine;

struct Case {
  std::string controller;
  Format format;
};

class FormatBound : public ::testing::TestWithParam<Case> {};

TEST_P(FormatBound, IsMissedByFivePercentAtMost) {
  constexpr double kShare = 1.05;
  const auto& [name, format] = GetParam();
  const Controller& controller = controller_named(name);
  Machine machine = trunnion_machine(name);
  // Four decimals of a degree cost 0.12 um by themselves; the format is judged unrounded.
  if (name == "heidenhain") machine.profile["com_decimals"] = 6.0;
  for (const Model& model : {replica_model(machine), random_model(machine, 31)}) {
    const CompensationTask task(machine, model, {}, controller.questions);
    const TableSet set = make_tables(controller, machine, model, {});
    const auto sample = pose_sample(task.volume, model, 2000, 700000);
    const Spread tables = spread(model, task.chain, sample, *play_tables(set.files, machine, model));
    // Nodes four times as dense, though no denser than 5 deg, where hats lose less than a thousandth of these maps.
    const double dense_deg = std::max(5.0, set.verification.spacing.in_degrees() / 4);
    const Spread bound = spread(model, task.chain, sample, *best_of(format, machine, model, task.volume, dense_deg));
    const auto whole = [](const Spread& s) { return std::hypot(s.position_rms_mm, 20 * s.orientation_rms_rad); };
    EXPECT_LT(whole(tables), kShare * whole(bound));
    EXPECT_LT(tables.position_rms_mm, kShare * bound.position_rms_mm);
  }
}

TEST(HeidenhainTables, SpendFewEntriesWhereTheyBringMost) {
  const Controller& controller = controller_named("heidenhain");
  Machine machine = trunnion_machine("heidenhain");
  const Model model = random_model(machine, 31);
  double before = std::numeric_limits<double>::infinity();
  for (const double entries : {1.0, 4.0, 12.0}) {
    machine.profile["comptab_entries"] = entries;
    const CompensationTask task(machine, model, {}, controller.questions);
    const auto files = controller.emit(task, Angle::degrees(15), {});
    const auto rows = std::ranges::find(files, "KINEMATICS_COMP.TXT", &TableFile::name);
    ASSERT_NE(rows, files.end());
    int written = 0;
    for (std::size_t at = rows->text.find("Trans"); at != std::string::npos; at = rows->text.find("Trans", at + 1))
      ++written;
    EXPECT_EQ(written, static_cast<int>(entries));
    const auto sample = pose_sample(task.volume, model, 300, 700000);
    const double left = spread(model, task.chain, sample, *controller.play(files, task)).position_rms_mm;
    EXPECT_LT(left, before);
    before = left;
  }
}

INSTANTIATE_TEST_SUITE_P(Tables, FormatBound,
                         ::testing::Values(Case{"sinumerik-840d",
                                                {.pairs = true, .levers = true, .places = true, .directions = true}},
                                           Case{"aerotech", {.pairs = true, .levers = true}},
                                           Case{"heidenhain", {.own_axes = true, .chain = true}},
                                           Case{"fanuc-30i", {.own_axes = true, .places = true}}),
                         [](const auto& named) {
                           std::string text = named.param.controller;
                           std::ranges::replace(text, '-', '_');
                           return text;
                         });

}  // namespace
}  // namespace trunnion
