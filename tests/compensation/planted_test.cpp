#include <gmock/gmock.h>

#include <functional>
#include <regex>

#include "compensation/number_text.h"
#include "compensation/verification.h"
#include "error.h"
#include "sample_models.h"

// Faults of sign, unit and index planted into files that are right. An emulator that shared one with its emitter would
// play the faulty file as well as the right one; each must be refused, or leave clearly more than the right file does.

namespace trunnion {
namespace {

/// Every match of `where` in files whose name contains `file`, replaced by what `to` makes of its groups.
struct Fault {
  std::string controller;
  std::string what;
  std::string file;
  std::string where;
  std::function<std::string(const std::smatch&)> to;
};

std::string number_times(const std::string& text, double factor) {
  return fixed_text(number_from(text).value() * factor, 9);
}

/// Groups 1 and 3 as they are, the number of group 2 times `factor`.
std::function<std::string(const std::smatch&)> times(double factor) {
  return [factor](const std::smatch& m) { return m.str(1) + number_times(m.str(2), factor) + m.str(3); };
}
/// The second word in place of the first, and the first in place of the second.
std::function<std::string(const std::smatch&)> exchanged(const std::string& one, const std::string& other) {
  return [=](const std::smatch& m) { return m.str(1) + (m.str(2) == one ? other : one) + m.str(3); };
}
std::function<std::string(const std::smatch&)> whole_number_plus(long step) {
  return [=](const std::smatch& m) { return m.str(1) + std::to_string(std::stol(m.str(2)) + step) + m.str(3); };
}

const double kRadian = 57.29577951308232;
const std::string kSagOfX = R"((OUTPUT_AXIS\[\d+\]=\()(AX[12])(\)))";

std::vector<Fault> faults() {
  return {
      {"sinumerik-840d", "sign of the encoder table of A", "AX4_EEC", R"((ENC_COMP\[0,\d+,AX4\]=)(\S+)())", times(-1)},
      {"sinumerik-840d", "sign of the encoder table of C", "AX5_EEC", R"((ENC_COMP\[0,\d+,AX5\]=)(\S+)())", times(-1)},
      {"sinumerik-840d", "encoder table of A in rad", "AX4_EEC", R"((ENC_COMP\[0,\d+,AX4\]=)(\S+)())",
       times(1 / kRadian)},
      {"sinumerik-840d", "sag values in um", "CEC", R"((AN_CEC\[\d+,\d+\]=)(\S+)())", times(1000)},
      {"sinumerik-840d", "sign of one table", "CEC", R"((AN_CEC\[0,\d+\]=)(\S+)())", times(-1)},
      {"sinumerik-840d", "index for number in MULT_BY_TABLE", "CEC", R"((MULT_BY_TABLE\[\d+\]=)([1-9]\d*)())",
       whole_number_plus(-1)},
      {"sinumerik-840d", "X and Y exchanged", "CEC", kSagOfX, exchanged("AX1", "AX2")},
      {"sinumerik-840d", "products instead of own values", "CEC", R"((MULT_BY_TABLE\[\d+\]=)([1-9]\d*)())",
       [](const std::smatch& m) { return m.str(1) + "0"; }},
      {"sinumerik-840d", "vectors along instead of against the axes", "TRAFO5", R"((AXIS\d_1\[\d\]=)(\S+)())",
       times(-1)},
      {"sinumerik-840d", "C's vector where A's belongs", "TRAFO5", R"((AXIS)([12])(_1))", exchanged("1", "2")},
      {"sinumerik-840d", "sign of what tilts C", "TRAFO5", R"((AXIS2_1\[[01]\]=)(\S+)())", times(-1)},
      {"sinumerik-840d", "X and Y of C's vector exchanged", "TRAFO5", R"((AXIS2_1\[)([01])(\]))", exchanged("0", "1")},
      {"sinumerik-840d", "sign of the offsets", "TRAFO5", R"((OFFSET\w*_1\[\d\]=|TOOL_1\[\d\]=)(\S+)())", times(-1)},
      {"sinumerik-840d", "offset of the part from the first axis", "TRAFO5", R"((PART_OFFSET_1\[0\]=)(\S+)())",
       times(0)},

      {"isg-twincat", "sense of all values", "lis", R"((negate )(TRUE|FALSE)())", exchanged("TRUE", "FALSE")},
      {"isg-twincat", "EXC and EYC exchanged", "csv", R"(()(EXC|EYC)())", exchanged("EXC", "EYC")},
      {"isg-twincat", "EAC and EBC exchanged", "csv", R"(()(EAC|EBC)())", exchanged("EAC", "EBC")},
      {"isg-twincat", "A and C exchanged", "csv", R"(()(A C)( E))", [](const std::smatch&) { return "C A E"; }},
      {"isg-twincat", "errors of A taken for those of C", "csv", R"((E[XYZABC])(A|C)())", exchanged("A", "C")},
      {"isg-twincat", "angles of A in deg", "csv", R"((\n-?\d+ (?:\S+ ){3}\S*)(\d\.\d+)( \S+ \S+(?=\n)))",
       times(kRadian)},

      {"heidenhain", "sign of A's own column", "AXIS_A", R"((\n\d+ +[+-]\S+ +)([+-]\S+)())", times(-1)},
      {"heidenhain", "C1 and C2 exchanged", "AXIS_C", R"(()(C1|C2)())", exchanged("C1", "C2")},
      {"heidenhain", "columns of C in um", "AXIS_C", R"((\n\d+ +[+-]\S+ +[+-]\S+ +)([+-]\S+)())", times(1000)},
      {"heidenhain", "A's rows before C and C's before A", "KINEMATICS", R"((MachAxis +)(A|C)())", exchanged("A", "C")},
      {"heidenhain", "C's table turned round", "AXIS_C", R"((\n\d+ +[+-]\S+ +[+-]\S+ +)([+-]\S+)())", times(-1)},

      {"fanuc-30i", "sign of the increments", "PARAM", R"((N1\d{4}P)(\S+)(;))", times(-1)},
      {"fanuc-30i", "increments one point late", "PARAM", R"((N)(1[0-2]\d{3})(P))", whole_number_plus(1)},
      {"fanuc-30i", "magnification", "PARAM", R"((N3623A\dP)(\S+)(;))", times(10)},
      {"fanuc-30i", "places in um", "PARAM", R"((N1970\dP)(\S+)(;))", times(1000)},
      {"fanuc-30i", "sign of the places", "PARAM", R"((N1970\dP)(\S+)(;))", times(-1)},
      {"fanuc-30i", "second axis counted from the machine's zero", "PARAM", R"((N)(1970[0-5])(P))",
       [](const std::smatch& m) {
         const long n = std::stol(m.str(2));
         return m.str(1) + std::to_string(n < 19703 ? n + 3 : n - 3) + m.str(3);
       }},

      {"aerotech", "values in mm", "cal", R"((CORUNIT=PRIMARY)(/1000)())",
       [](const std::smatch& m) { return m.str(1); }},
      {"aerotech", "rows and columns exchanged", "cal", R"((:START2D )(\d)( )(\d))",
       [](const std::smatch& m) { return m.str(1) + m.str(4) + m.str(3) + m.str(2); }},
      {"aerotech", "X and Y exchanged", "cal", R"((:START2D \d \d )(\d)( )(\d))",
       [](const std::smatch& m) { return m.str(1) + m.str(4) + m.str(3) + m.str(2); }},
      {"aerotech", "rows from elsewhere", "cal", R"((OFFSETCOL=)(\d+)())", times(0.5)},
      {"aerotech", "values to be taken away", "cal", R"((OFFSETROW=0)())",
       [](const std::smatch& m) { return "NEGCOR " + m.str(1); }},
  };
}

/// `text` with the fault, and how often it was planted.
std::pair<std::string, int> planted(const std::string& text, const Fault& fault) {
  const std::regex where(fault.where);
  std::string faulty;
  auto from = text.cbegin();
  int count = 0;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), where); it != std::sregex_iterator(); ++it, ++count) {
    faulty.append(from, text.cbegin() + it->position());
    faulty += fault.to(*it);
    from = text.cbegin() + it->position() + it->length();
  }
  return {faulty.append(from, text.cend()), count};
}

TEST(PlantedFaults, AreRefusedOrSeen) {
  // A fault of a tenth of the smallest table would be one of nobody's; these exchange or turn round whole tables.
  constexpr double kSeen = 1.02;
  for (const Fault& fault : faults()) {
    SCOPED_TRACE(fault.controller + ": " + fault.what);
    const Controller& controller = controller_named(fault.controller);
    const Machine machine = compensation_test::trunnion_machine(fault.controller);
    const Model model = compensation_test::random_model(machine, 77);
    const CompensationTask task(machine, model, {}, controller.questions);
    auto files = controller.emit(task, Angle::degrees(15), {});
    const auto sample = pose_sample(task.volume, model, 200, 300000);
    const double right = spread(model, task.chain, sample, *controller.play(files, task)).position_rms_mm;
    int times_planted = 0;
    for (TableFile& file : files) {
      if (file.name.find(fault.file) == std::string::npos) continue;
      auto [text, count] = planted(file.text, fault);
      file.text = text;
      times_planted += count;
    }
    ASSERT_GT(times_planted, 0) << "nothing to plant it into";
    try {
      EXPECT_GT(spread(model, task.chain, sample, *controller.play(files, task)).position_rms_mm, kSeen * right);
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace trunnion
