#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "conventions/machine_checks.h"
#include "conventions/model_checks.h"
#include "conventions/nominal_fit.h"
#include "conventions/reading_checks.h"
#include "conventions/sign_test.h"
#include "error.h"
#include "identification/as_observations.h"
#include "identification/identify.h"
#include "io/machine_file.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"
#include "support/undeclared_effects.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;

constexpr double kSigma_mm = 0.175e-3;

const Check& named(const Checks& checks, const std::string& id) {
  for (const Check& check : checks)
    if (check.id == id) return check;
  static const Check none{.id = "none", .outcome = Outcome::open, .found = {}, .advice = {}};
  ADD_FAILURE() << "no check " << id;
  return none;
}

/// The readings that a probe takes on `machine`, which is built independently of what judges it.
ObservationSet readings(const testing::VirtualMachine& machine, std::uint64_t seed = 1) {
  testing::Noise noise(seed);
  return testing::as_observations(testing::probe(machine, testing::two_top_plan(), {.sigma_mm = kSigma_mm}, noise));
}

TEST(ReadingChecks, RoundingMoreCoarselyThanTheProbeScattersIsSaid) {
  ObservationSet set = readings(testing::smooth_machine(3));
  Machine machine = read_machine(TRUNNION_SOURCE_DIR "/samples/calibrate/machine.toml");
  machine.probe.sigma = Length::micrometres(0.175);
  EXPECT_EQ(coordinate_step_mm(set), 0);
  EXPECT_EQ(rounding_check(set, machine).outcome, Outcome::passed);
  for (const double step_mm : {1e-3, 5e-4, 2e-4}) {
    ObservationSet rounded = set;
    for (Observation& o : rounded.rows) o.position_mm = step_mm * (o.position_mm / step_mm).array().round();
    EXPECT_NEAR(coordinate_step_mm(rounded), step_mm, 1e-12);
    const Check check = rounding_check(rounded, machine);
    EXPECT_EQ(check.outcome, step_mm > 6.1e-4 ? Outcome::warning : Outcome::passed) << "0.175 um is 0.606 um rounded";
    machine.probe.sigma = Length::micrometres(0.1);  // 0.5 um rounded scatter by 0.144 um
    EXPECT_EQ(rounding_check(rounded, machine).outcome, step_mm > 3.5e-4 ? Outcome::warning : Outcome::passed);
    machine.probe.sigma = Length::micrometres(0.175);
  }
  set.rows.resize(20);
  for (Observation& o : set.rows) o.position_mm = o.position_mm.array().round();
  EXPECT_EQ(coordinate_step_mm(set), 0) << "twenty readings say nothing of a step";
}

TEST(MachineChecks, TheLawsHoldOnEveryMachineFile) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TRUNNION_SOURCE_DIR "/machines")) {
    if (entry.path().extension() != ".toml") continue;
    const Checks checks = machine_checks(read_machine(entry.path().string()));
    for (const Check& check : checks) EXPECT_NE(check.outcome, Outcome::failed) << entry.path() << ": " << check.found;
    EXPECT_EQ(named(checks, "law.gauge").outcome, Outcome::passed) << entry.path();
    EXPECT_EQ(named(checks, "law.axis_zero").outcome, Outcome::passed)
        << entry.path() << ": " << named(checks, "law.axis_zero").found;
    ++files;
  }
  EXPECT_GE(files, 10);
}

TEST(MachineChecks, SeeUnitsThatAreNotThoseOfTheFile) {
  Machine machine = testing::plain_machine();
  machine.axes.at('A').range_angle = Range<Angle>{Angle::degrees(-2.0944), Angle::degrees(0.5236)};
  machine.axes.at('X').range_length = Range<Length>{Length::millimetres(-15.7), Length::millimetres(15.7)};
  machine.probe.ball_radius = Length::millimetres(0.118);
  const Checks checks = machine_checks(machine);
  EXPECT_EQ(named(checks, "units.strokes_deg").outcome, Outcome::warning);
  EXPECT_THAT(named(checks, "units.strokes_deg").found, HasSubstr("-120 to 30 deg"));
  EXPECT_EQ(named(checks, "units.lengths_mm").outcome, Outcome::warning);
}

TEST(MachineChecks, SayWhichWayAnAxisTurns) {
  Machine machine = testing::plain_machine();
  EXPECT_THAT(named(machine_checks(machine), "senses.C").found, HasSubstr("about +Z"));
  machine.axes.at('C').direction = -Eigen::Vector3d::UnitZ();
  EXPECT_THAT(named(machine_checks(machine), "senses.C").found, HasSubstr("about -Z"));
}

TEST(ReadingChecks, PassOnAnHonestCalibration) {
  const Checks checks = reading_checks(readings(testing::smooth_machine(3)), testing::plain_machine());
  for (const char* id : {"senses.readings", "origin.A", "origin.C", "strokes", "units.places_mm", "reference.measured",
                         "freedoms", "units.readings"})
    EXPECT_EQ(named(checks, id).outcome, Outcome::passed) << id << ": " << named(checks, id).found;
}

TEST(ReadingChecks, NameTheAxisThatTurnsTheOtherWay) {
  for (const char axis : {'A', 'C'}) {
    testing::VirtualMachine machine = testing::smooth_machine(3);
    machine.axis(axis).direction *= -1;
    const Check& check = named(reading_checks(readings(machine), testing::plain_machine()), "senses.readings");
    EXPECT_EQ(check.outcome, Outcome::failed) << axis;
    EXPECT_THAT(check.advice, HasSubstr(std::string(1, axis) + " the other way round")) << check.found;
  }
}

TEST(ReadingChecks, SeeCommandsInRadians) {
  ObservationSet set = readings(testing::smooth_machine(3));
  for (Observation& o : set.rows) o.at = {Angle::degrees(o.at.a.in_radians()), Angle::degrees(o.at.c.in_radians())};
  const Check& check = named(reading_checks(set, testing::plain_machine()), "senses.readings");
  EXPECT_EQ(check.outcome, Outcome::failed);
  EXPECT_THAT(check.advice, HasSubstr("rad"));
}

TEST(ReadingChecks, SeePlacesInInchAndReadingsInTheWrongUnit) {
  ObservationSet set = readings(testing::smooth_machine(3));
  for (Observation& o : set.rows) o.position_mm /= 25.4;
  const Checks checks = reading_checks(set, testing::plain_machine());
  EXPECT_EQ(named(checks, "units.places_mm").outcome, Outcome::warning);
  EXPECT_EQ(named(checks, "units.readings").outcome, Outcome::warning) << named(checks, "units.readings").found;
}

TEST(ReadingChecks, FindTheAxisLineBesideItsPlace) {
  constexpr double kTold_mm = 0.03;  // the commanded part of a place is nominal: an offset shows along approaches alone
  testing::VirtualMachine machine = testing::perfect_machine("w C' A' Y' b X Z t");
  machine.axis('C').origin_mm += Eigen::Vector3d(40, 0, 0);
  ObservationSet set = readings(machine);
  const std::vector<NominalFit> fits = nominal_fits(set, testing::plain_machine());
  ASSERT_EQ(fits.front().letters, (std::vector<char>{'A', 'C'}));
  EXPECT_NEAR(fits.front().line_offset_mm[1].x(), 40, kTold_mm);
  EXPECT_NEAR(fits.front().line_offset_mm[1].y(), 0, kTold_mm);
  EXPECT_NEAR(fits.front().line_offset_mm[0].norm(), 0, kTold_mm);
  EXPECT_EQ(named(reading_checks(set, testing::plain_machine()), "origin.C").outcome, Outcome::failed);
}

TEST(ReadingChecks, MissTheReferencePoseAndNameWhatCannotBeTested) {
  ObservationSet set = readings(testing::smooth_machine(3));
  std::erase_if(set.rows, [](const Observation& o) { return o.at.a == Angle() && o.at.c == Angle(); });
  set.has_temperature = false;
  const Checks checks = reading_checks(set, testing::plain_machine());
  EXPECT_EQ(named(checks, "reference.measured").outcome, Outcome::failed);
  EXPECT_THAT(named(checks, "covariates").found, HasSubstr("temperature_C"));
  EXPECT_EQ(named(checks, "untestable.temperature").outcome, Outcome::open);
}

TEST(ReadingChecks, SeeAFreedomThatNoApproachReaches) {
  ObservationSet set = readings(testing::smooth_machine(3));
  std::erase_if(set.rows, [](const Observation& o) {  // from above alone at one position: Dx, Dy, Dc are not seen
    return std::abs(o.at.a.in_degrees()) < 1 && std::abs(o.at.c.in_degrees() - 60) < 1 && o.direction.z() > -0.9;
  });
  const Check& check = named(reading_checks(set, testing::plain_machine()), "freedoms");
  EXPECT_EQ(check.outcome, Outcome::warning);
  EXPECT_THAT(check.found, HasSubstr("A 0 C 60"));
}

TEST(SignOfErrors, IsOneForTheMachinesModelAndMinusOneForItsMirror) {
  const Machine machine = testing::plain_machine();
  const testing::VirtualMachine truth = testing::smooth_machine(5);
  const ObservationSet first = readings(truth, 1), second = readings(truth, 2);
  const IdentificationResult found = identify(first, machine);
  const SignOfErrors right = sign_of_errors(second, found.model, machine);
  EXPECT_NEAR(right.k, 1, 0.05);
  EXPECT_LT(right.std, 0.02);
  RotaryMapContent content = found.model.rotary_map()->content();
  content.grid = with_coefficients(content.grid, -content.grid.coefficients());
  content.smooth_coefficients *= -1;
  Model mirror = found.model;
  mirror.effects = {std::make_shared<RotaryErrorMap>(std::move(content), effect_context(machine))};
  EXPECT_NEAR(sign_of_errors(second, mirror, machine).k, -1, 0.05);
  EXPECT_EQ(sign_check(second, mirror, machine).outcome, Outcome::failed);
  EXPECT_EQ(sign_check(second, found.model, machine).outcome, Outcome::passed);
}

/// The place of the tool at each stop, met within half a millimetre, on a machine of ours.
std::vector<FilledStep> filled(const Machine& file, const testing::VirtualMachine& machine) {
  std::vector<FilledStep> rows;
  double off = 0.4;
  for (const SignStep& step : sign_steps(file)) {
    const auto at = testing::ac_degrees(step.at.a.in_degrees(), step.at.c.in_degrees());
    rows.push_back(
        {step.at, machine.r_from_w_nominal(at) * Eigen::Vector3d(63, 81, 12) + Eigen::Vector3d(off, -off, 0.3)});
    off = -off;
  }
  return rows;
}

TEST(SignTest, PassesOnTheMachineOfTheFileAndNamesTheAxisThatIsNot) {
  const Machine file = testing::plain_machine();
  testing::VirtualMachine machine = testing::perfect_machine("w C' A' Y' b X Z t");
  for (const Check& check : sign_verdict(file, filled(file, machine), 0))
    EXPECT_EQ(check.outcome, Outcome::passed) << check.found;
  for (const char axis : {'A', 'C'}) {
    testing::VirtualMachine reversed = machine;
    reversed.axis(axis).direction *= -1;
    const Checks checks = sign_verdict(file, filled(file, reversed), 0);
    EXPECT_EQ(named(checks, std::string("sign_test.") + axis).outcome, Outcome::failed);
    EXPECT_THAT(named(checks, std::string("sign_test.") + axis).advice, HasSubstr("the other way"));
    EXPECT_EQ(named(checks, std::string("sign_test.") + (axis == 'A' ? 'C' : 'A')).outcome, Outcome::passed);
  }
}

TEST(SignTest, SeesPlacesToldFromAnotherZeroAndAMarkThatSlipped) {
  const Machine file = testing::plain_machine();
  std::vector<FilledStep> rows = filled(file, testing::perfect_machine("w C' A' Y' b X Z t"));
  for (FilledStep& row : rows) row.xyz_mm += Eigen::Vector3d(120, 40, -300);
  EXPECT_EQ(named(sign_verdict(file, rows, 0), "sign_test.C").outcome, Outcome::failed);
  rows = filled(file, testing::perfect_machine("w C' A' Y' b X Z t"));
  rows[2].xyz_mm.x() += 5;
  EXPECT_EQ(named(sign_verdict(file, rows, 0), "sign_test.mark").outcome, Outcome::warning);
  rows.pop_back();
  EXPECT_THROW(sign_verdict(file, rows, 0), UsageError);
}

TEST(SignTest, FollowsTheSpindleNoseWhereAnAxisCarriesTheTool) {
  constexpr double kLength_mm = 130;
  const Machine file = parse_machine(
      "format = \"trunnion-machine\"\nversion = 1\nname = \"head\"\nserial = \"1\"\nstructure = \"w C' b X Y Z B t\"\n",
      "head.toml");
  for (const double sense : {1.0, -1.0}) {
    std::vector<FilledStep> rows;
    for (const SignStep& step : sign_steps(file)) {
      const Eigen::AngleAxisd turn(step.at.c.in_radians(), Eigen::Vector3d::UnitZ());
      const Eigen::AngleAxisd swivel(sense * step.at.a.in_radians(), Eigen::Vector3d::UnitY());
      rows.push_back({step.at, turn * Eigen::Vector3d(70, 60, 5) + swivel * Eigen::Vector3d(0, 0, kLength_mm)});
    }
    const Checks checks = sign_verdict(file, rows, kLength_mm);
    EXPECT_EQ(named(checks, "sign_test.B").outcome, sense > 0 ? Outcome::passed : Outcome::failed);
    EXPECT_EQ(named(checks, "sign_test.C").outcome, Outcome::passed);
  }
}

}  // namespace
}  // namespace trunnion
