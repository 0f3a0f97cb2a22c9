#include "conventions/sign_test.h"

#include <cmath>

#include "error.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr double kTurn_deg = 30, kTilt_deg = 20;
constexpr double kTouched_mm = 2;  // to which a mark is met by hand
constexpr double kShare = 0.05;    // of the way it went
const Eigen::Vector3d kMark_w_mm(70, 70, 0);

std::string xyz_text(const Eigen::Vector3d& v) {
  return fixed_text(v.x(), 1) + ", " + fixed_text(v.y(), 1) + ", " + fixed_text(v.z(), 1);
}

/// X Y Z of the tool's reference point when its tip is at a point of W.
Eigen::Vector3d commanded(const KinematicChain& chain, IndexedPosition at, const Eigen::Vector3d& p_w,
                          double length_mm) {
  return chain.r_from_w(at) * p_w - chain.r_from_t(at) * Eigen::Vector3d(0, 0, -length_mm);
}
Eigen::Vector3d touched(const KinematicChain& chain, IndexedPosition at, const Eigen::Vector3d& xyz, double length_mm) {
  return chain.r_from_w(at).inverse() * (xyz + chain.r_from_t(at) * Eigen::Vector3d(0, 0, -length_mm));
}

std::string position_words(const Machine& machine, IndexedPosition at) {
  return std::string(1, machine.tilt_letter()) + formatted(" %.0f", at.a.in_degrees() + 0.0) +
         formatted(" C %.0f", at.c.in_degrees() + 0.0);
}

/// What a dialect calls the few things that the program needs.
struct Words {
  std::string before, after;  ///< first and last lines
  std::string comment_open, comment_close;
  std::string stop;
  bool klartext = false;
  bool comments = true;
};

Words words_of(const std::string& dialect) {
  if (dialect == "linuxcnc") return {"G21 G90 G49\n", "M2\n", "(", ")", "M0"};
  if (dialect == "fanuc") return {"%\nO7001(SIGN TEST)\nG21 G90 G49\n", "M30\n%\n", "(", ")", "M0"};
  if (dialect == "sinumerik") return {"TRAFOOF\nG71 G90\n", "M30\n", "; ", "", "M0"};
  if (dialect == "heidenhain") return {"0 BEGIN PGM SIGNTEST MM\n", "END PGM SIGNTEST MM\n", "; ", "", "STOP", true};
  // Words that ISO 6983 has for everybody, and no comments, which every control writes in its own way.
  if (dialect == "plain")
    return {
        .before = "G90\n", .after = "M30\n", .comment_open = {}, .comment_close = {}, .stop = "M0", .comments = false};
  throw UsageError("sign test: the dialect \"" + dialect + "\" is not known");
}

}  // namespace

std::vector<SignStep> sign_steps(const Machine& machine) {
  const auto clipped = [](const Axis& axis, double wanted_deg, bool longer_side) {
    if (!axis.range_angle) return Angle::degrees(wanted_deg);
    const double low = axis.range_angle->low.in_degrees(), high = axis.range_angle->high.in_degrees();
    if (longer_side && -low > high) return Angle::degrees(std::max(-wanted_deg, low));
    return Angle::degrees(high >= 1 ? std::min(wanted_deg, high) : std::max(-wanted_deg, low));
  };
  const Angle turn = clipped(machine.turn(), kTurn_deg, false), tilt = clipped(machine.tilt(), kTilt_deg, true);
  return {{{}, ' '}, {{{}, turn}, 'C'}, {{}, 'C'}, {{tilt, {}}, machine.tilt_letter()}};
}

std::string sign_program(const Machine& machine, const std::string& dialect) {
  const Words w = words_of(dialect);
  std::string text;
  int block = 1;
  const auto line = [&](const std::string& what) {
    text += (w.klartext ? std::to_string(block++) + " " : std::string()) + what + "\n";
  };
  const auto say = [&](const std::string& what) {
    if (w.comments) line(w.comment_open + what + w.comment_close);
  };
  text += w.before;
  if (w.klartext) line("M129");
  say("Sign test of the rotary axes. Only they move, one at a time, and none of X Y Z.");
  say("Before the start: tool retracted, way clear for the table, tool-centre-point control off,");
  say("a mark on the table near W 70 70 0, at each stop touched by hand and its place written into the form.");
  line(w.stop);
  int number = 1;
  for (const SignStep& step : sign_steps(machine)) {
    const std::string letter(1, machine.tilt_letter());
    const auto word = [&](const std::string& axis, Angle angle) {
      const double degrees = angle.in_degrees() + 0.0;
      return axis + (w.klartext && degrees >= 0 ? "+" : "") + formatted("%.1f", degrees);
    };
    std::string move = word(letter, step.at.a) + " " + word("C", step.at.c);
    line(w.klartext ? "L " + move + " R0 FMAX" : "G0 " + move);
    say("Stop " + std::to_string(number++) + ": touch the mark by hand, write X Y Z into the form, retract");
    line(w.stop);
  }
  line((w.klartext ? "L " : "G0 ") + std::string(1, machine.tilt_letter()) +
       (w.klartext ? "+0.0 C+0.0 R0 FMAX" : "0.0 C0.0"));
  text += (w.klartext ? std::to_string(block) + " " : std::string()) + w.after;
  return text;
}

std::string sign_form(const Machine& machine) {
  const KinematicChain chain(machine);
  const bool nose = chain.has_rotary(Side::tool);
  std::string text =
      std::string(kFormSerial) + machine.serial +
      "\n# Sign test: at each stop, move the tool's tip by hand onto the mark and write the X Y Z that the control "
      "shows,\n"
      "# in mm, in a work offset whose zero is R's origin. A millimetre is good enough.\n";
  if (nose)
    text +=
        "# An axis of this machine carries the tool: X Y Z are those of the spindle nose (no length compensation), "
        "and\n"
        "# --tool-length tells the tip from it.\n";
  text += "# For a mark at W " + xyz_text(kMark_w_mm) + (nose ? " and a tool of 100 mm" : "") +
          " the machine file wants:\n";
  int number = 1;
  for (const SignStep& step : sign_steps(machine))
    text += "#   stop " + std::to_string(number++) + ", " + position_words(machine, step.at) + ": X Y Z " +
            xyz_text(commanded(chain, step.at, kMark_w_mm, nose ? 100 : 0)) + "\n";
  text += std::string(1, machine.tilt_letter()) + "_deg,C_deg,x_mm,y_mm,z_mm\n";
  for (const SignStep& step : sign_steps(machine))
    text += formatted("%.6g,", step.at.a.in_degrees() + 0.0) + formatted("%.6g,,,\n", step.at.c.in_degrees() + 0.0);
  return text;
}

Checks sign_verdict(const Machine& machine, const std::vector<FilledStep>& filled, double tool_length_mm) {
  const std::vector<SignStep> steps = sign_steps(machine);
  if (filled.size() != steps.size())
    throw UsageError("--form: " + std::to_string(filled.size()) + " rows found, the " + std::to_string(steps.size()) +
                     " of the form are wanted");
  for (std::size_t k = 0; k < steps.size(); ++k)
    if (std::abs((filled[k].at.a - steps[k].at.a).in_degrees()) > 0.1 ||
        std::abs((filled[k].at.c - steps[k].at.c).in_degrees()) > 0.1)
      throw UsageError("--form: row " + std::to_string(k + 1) + " is at " + position_words(machine, filled[k].at) +
                       ", " + position_words(machine, steps[k].at) + " is wanted");
  const KinematicChain chain(machine);
  Checks checks;
  for (std::size_t k = 1; k < steps.size(); ++k) {
    if (steps[k].at == steps[0].at) {
      const double back = (filled[k].xyz_mm - filled[0].xyz_mm).norm();
      checks.push_back({.id = "sign_test.mark",
                        .outcome = back <= kTouched_mm ? Outcome::passed : Outcome::warning,
                        .found = "back at the start the mark was met " + formatted("%.2f mm from where it was", back),
                        .advice = back <= kTouched_mm ? "" : "touch it more carefully, or see whether it slipped"});
      continue;
    }
    const auto expected = [&](IndexedPosition at) {
      return commanded(chain, at, touched(chain, steps[0].at, filled[0].xyz_mm, tool_length_mm), tool_length_mm);
    };
    const Eigen::Vector3d right = expected(steps[k].at), reversed = expected({-steps[k].at.a, -steps[k].at.c});
    const double way = (filled[k].xyz_mm - filled[0].xyz_mm).norm(), limit = kTouched_mm + kShare * way;
    const double off = (filled[k].xyz_mm - right).norm(), off_reversed = (filled[k].xyz_mm - reversed).norm();
    const std::string axis(1, steps[k].moved);
    Check check{.id = "sign_test." + axis, .outcome = Outcome::passed, .found = {}, .advice = {}};
    check.found = "the mark went " + formatted("%.1f mm", way) + ", to within " +
                  formatted("%.1f mm of where the file says", off) + ", " + formatted("%.1f", off_reversed) +
                  " mm of where the other sense would bring it";
    if ((right - reversed).norm() < 4 * limit) {
      check.outcome = Outcome::open;
      check.advice = "the mark is too near to the axis: choose one farther out";
    } else if (off_reversed <= limit) {
      check.outcome = Outcome::failed;
      check.advice = axis + " turns the other way than the machine file says: reverse axis." + axis +
                     ".direction, or find the linear axis that counts the other way";
    } else if (off > limit) {
      check.outcome = Outcome::failed;
      check.advice =
          "neither sense fits: is the offset's zero at R's origin, are the numbers mm, was tool-centre-point "
          "control off?";
    }
    checks.push_back(std::move(check));
  }
  return checks;
}

}  // namespace trunnion
