#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "compensation/controllers/controllers.h"
#include "compensation/controllers/sinumerik_assignments.h"
#include "compensation/controllers/sinumerik_trafo5.h"
#include "compensation/grid_table.h"
#include "compensation/number_text.h"
#include "compensation/projection.h"
#include "error.h"

// SINUMERIK 840D sl and ONE: encoder error compensation (EEC) of A and C, sag compensation tables (CEC): functions of
// one axis that act on another, and products of two of them; beside them the vectors of the transformation
// (sinumerik_trafo5.h).

namespace trunnion {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kOutputDecimals = 7;         // mm or deg
constexpr int kFactorDecimals = 12;        // factors of products carry other units
constexpr Eigen::Index kMostProducts = 5;  // of one output over (A, C)
constexpr const char* kCecFile = "CEC.INI";

std::string axis_name(const CompensationTask& task, char axis) {
  return "AX" + shortest_text(task.profile.number(std::string("axis_number_") + axis));
}
std::string eec_file(const CompensationTask& task, char axis) { return axis_name(task, axis) + "_EEC.INI"; }

/// A function of one axis at even nodes.
struct Curve {
  char input = 'A';
  std::vector<double> nodes, values;
  Boundary boundary = Boundary::hold;
};

/// A contribution to one output axis, in mm or degrees: a curve, or the product of two.
struct Term {
  char output = 'X';
  Curve curve;
  std::optional<Curve> factor;
  int direction = 0;
  double gain = 0;    ///< mean square of the deviation that it takes away, mm^2
  bool ramp = false;  ///< `factor` is a coordinate itself, which terms share
};

std::string header(const CompensationTask& task, const char* name) {
  std::string text = std::string("%_N_") + name + "\nCHANDATA(1)\n; " + provenance(task) + "\n";
  if (!task.profile.load_ready()) text += "; DRAFT, NOT LOAD-READY: see COMMISSIONING.md\n";
  return text;
}

std::string value_text(double value, int decimals, Emission emission) {
  return emission.quantised ? fixed_text(value, decimals) : shortest_text(value);
}

double step_of(const Curve& curve) {
  return (curve.nodes.back() - curve.nodes.front()) / static_cast<double>(curve.nodes.size() - 1);
}

std::string eec_text(const CompensationTask& task, const Curve& curve, Emission emission) {
  const std::string axis = axis_name(task, curve.input);
  std::string text = header(task, (axis + "_EEC_INI").c_str());
  // The control takes a value away: a positive one moves the axis in negative direction.
  for (std::size_t k = 0; k < curve.values.size(); ++k)
    text += "$AA_ENC_COMP[0," + std::to_string(k) + "," + axis +
            "]=" + value_text(-curve.values[k], kOutputDecimals, emission) + "\n";
  const std::string index = "[0," + axis + "]=";
  return text + "$AA_ENC_COMP_STEP" + index + shortest_text(rounded(step_of(curve), 12)) + "\n$AA_ENC_COMP_MIN" +
         index + shortest_text(curve.nodes.front()) + "\n$AA_ENC_COMP_MAX" + index + shortest_text(curve.nodes.back()) +
         "\n$AA_ENC_COMP_IS_MODULO" + index + (curve.boundary == Boundary::repeat ? "1" : "0") + "\nM17\n";
}

/// All tables of one file: numbers run as tables are added.
class CecFile {
 public:
  CecFile(const CompensationTask& task, Emission emission) : task_(task), emission_(emission) {
    sign_ = task.profile.answer("cec_sign") == "add" ? 1 : -1;
    adds_plain_ = task.profile.answer("cec_product") == "beside the table's own value";
    factor_alone_ = task.profile.answer("cec_factor") == "works while switched off";
  }

  /// How many tables `term` takes on top of what is there.
  std::size_t cost(const Term& term) const {
    if (!term.factor) return 1;
    const bool shared = term.ramp && ramps_.contains(term.factor->input);
    return 1 + (shared ? 0 : (factor_alone_ ? 1 : 2));
  }

  void add(const Term& term) {
    if (!term.factor) {
      write(term.output, scaled(term.curve, sign_), 0, term.direction, kOutputDecimals, true);
      return;
    }
    // Where a table's own value counts beside its product, f + f (g - 1) = f g.
    Curve factor = *term.factor;
    if (adds_plain_)
      for (double& value : factor.values) value -= 1;
    std::size_t number = 0;
    if (const auto found = ramps_.find(factor.input); term.ramp && found != ramps_.end()) {
      number = found->second;
    } else {
      number = write(term.output, factor, 0, 0, kFactorDecimals, !factor_alone_);
      // A factor that must be switched on acts by itself: take that away again.
      if (!factor_alone_) write(term.output, scaled(factor, -1), 0, 0, kFactorDecimals, true);
      if (term.ramp) ramps_[factor.input] = number;
    }
    write(term.output, scaled(term.curve, sign_), number, 0, kFactorDecimals, true);
  }

  std::size_t tables() const { return count_; }
  std::string text() const { return header(task_, "NC_CEC_INI") + text_ + "M17\n"; }

 private:
  static Curve scaled(Curve curve, double factor) {
    for (double& value : curve.values) value *= factor;
    return curve;
  }

  /// Writes one table and returns its number (its index plus one).
  std::size_t write(char output, const Curve& curve, std::size_t multiply_by, int direction, int decimals,
                    bool switched_on) {
    const std::string t = std::to_string(count_);
    for (std::size_t k = 0; k < curve.values.size(); ++k)
      text_ +=
          "$AN_CEC[" + t + "," + std::to_string(k) + "]=" + value_text(curve.values[k], decimals, emission_) + "\n";
    const auto line = [&](const char* what, const std::string& value) {
      text_ += std::string("$AN_CEC_") + what + "[" + t + "]=" + value + "\n";
    };
    line("INPUT_AXIS", "(" + axis_name(task_, curve.input) + ")");
    line("OUTPUT_AXIS", "(" + axis_name(task_, output) + ")");
    line("STEP", shortest_text(rounded(step_of(curve), 12)));
    line("MIN", shortest_text(curve.nodes.front()));
    line("MAX", shortest_text(curve.nodes.back()));
    line("DIRECTION", std::to_string(direction));
    line("MULT_BY_TABLE", std::to_string(multiply_by));
    line("IS_MODULO", curve.boundary == Boundary::repeat ? "1" : "0");
    text_ += "$SN_CEC_TABLE_ENABLE[" + t + "]=" + (switched_on ? "1" : "0") + "\n";
    return ++count_;
  }

  const CompensationTask& task_;
  Emission emission_;
  double sign_;
  bool adds_plain_, factor_alone_;
  std::size_t count_ = 0;
  std::map<char, std::size_t> ramps_;
  std::string text_;
};

/// All that could be written, each term with what it brings.
std::vector<Term> terms_of(const CompensationTask& task, const PiecewiseLinear& tilt, const PiecewiseLinear& turn,
                           const std::vector<double>& tilt_at, const std::vector<double>& turn_at,
                           const EffectPtr& followed, Emission emission, std::vector<Curve>& own) {
  const char a = task.machine.tilt_letter();
  const PairFit fit = pair_fit(task, tilt_at, turn_at, followed);
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
    return kDegree * kDegree * twist.dot(metric * twist);
  };
  const std::pair<char, Eigen::MatrixXd> outputs[] = {{'X', fit.shift_mm[0]},
                                                      {'Y', fit.shift_mm[1]},
                                                      {'Z', fit.shift_mm[2]},
                                                      {a, fit.tilt_rad / kDegree},
                                                      {'C', fit.turn_rad / kDegree}};
  for (const auto& [output, whole] : outputs) {
    const double weight = weight_of(output);
    const Eigen::VectorXd f = whole.rowwise().mean();
    const Eigen::RowVectorXd g = (whole.colwise() - f).colwise().mean();
    const Eigen::MatrixXd rest = (whole.colwise() - f).rowwise() - g;
    const auto add = [&](Curve c, double mean_square, std::optional<Curve> factor = {}) {
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
    const Eigen::BDCSVD<Eigen::MatrixXd> svd(rest, Eigen::ComputeThinU | Eigen::ComputeThinV);
    for (Eigen::Index r = 0; r < std::min(kMostProducts, svd.singularValues().size()); ++r) {
      const double sigma = svd.singularValues()[r];
      const double largest = svd.matrixV().col(r).cwiseAbs().maxCoeff();
      if (!(sigma > 1e-12) || !(largest > 0)) break;
      add(curve(true, sigma * largest * svd.matrixU().col(r)), sigma * sigma / static_cast<double>(rest.size()),
          curve(false, svd.matrixV().col(r) / largest));
    }
  }
  const Range<Length> strokes[3] = {task.volume.x, task.volume.y, task.volume.z};
  const Eigen::Vector3d spread = task.volume.variance_mm2();
  const double tool = task.volume.tool_length.in_millimetres();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double from = strokes[k].low.in_millimetres(), to = strokes[k].high.in_millimetres(),
                 shift = k == 2 ? tool : 0;
    const Curve ramp{static_cast<char>('X' + k), {from + shift, to + shift}, {from, to}, Boundary::hold};
    for (Eigen::Index output = 0; output < 3; ++output) {
      Eigen::VectorXd lever(static_cast<Eigen::Index>(tilt_at.size()));
      for (Eigen::Index i = 0; i < lever.size(); ++i) lever[i] = fit.lever[static_cast<std::size_t>(i)](output, k);
      const double square = lever.squaredNorm() / static_cast<double>(lever.size());
      const Eigen::Vector3d centre = task.volume.centre_mm();
      terms.push_back({static_cast<char>('X' + output), curve(true, lever), ramp, 0,
                       square * (spread[k] + centre[k] * centre[k]), true});
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
    const double reversal = reversal_rad(task, axis) / kDegree;
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
  const double step = spacing.in_degrees() / emission.refine;
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
  for (const Curve& curve : own) files.push_back({eec_file(task, curve.input), eec_text(task, curve, emission)});
  if (cec.tables() > 0) files.push_back({kCecFile, cec.text()});
  if (followed != nullptr) files.push_back(trafo5_file(task, *followed, emission));
  return files;
}

/// One table as the control holds it.
struct HeldTable {
  std::string output;
  Curve curve;
  int direction = 0;
  std::size_t multiply_by = 0;
  bool on = true;
};

class Reader : public SinumerikAssignments {
 public:
  using SinumerikAssignments::SinumerikAssignments;

  /// The nodes MIN + N STEP and their values, `node_index` giving the index text of node N.
  template <class NodeIndex>
  Curve curve(const std::string& name, const std::string& index, NodeIndex node_index) const {
    const double step = number(name + "_STEP", index), from = number(name + "_MIN", index),
                 to = number(name + "_MAX", index);
    const double cells = (to - from) / step;
    if (!(step > 0) || !(cells >= 1) || !(cells < 1e5) || std::abs(cells - std::round(cells)) > 1e-6)
      throw InputError(file_name(), name + "[" + index + "]: (MAX - MIN) / STEP is " + shortest_text(cells) +
                                        ", a whole number is wanted");
    Curve c;
    c.boundary = number(name + "_IS_MODULO", index) == 1 ? Boundary::repeat : Boundary::hold;
    const auto last = static_cast<std::size_t>(std::round(cells));
    for (std::size_t n = 0; n <= last; ++n) {
      c.nodes.push_back(n == last ? to : from + static_cast<double>(n) * step);
      c.values.push_back(number(name, node_index(n)));
    }
    if (c.boundary == Boundary::repeat && c.values.front() != c.values.back())
      throw InputError(file_name(), name + "[" + index + "]: a modulo table jumps where it closes: " +
                                        shortest_text(c.values.front()) + " and " + shortest_text(c.values.back()));
    return c;
  }
};

class Sinumerik : public PlayedCompensation {
 public:
  explicit Sinumerik(const CompensationTask& task) : tilt_(task.machine.tilt_letter()) {
    for (const char axis : {'X', 'Y', 'Z', tilt_, 'C'}) letters_[axis_name(task, axis)] = axis;
    if (letters_.size() != 5) throw ModelError("profile.axis_number_X …: two axes have the same number");
    sign_ = task.profile.answer("cec_sign") == "subtract" ? -1 : 1;
    replaces_ = task.profile.answer("cec_product") == "instead of the table's own value";
    needs_on_ = task.profile.answer("cec_factor") == "must be switched on";
  }

  void load_transformation(const TableFile& file, const CompensationTask& task) {
    nominal_ = task.chain;
    believed_ = read_trafo5(file, task);
  }

  void load_encoder(const TableFile& file) {
    const Reader reader(file);
    for (const auto& [index, value] : reader.all("$AA_ENC_COMP_STEP")) {
      const std::string axis = index.substr(index.find(',') + 1);
      Curve c =
          reader.curve("$AA_ENC_COMP", index, [&](std::size_t n) { return "0," + std::to_string(n) + "," + axis; });
      c.input = letter(file, axis);
      encoder_.push_back(std::move(c));
    }
  }

  void load_sag(const TableFile& file) {
    const Reader reader(file);
    for (const auto& [index, value] : reader.all("$AN_CEC_STEP")) {
      const auto t = integer_from(index);
      if (!t || *t < 0 || *t > 9999)
        throw InputError(file.name, "$AN_CEC_STEP[" + index + "]: a table index is wanted");
      HeldTable table;
      table.curve = reader.curve("$AN_CEC", index, [&](std::size_t n) { return index + "," + std::to_string(n); });
      table.curve.input = letter(file, reader.text("$AN_CEC_INPUT_AXIS", index));
      table.output = std::string(1, letter(file, reader.text("$AN_CEC_OUTPUT_AXIS", index)));
      table.direction = static_cast<int>(reader.number("$AN_CEC_DIRECTION", index));
      const double factor = reader.number("$AN_CEC_MULT_BY_TABLE", index);
      if (!(factor >= 0 && factor <= 9999))
        throw InputError(file.name, "$AN_CEC_MULT_BY_TABLE[" + index + "]: a table number is wanted");
      table.multiply_by = static_cast<std::size_t>(factor);
      table.on = reader.number("$SN_CEC_TABLE_ENABLE", index) == 1;
      sag_[static_cast<std::size_t>(*t)] = std::move(table);
    }
    for (const auto& [t, table] : sag_)
      if (table.multiply_by != 0 && !sag_.contains(table.multiply_by - 1))
        throw InputError(file.name, "$AN_CEC_MULT_BY_TABLE[" + std::to_string(t) + "]: there is no table number " +
                                        std::to_string(table.multiply_by));
  }

  AxisCorrection at(const Situation& s) const override {
    const std::map<char, double> position = {{'X', s.point_r_mm.x()},
                                             {'Y', s.point_r_mm.y()},
                                             {'Z', s.point_r_mm.z() + s.tool_length_mm},
                                             {tilt_, s.at.a.in_degrees()},
                                             {'C', s.at.c.in_degrees()}};
    std::map<char, double> moved;
    const auto value = [&](const Curve& c) {
      return interpolated(c.nodes, c.values, c.boundary, position.at(c.input));
    };
    // The actual value is raised by the table, so the axis ends up that much lower.
    for (const Curve& c : encoder_) moved[c.input] -= value(c);
    for (const auto& [t, table] : sag_) {
      const int sense = table.curve.input == 'C' ? s.turn_sense : table.curve.input == tilt_ ? s.tilt_sense : 0;
      if (!table.on || (table.direction != 0 && table.direction != sense)) continue;
      const double plain = value(table.curve);
      double sum = plain;
      if (table.multiply_by != 0) {
        const HeldTable& factor = sag_.at(table.multiply_by - 1);
        const double product = needs_on_ && !factor.on ? 0 : plain * value(factor.curve);
        sum = replaces_ ? product : plain + product;
      }
      moved[table.output[0]] += sign_ * sum;
    }
    const auto of = [&](char axis) { return moved.contains(axis) ? moved.at(axis) : 0.0; };
    Eigen::Vector3d linear(of('X'), of('Y'), of('Z'));
    // The transformation goes where it believes the point of the workpiece to be.
    if (believed_)
      linear += believed_->r_from_w(s.at) * (nominal_->r_from_w(s.at).inverse() * s.point_r_mm) - s.point_r_mm;
    return {linear, of(tilt_) * kDegree, of('C') * kDegree};
  }

 private:
  char letter(const TableFile& file, const std::string& axis) const {
    const auto found = letters_.find(axis);
    if (found == letters_.end()) throw InputError(file.name, "axis " + axis + ": not an axis of this machine");
    return found->second;
  }

  char tilt_;
  double sign_;
  bool replaces_, needs_on_;
  std::map<std::string, char> letters_;
  std::vector<Curve> encoder_;
  std::map<std::size_t, HeldTable> sag_;
  std::optional<KinematicChain> nominal_, believed_;
};

std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task) {
  auto control = std::make_unique<Sinumerik>(task);
  bool any = false;
  for (const TableFile& file : files) {
    if (file.name.ends_with("_EEC.INI")) control->load_encoder(file), any = true;
    if (file.name == kCecFile) control->load_sag(file), any = true;
    if (file.name == kTrafo5File) control->load_transformation(file, task);
  }
  if (!any) throw InputError(kCecFile, "missing, and there is no *_EEC.INI");
  return control;
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
  const auto table = [&](int t, char input, char output, const char* nodes[3], int multiply) {
    const std::string i = std::to_string(t);
    std::string text;
    for (int k = 0; k < 3; ++k) text += "$AN_CEC[" + i + "," + std::to_string(k) + "]=" + nodes[k] + "\n";
    return text + "$AN_CEC_INPUT_AXIS[" + i + "]=(" + axis_name(task, input) + ")\n$AN_CEC_OUTPUT_AXIS[" + i + "]=(" +
           axis_name(task, output) + ")\n$AN_CEC_STEP[" + i + "]=30\n$AN_CEC_MIN[" + i + "]=-60\n$AN_CEC_MAX[" + i +
           "]=0\n$AN_CEC_DIRECTION[" + i + "]=0\n$AN_CEC_MULT_BY_TABLE[" + i + "]=" + std::to_string(multiply) +
           "\n$AN_CEC_IS_MODULO[" + i + "]=0\n$SN_CEC_TABLE_ENABLE[" + i + "]=1\n";
  };
  const char a = task.machine.tilt_letter();
  const char* peak[3] = {"0", "0.02", "0"};
  const char* half[3] = {"0.5", "0.5", "0.5"};
  return {{"one_peak_CEC.INI", header(task, "NC_CEC_INI") + table(0, a, 'Y', peak, 0) + "M17\n"},
          {"product_CEC.INI",
           header(task, "NC_CEC_INI") + table(0, a, 'Y', peak, 2) + table(1, a, 'X', half, 0) + "M17\n"}};
}

}  // namespace

Controller sinumerik_840d() {
  std::vector<ProfileNumber> numbers = {
      {"cec_tables", "CEC tables that the control has (array size of MD18342)", 62, 1, 200},
      {"cec_points", "nodes of one CEC table (MD18342)", 400, 3, 5000},
      {"eec_points", "nodes of one encoder compensation (MD38000)", 400, 3, 5000},
      {"trafo5_number", "number of the five-axis transformation among those of the channel", 1, 1, 20}};
  double number = 1;
  for (const char* axis : {"X", "Y", "Z", "A", "B", "C"}) {
    numbers.push_back({std::string("axis_number_") + axis, "number of the machine axis", number, 1, 31});
    if (axis[0] != 'A') ++number;
  }
  std::vector<ProfileItem> items = {
      {"cec_sign",
       "Is a CEC value added to the setpoint, or does the axis move against it?",
       {"add", "subtract"},
       "Load commissioning/one_peak, tilt to -30 deg: Y moves +0.02 mm if values are added."},
      {"cec_product",
       "Does MULT_BY_TABLE put the product in place of the table's own value, or beside it?",
       {"instead of the table's own value", "beside the table's own value"},
       "Load commissioning/product, tilt to -30 deg: Y moves 0.01 mm if the product stands alone, 0.03 mm if "
       "beside."},
      {"cec_factor",
       "Does a table still serve as a factor while SD41300 $SN_CEC_TABLE_ENABLE of it is 0?",
       {"works while switched off", "must be switched on"},
       "With commissioning/product loaded set SD41300[1] = 0: see whether Y still moves by the product."}};
  for (ProfileItem& item : trafo5_questions()) items.push_back(std::move(item));
  return {.name = "sinumerik-840d",
          .title = "SINUMERIK 840D sl, ONE: EEC, CEC and the vectors of the transformation",
          .cannot_hold =
              "lever arms that change with C as far as neither A and C nor the transformation's vectors take them, and "
              "more products than there are tables.",
          .questions = {items, numbers},
          .spacings = {Angle::degrees(30), Angle::degrees(15), Angle::degrees(10), Angle::degrees(7.5),
                       Angle::degrees(5), Angle::degrees(3)},
          .emit = emit,
          .play = play,
          .loading = loading,
          .commissioning = commissioning};
}

}  // namespace trunnion
