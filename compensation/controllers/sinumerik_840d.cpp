#include <algorithm>
#include <cmath>
#include <optional>

#include "compensation/at_reference.h"
#include "compensation/controllers/controllers.h"
#include "compensation/controllers/sinumerik_tables.h"
#include "compensation/controllers/sinumerik_trafo5.h"
#include "compensation/number_text.h"
#include "compensation/projection.h"
#include "error.h"
#include "linear_algebra/factors.h"
#include "units/angle.h"

// SINUMERIK 840D sl and ONE: which functions and products of functions are worth a table of the control
// (sinumerik_tables.h), beside the vectors of its transformation (sinumerik_trafo5.h).

namespace trunnion {
namespace sinumerik_840d_set {
namespace {

using sinumerik::axis_name;
using sinumerik::CecFile;
using sinumerik::Curve;
using sinumerik::header;
using sinumerik::Term;

constexpr Eigen::Index kMostProducts = 5;  // of one output over (A, C)

/// All that could be written, each term with what it brings.
std::vector<Term> terms_of(const CompensationTask& task, const PiecewiseLinear& tilt, const PiecewiseLinear& turn,
                           const std::vector<double>& tilt_at, const std::vector<double>& turn_at,
                           const EffectPtr& followed, Emission emission, std::vector<Curve>& own) {
  const char a = task.machine.tilt_letter();
  const PairFit fit = pair_fit(task, tilt_at, turn_at, followed);
  const AtReference reference(task.volume, tilt, tilt_at, turn, turn_at);
  const Eigen::MatrixXd over_tilt = tilt.projector(tilt_at), over_turn = turn.projector(turn_at);
  const Matrix6d metric = volume_metric(task.volume);
  const auto curve = [&](bool of_tilt, const Eigen::VectorXd& sampled) {
    const Eigen::VectorXd nodes = (of_tilt ? over_tilt : over_turn) * sampled;
    return Curve{of_tilt ? a : 'C',
                 of_tilt ? tilt.nodes() : turn.nodes(),
                 {nodes.begin(), nodes.end()},
                 of_tilt ? Boundary::hold : Boundary::repeat};
  };
  std::vector<Term> terms;
  // What a square of one output is worth: of a shift itself, of a turn by the arms that it has.
  const auto weight_of = [&](char output) {
    if (output >= 'X') return 1.0;
    Situation s;
    s.point_r_mm = task.volume.centre_mm();
    s.at.a = 0.5 * (task.volume.a.low + task.volume.a.high);
    Vector6d twist = Vector6d::Zero();
    twist.tail<3>() = output == 'C' ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
    return kDegree_rad * kDegree_rad * twist.dot(metric * twist);
  };
  const std::pair<char, Eigen::MatrixXd> outputs[] = {{'X', fit.shift_mm[0]},
                                                      {'Y', fit.shift_mm[1]},
                                                      {'Z', fit.shift_mm[2]},
                                                      {a, fit.tilt_rad / kDegree_rad},
                                                      {'C', fit.turn_rad / kDegree_rad}};
  for (const auto& [output, whole] : outputs) {
    const double weight = weight_of(output);
    Eigen::VectorXd f = whole.rowwise().mean();
    Eigen::RowVectorXd g = (whole.colwise() - f).colwise().mean();
    const Eigen::MatrixXd rest = (whole.colwise() - f).rowwise() - g;
    // An axis' own table is zero at its reference by itself; the constant goes to the other axis' table.
    const double constant = output == a ? reference.of_tilt(f) : output == 'C' ? -reference.of_turn(g.transpose()) : 0;
    f.array() -= constant;
    g.array() += constant;
    const auto add = [&, output = output](Curve c, double mean_square, std::optional<Curve> factor = {}) {
      terms.push_back({output, std::move(c), std::move(factor), 0, weight * mean_square});
    };
    if (output == a) {
      own.push_back(curve(true, f));
    } else {
      add(curve(true, f), f.squaredNorm() / static_cast<double>(f.size()));
    }
    if (output == 'C') {
      own.push_back(curve(false, g.transpose()));
    } else {
      add(curve(false, g.transpose()), g.squaredNorm() / static_cast<double>(g.size()));
    }
    const SingularValues svd = singular_values(rest);
    for (Eigen::Index r = 0; r < std::min(kMostProducts, svd.s.size()); ++r) {
      const double sigma = svd.s[r];
      const double largest = svd.v.col(r).cwiseAbs().maxCoeff();
      if (!(sigma > 1e-12) || !(largest > 0)) break;
      add(curve(true, sigma * largest * svd.u.col(r)), sigma * sigma / static_cast<double>(rest.size()),
          curve(false, svd.v.col(r) / largest));
    }
  }
  const Range<Length> strokes[3] = {task.volume.x, task.volume.y, task.volume.z};
  const Eigen::Vector3d spread = task.volume.variance_mm2();
  const double tool = task.volume.tool_length.in_millimetres();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double from = strokes[k].low.in_millimetres(), to = strokes[k].high.in_millimetres(),
                 shift = k == 2 ? tool : 0;
    const Curve ramp{static_cast<char>('X' + k), {from + shift, to + shift}, {from, to}, Boundary::hold};
    const double mean_square = spread[k] + task.volume.centre_mm()[k] * task.volume.centre_mm()[k];
    for (const bool of_tilt : {true, false}) {
      const std::vector<Eigen::Matrix3d>& levers = of_tilt ? fit.tilt_lever : fit.turn_lever;
      for (Eigen::Index output = 0; output < 3; ++output) {
        Eigen::VectorXd lever(static_cast<Eigen::Index>(levers.size()));
        for (Eigen::Index i = 0; i < lever.size(); ++i) lever[i] = levers[static_cast<std::size_t>(i)](output, k);
        const double square = lever.squaredNorm() / static_cast<double>(lever.size());
        terms.push_back({static_cast<char>('X' + output), curve(of_tilt, lever), ramp, 0, square * mean_square, true});
      }
    }
  }
  for (const LinearPart& part : linear_parts(task, 10.0 / emission.refine))
    for (Eigen::Index output = 0; output < 3; ++output) {
      Curve own_axis{part.axis, part.stations_mm, {}, Boundary::hold};
      double square = 0;
      for (std::size_t i = 0; i < part.stations_mm.size(); ++i) {
        own_axis.values.push_back(part.table[i][output] + part.tip[i][output]);
        square += own_axis.values.back() * own_axis.values.back() / static_cast<double>(part.stations_mm.size());
        if (part.axis == 'Z') own_axis.nodes[i] += tool;
      }
      terms.push_back({static_cast<char>('X' + output), own_axis, {}, 0, square});
    }
  // Reversal: a table for one direction of travel only.
  for (const char axis : {a, 'C'}) {
    const double reversal = reversal_rad(task, axis) / kDegree_rad;
    if (std::abs(reversal) < 1e-10) continue;
    const Range<Angle> range = axis == 'C' ? Range<Angle>{Angle(), kFullTurn} : task.volume.a;
    terms.push_back({axis,
                     {axis,
                      {range.low.in_degrees(), range.high.in_degrees()},
                      {-reversal, -reversal},
                      axis == 'C' ? Boundary::repeat : Boundary::hold},
                     {},
                     -1,
                     weight_of(axis) * reversal * reversal / 2});
  }
  constexpr double kWorthwhile_mm2 = 1e-12;  // a nanometre
  std::erase_if(terms, [](const Term& term) { return !(term.gain > kWorthwhile_mm2); });
  return terms;
}

std::vector<TableFile> emit(const CompensationTask& task, Angle spacing, Emission emission) {
  if (task.chain.has_rotary(Side::tool))
    throw RefusalError("sinumerik-840d: structure \"" + task.machine.structure.code +
                       "\": rotary axes that carry the work are wanted");
  // Refined nodes tell what the spacing costs; below a degree nothing of a machine is left to tell.
  const double step =
      emission.refine == 1 ? spacing.in_degrees() : std::max(1.0, spacing.in_degrees() / emission.refine);
  const PiecewiseLinear tilt(even_nodes(task.volume.a.low.in_degrees(), task.volume.a.high.in_degrees(), step),
                             Boundary::hold);
  const PiecewiseLinear turn(even_nodes(0, 360, step), Boundary::repeat);
  const std::vector<double> tilt_at = tilt.sample_points(2), turn_at = turn.sample_points(2);
  std::vector<Curve> own;
  const EffectPtr followed = sets_trafo5(task) ? followed_location(task) : nullptr;
  std::vector<Term> terms = terms_of(task, tilt, turn, tilt_at, turn_at, followed, emission, own);

  const double most_nodes = task.profile.number("cec_points"), most_encoder_nodes = task.profile.number("eec_points");
  const auto longest = static_cast<double>(std::max(tilt.nodes().size(), turn.nodes().size()));
  if (emission.for_the_control() && (longest > most_nodes || longest > most_encoder_nodes))
    throw RangeError("sinumerik-840d: tables of " + shortest_text(longest) + " nodes, profile.cec_points allows " +
                     shortest_text(most_nodes) + " and profile.eec_points " + shortest_text(most_encoder_nodes));

  // Tables are spent where they bring most.
  const auto budget = static_cast<std::size_t>(task.profile.number("cec_tables"));
  CecFile cec(task, emission);
  while (!terms.empty()) {
    const auto value = [&](const Term& term) { return term.gain / static_cast<double>(cec.cost(term)); };
    const auto best = std::ranges::max_element(terms, {}, value);
    if (cec.tables() + cec.cost(*best) <= budget) cec.add(*best);
    terms.erase(best);
  }
  std::vector<TableFile> files;
  for (const Curve& curve : own) files.push_back(eec_file(task, curve, emission));
  if (cec.tables() > 0) files.push_back(cec.file());
  if (followed != nullptr) files.push_back(trafo5_file(task, *followed, emission));
  return files;
}

std::string loading(const CompensationTask& task, const std::vector<TableFile>& files) {
  std::string list;
  for (const TableFile& file : files)
    if (file.name.ends_with(".INI")) list += "   - `" + file.name + "`\n";
  return "## Steps\n\n1. Back up the NC data. See that MD38000 $MA_MM_ENC_COMP_MAX_POINTS and MD18342 "
         "$MN_MM_CEC_MAX_POINTS hold as many nodes as the files\n"
         "   have, and that there are as many tables (profile.cec_tables " +
         shortest_text(task.profile.number("cec_tables")) + ", profile.cec_points " +
         shortest_text(task.profile.number("cec_points")) +
         "). Changing them formats the static memory at the next start.\n"
         "2. While loading, MD32700 $MA_ENC_COMP_ENABLE and MD32710 $MA_CEC_ENABLE of all axes must be 0.\n3. Load the "
         "files:\n" +
         list + (sets_trafo5(task) ? "\n   " + trafo5_loading(task) : "") +
         "4. MD32710 = 1 for X, Y, Z and the rotary axes, MD32700 = 1 for the rotary axes; reset; reference the axes. "
         "Positions change at that moment: stand clear.\n\n"
         "Units are metric, degrees for rotary axes: no inch system (MD10240 = 1), MD32711 alike. Tables over Z assume "
         "a tool of " +
         shortest_text(task.volume.tool_length.in_millimetres()) + " mm.\n\nUndo: MD32700 = 0 and MD32710 = 0, reset" +
         (sets_trafo5(task) ? "; the old values of the transformation's machine data" : "") + ".\n";
}

std::vector<TableFile> commissioning(const CompensationTask& task) {
  const auto table = [&](int t, char input, char output, const char* nodes[3], int multiply, int on) {
    const std::string i = std::to_string(t);
    std::string text;
    for (int k = 0; k < 3; ++k) text += "$AN_CEC[" + i + "," + std::to_string(k) + "]=" + nodes[k] + "\n";
    return text + "$AN_CEC_INPUT_AXIS[" + i + "]=(" + axis_name(task, input) + ")\n$AN_CEC_OUTPUT_AXIS[" + i + "]=(" +
           axis_name(task, output) + ")\n$AN_CEC_STEP[" + i + "]=30\n$AN_CEC_MIN[" + i + "]=-60\n$AN_CEC_MAX[" + i +
           "]=0\n$AN_CEC_DIRECTION[" + i + "]=0\n$AN_CEC_MULT_BY_TABLE[" + i + "]=" + std::to_string(multiply) +
           "\n$AN_CEC_IS_MODULO[" + i + "]=0\n$SN_CEC_TABLE_ENABLE[" + i + "]=" + std::to_string(on) + "\n";
  };
  const char a = task.machine.tilt_letter();
  const char* peak[3] = {"0", "0.02", "0"};
  const char* half[3] = {"0.5", "0.5", "0.5"};
  return {{"one_peak_CEC.INI", header(task, "NC_CEC_INI") + table(0, a, 'Y', peak, 0, 1) + "M17\n"},
          {"product_CEC.INI",
           header(task, "NC_CEC_INI") + table(0, a, 'Y', peak, 2, 1) + table(1, a, 'X', half, 0, 0) + "M17\n"}};
}

}  // namespace
}  // namespace sinumerik_840d_set

Controller sinumerik_840d() {
  using namespace sinumerik_840d_set;
  std::vector<ProfileNumber> numbers = {
      {"cec_tables", "CEC tables that the control has (array size of MD18342)", 62, 1, 200, 1},
      {"cec_points", "nodes of one CEC table (MD18342)", 400, 3, 5000, 1},
      {"eec_points", "nodes of one encoder compensation (MD38000)", 400, 3, 5000, 1},
      {"trafo5_number", "number of the five-axis transformation among those of the channel", 1, 1, 20, 1}};
  double number = 1;
  for (const char* axis : {"X", "Y", "Z", "A", "B", "C"}) {
    numbers.push_back({std::string("axis_number_") + axis, "number of the machine axis", number, 1, 31, 1});
    if (axis[0] != 'A') ++number;
  }
  std::vector<ProfileItem> items = {
      {"cec_sign",
       "Is a CEC value added to the setpoint, or does the axis move against it?",
       {"add", "subtract"},
       "Load `commissioning/one_peak_CEC.INI` as CEC, tilt to -30 deg: Y moves by +0.02 mm if values are added, by "
       "-0.02 if "
       "the axis moves against them."},
      {"cec_product",
       "Does MULT_BY_TABLE put the product in place of the table's own value, or beside it?",
       {"instead of the table's own value", "beside the table's own value"},
       "Load `commissioning/product_CEC.INI`, whose factor 0.5 is switched off, tilt to -30 deg: Y moves by 0.01 mm if "
       "the "
       "product stands alone, by 0.03 if beside. Where the factor does not serve while it is off: by nothing if the "
       "product "
       "stands alone, by 0.02 if beside."},
      {"cec_factor",
       "Does a table still serve as a factor while SD41300 $SN_CEC_TABLE_ENABLE of it is 0?",
       {"works while switched off", "must be switched on"},
       "The same test: with `commissioning/product_CEC.INI` Y moves by 0.01 or 0.03 mm if it does, by 0 or 0.02 if it "
       "does "
       "not. Do not switch the factor on: X would move by half a millimetre."}};
  for (ProfileItem& item : trafo5_questions()) items.push_back(std::move(item));
  return {.name = "sinumerik-840d",
          .title = "SINUMERIK 840D sl, ONE: EEC, CEC and the vectors of the transformation",
          .cannot_hold =
              "lever arms that change with A and C at once as far as neither A and C nor the transformation's vectors "
              "take them, and "
              "more products than there are tables. X, Y and Z follow a leaning axis by the vectors, the tool's axis "
              "does not: A and C set it right only where that costs the position less than it brings at 20 mm.",
          .questions = {items, numbers},
          .spacings = {Angle::degrees(30), Angle::degrees(15), Angle::degrees(10), Angle::degrees(7.5),
                       Angle::degrees(5), Angle::degrees(3)},
          .spacing_loss = Length::micrometres(0.01),
          .emit = emit,
          .play = sinumerik::play,
          .loading = loading,
          .commissioning = commissioning};
}

}  // namespace trunnion
