#include "compensation/controllers/sinumerik_tables.h"

#include "compensation/number_text.h"

namespace trunnion::sinumerik {
namespace {

constexpr int kOutputDecimals = 7;   // mm or deg
constexpr int kFactorDecimals = 12;  // factors of products carry other units

std::string value_text(double value, int decimals, Emission emission) {
  return emission.quantised ? fixed_text(value, decimals) : shortest_text(value);
}

double step_of(const Curve& curve) {
  return (curve.nodes.back() - curve.nodes.front()) / static_cast<double>(curve.nodes.size() - 1);
}

Curve scaled(Curve curve, double factor) {
  for (double& value : curve.values) value *= factor;
  return curve;
}

}  // namespace

std::string axis_name(const CompensationTask& task, char axis) {
  return "AX" + shortest_text(task.profile.number(std::string("axis_number_") + axis));
}

std::string header(const CompensationTask& task, const std::string& name) {
  return "%_N_" + name + "\nCHANDATA(1)\n" + comment_header(task, ";");
}

TableFile eec_file(const CompensationTask& task, const Curve& curve, Emission emission) {
  const std::string axis = axis_name(task, curve.input);
  std::string text = header(task, axis + "_EEC_INI");
  // The control takes a value away: a positive one moves the axis in negative direction.
  for (std::size_t k = 0; k < curve.values.size(); ++k)
    text += "$AA_ENC_COMP[0," + std::to_string(k) + "," + axis +
            "]=" + value_text(-curve.values[k], kOutputDecimals, emission) + "\n";
  const std::string index = "[0," + axis + "]=";
  text += "$AA_ENC_COMP_STEP" + index + shortest_text(rounded(step_of(curve), 12)) + "\n$AA_ENC_COMP_MIN" + index +
          shortest_text(curve.nodes.front()) + "\n$AA_ENC_COMP_MAX" + index + shortest_text(curve.nodes.back()) +
          "\n$AA_ENC_COMP_IS_MODULO" + index + (curve.boundary == Boundary::repeat ? "1" : "0") + "\nM17\n";
  return {axis + "_EEC.INI", text};
}

CecFile::CecFile(const CompensationTask& task, Emission emission) : task_(task), emission_(emission) {
  sign_ = task.profile.answer("cec_sign") == "add" ? 1 : -1;
  adds_plain_ = task.profile.answer("cec_product") == "beside the table's own value";
  factor_alone_ = task.profile.answer("cec_factor") == "works while switched off";
}

std::size_t CecFile::cost(const Term& term) const {
  if (!term.factor) return 1;
  const bool shared = term.ramp && ramps_.contains(term.factor->input);
  return 1 + (shared ? 0 : (factor_alone_ ? 1 : 2));
}

void CecFile::add(const Term& term) {
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

std::size_t CecFile::write(char output, const Curve& curve, std::size_t multiply_by, int direction, int decimals,
                           bool switched_on) {
  const std::string t = std::to_string(count_);
  for (std::size_t k = 0; k < curve.values.size(); ++k)
    text_ += "$AN_CEC[" + t + "," + std::to_string(k) + "]=" + value_text(curve.values[k], decimals, emission_) + "\n";
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

TableFile CecFile::file() const { return {kCecFile, header(task_, "NC_CEC_INI") + text_ + "M17\n"}; }

}  // namespace trunnion::sinumerik
