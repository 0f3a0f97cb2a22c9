#include "model/effects/smooth.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "error.h"
#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/joint_motion.h"

namespace trunnion {
namespace {

using nlohmann::json;
using std::numbers::pi;

constexpr int kMostFunctions = 200;   // on one axis
constexpr double kNegligible = 1e-7;  // of the largest prior variance
constexpr double kLever_mm = 100;     // at which a rotation counts like a length
constexpr const char* kDirections[] = {"x",       "y",        "z",          "table_x",    "table_y",
                                       "table_z", "approach", "about_tilt", "about_turn", "approach_z"};
static_assert(std::size(kDirections) == std::size(kSmoothDirections));

bool turns(SmoothDirection d) { return d == SmoothDirection::about_tilt || d == SmoothDirection::about_turn; }

/// "time_s~1200" is time_s in a period of 1200.
struct Phase {
  std::string column;
  double period = 0;  ///< 0: the column itself
};
Phase phase_of(const std::string& column) {
  const std::size_t mark = column.find('~');
  if (mark == std::string::npos) return {column, column == "C_deg" || column == "phi_deg" ? 360.0 : 0.0};
  double period = 0;
  const char* last = column.data() + column.size();
  if (std::from_chars(column.data() + mark + 1, last, period).ptr != last || !(period > 0) || !std::isfinite(period))
    throw ModelError("effect smooth:" + column + ": a positive period is wanted after ~");
  return {column.substr(0, mark), period};
}

/// The box on which the eigenfunctions live: its walls stand two length scales beyond the range, where the reflected
/// kernel has fallen to exp(-8); its shortest wave has omega l = 3.6, where the spectrum has fallen to exp(-6.5).
struct Box {
  double centre;
  double half_width;
  int functions;
};
Box box_of(const SmoothAxis& axis) {
  const double half_width = (axis.high - axis.low) / 2 + 2 * axis.length_scale;
  const int functions = static_cast<int>(std::ceil(2.3 * half_width / axis.length_scale)) + 1;
  return {(axis.low + axis.high) / 2, half_width, std::min(functions, kMostFunctions)};
}

/// Spectral density of exp(-r^2 / (2 l^2)).
double spectral_density(double l, double omega) { return std::sqrt(2 * pi) * l * std::exp(-l * l * omega * omega / 2); }

/// On a circle the constant is no effect for one covariate, but a product needs it.
enum class Constant { left_out, kept };

/// Prior variances of the factors on one axis.
std::vector<double> axis_variances(const SmoothAxis& axis, Constant constant) {
  std::vector<double> variances;
  if (const double period = phase_of(axis.column).period; period > 0) {
    // Fourier coefficients of the kernel wrapped round the circle; cos and sin of each harmonic, without the constant.
    if (constant == Constant::kept) variances.push_back(spectral_density(axis.length_scale, 0) / period);
    for (int k = 1; k <= kMostFunctions / 2; ++k) {
      const double v = 2 * spectral_density(axis.length_scale, 2 * pi * k / period) / period;
      if (k > 2 && v < kNegligible * variances.front()) break;
      variances.insert(variances.end(), 2, v);
    }
    return variances;
  }
  const Box box = box_of(axis);
  for (int j = 1; j <= box.functions; ++j)
    variances.push_back(spectral_density(axis.length_scale, pi * j / (2 * box.half_width)));
  return variances;
}

Eigen::VectorXd axis_functions(const SmoothAxis& axis, double value, std::size_t count, Constant constant) {
  Eigen::VectorXd phi(static_cast<Eigen::Index>(count));
  if (const double period = phase_of(axis.column).period; period > 0) {
    const Eigen::Index first = constant == Constant::kept ? 1 : 0;
    if (first == 1) phi[0] = 1;
    for (Eigen::Index k = first; k < phi.size(); ++k) {
      const double angle = 2 * pi * static_cast<double>((k - first) / 2 + 1) * value / period;
      phi[k] = (k - first) % 2 == 0 ? std::cos(angle) : std::sin(angle);
    }
    return phi;
  }
  const Box box = box_of(axis);
  const double u = std::clamp(value, axis.low, axis.high) - box.centre + box.half_width;
  for (Eigen::Index j = 0; j < phi.size(); ++j)
    phi[j] = std::sin(pi * static_cast<double>(j + 1) * u / (2 * box.half_width)) / std::sqrt(box.half_width);
  return phi;
}

double number_at(const json& j, const char* key, const std::string& where) {
  if (!j.contains(key) || !j[key].is_number()) throw ModelError(where + "." + key + ": a number is wanted");
  return j[key].get<double>();
}

}  // namespace

std::optional<double> smooth_covariate(const std::string& column, const Situation& s, const KinematicChain& chain) {
  const std::string name = phase_of(column).column;
  if (name == "xw_mm" || name == "yw_mm" || name == "zw_mm")
    return (chain.r_from_w(s.at).inverse() * s.point_r_mm)[name[0] - 'x'];
  if (name == "phi_deg") return std::atan2(s.approach_r.y(), s.approach_r.x()) * 180 / pi;
  return s.covariate(name);
}

SmoothTerm::SmoothTerm(std::vector<SmoothAxis> axes, SmoothDirection direction, const EffectContext& context)
    : axes_(std::move(axes)), direction_(direction), context_(context) {
  if (axes_.empty() || axes_.size() > 2) throw ModelError("effect smooth: one or two columns are wanted");
  std::vector<std::vector<double>> variances;
  for (const SmoothAxis& axis : axes_) {
    const bool range = phase_of(axis.column).period > 0 || axis.high > axis.low;
    if (!range || !std::isfinite(axis.low) || !std::isfinite(axis.high) || !(axis.length_scale > 0) ||
        !std::isfinite(axis.length_scale))
      throw ModelError("effect smooth:" + axis.column + ": a range low < high and a positive length scale are wanted");
    variances.push_back(axis_variances(axis, axes_.size() == 2 ? Constant::kept : Constant::left_out));
  }
  double largest = 0;
  std::vector<double> priors;
  const auto keep = [&](std::vector<int> term, double variance) {
    terms_.push_back(std::move(term));
    priors.push_back(variance);
    largest = std::max(largest, variance);
  };
  for (std::size_t i = 0; i < variances[0].size(); ++i) {
    if (axes_.size() == 1) {
      keep({static_cast<int>(i)}, variances[0][i]);
      continue;
    }
    for (std::size_t j = 0; j < variances[1].size(); ++j)
      keep({static_cast<int>(i), static_cast<int>(j)}, variances[0][i] * variances[1][j]);
  }
  std::vector<std::vector<int>> terms;
  std::vector<double> kept;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (priors[k] < kNegligible * largest) continue;
    terms.push_back(terms_[k]);
    kept.push_back(priors[k]);
  }
  terms_ = std::move(terms);
  prior_variances_ = Eigen::Map<Eigen::VectorXd>(kept.data(), static_cast<Eigen::Index>(kept.size()));
  if (turns(direction_)) prior_variances_ /= kLever_mm * kLever_mm;
  for (std::size_t k = 0; k < terms_.size(); ++k)
    parameters_.push_back({"f" + std::to_string(k + 1), turns(direction_) ? Unit::urad : Unit::um});
  std::vector<double> zero;
  for (const SmoothAxis& axis : axes_) zero.push_back(zero_of_column(phase_of(axis.column).column));
  at_zero_ = raw_functions(zero);
}

std::string SmoothTerm::id() const {
  std::string id = "smooth:" + axes_[0].column;
  if (axes_.size() == 2) id += "," + axes_[1].column;
  return id;
}

std::vector<std::string> SmoothTerm::depends_on() const {
  std::vector<std::string> columns;
  const auto add = [&columns](const std::string& column) {
    if (std::ranges::find(columns, column) == columns.end()) columns.push_back(column);
  };
  const std::string tilt = std::string(1, context_.tilt_letter) + "_deg";
  for (const SmoothAxis& axis : axes_) {
    const std::string column = phase_of(axis.column).column;
    if (column == "xw_mm" || column == "yw_mm" || column == "zw_mm") {
      for (const char* part : {"x_mm", "y_mm", "z_mm"}) add(part);
      add(tilt), add("C_deg");
    } else if (column == "phi_deg") {
      add("nx"), add("ny");
    } else {
      add(column);
    }
  }
  if (direction_ == SmoothDirection::approach)
    for (const char* part : {"nx", "ny", "nz"}) add(part);
  else if (direction_ == SmoothDirection::approach_z)
    add("nz");
  else if (direction_ >= SmoothDirection::table_x && !turns(direction_))
    add(tilt), add("C_deg");
  return columns;
}

Origin SmoothTerm::origin() const {
  for (const std::string& column : depends_on())
    for (const char* of_measurement : {"nx", "ny", "nz", "point", "artifact", "repeat", "order", "order_in_pose"})
      if (column == of_measurement) return Origin::measurement;
  return Origin::machine;
}

Eigen::VectorXd SmoothTerm::raw_functions(const std::vector<double>& covariates) const {
  std::vector<Eigen::VectorXd> factors;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    int count = 0;
    for (const std::vector<int>& term : terms_) count = std::max(count, term[i] + 1);
    factors.push_back(axis_functions(axes_[i], covariates[i], static_cast<std::size_t>(count),
                                     axes_.size() == 2 ? Constant::kept : Constant::left_out));
  }
  Eigen::VectorXd phi(static_cast<Eigen::Index>(terms_.size()));
  for (Eigen::Index k = 0; k < phi.size(); ++k) {
    const std::vector<int>& term = terms_[static_cast<std::size_t>(k)];
    phi[k] = factors[0][term[0]] * (term.size() == 2 ? factors[1][term[1]] : 1);
  }
  return phi;
}

Eigen::VectorXd SmoothTerm::functions(const Situation& s) const {
  std::vector<double> covariates;
  for (const SmoothAxis& axis : axes_) {
    const std::optional<double> value = smooth_covariate(axis.column, s, *context_.chain);
    if (!value) return Eigen::VectorXd::Zero(at_zero_.size());
    covariates.push_back(*value);
  }
  return raw_functions(covariates) - at_zero_;
}

Vector6d SmoothTerm::direction_r(const Situation& s) const {
  if (direction_ == SmoothDirection::about_tilt)
    return joint_rotation(*context_.chain, context_.chain->tilt_index(), s);
  if (direction_ == SmoothDirection::about_turn)
    return joint_rotation(*context_.chain, context_.chain->turn_index(), s);
  Vector6d c = Vector6d::Zero();
  const int k = static_cast<int>(direction_);
  if (direction_ == SmoothDirection::approach)
    c.head<3>() = s.approach_r;
  else if (direction_ == SmoothDirection::approach_z)
    c[2] = s.approach_r.z();
  else if (k < 3)
    c[k] = 1;
  else
    c.head<3>() = context_.chain->r_from_w(s.at).linear().col(k - 3);
  return c;
}

Matrix6Xd SmoothTerm::basis(const Situation& s) const {
  Matrix6Xd b = Matrix6Xd::Zero(6, at_zero_.size());
  if (origin() == Origin::measurement && s.reading == ReadingKind::none) return b;
  b = direction_r(s) * functions(s).transpose();
  return b;
}

json SmoothTerm::to_json() const {
  json j = Effect::to_json();
  j["direction"] = kDirections[static_cast<std::size_t>(direction_)];
  j["axes"] = json::array();
  for (const SmoothAxis& axis : axes_)
    j["axes"].push_back(
        {{"column", axis.column}, {"low", axis.low}, {"high", axis.high}, {"length_scale", axis.length_scale}});
  return j;
}

std::shared_ptr<SmoothTerm> SmoothTerm::read(const std::string& detail, const json& j, const EffectContext& context) {
  const std::string where = "effect smooth:" + detail;
  const std::string given =
      j.contains("direction") && j["direction"].is_string() ? j["direction"].get<std::string>() : "";
  const auto* const found = std::ranges::find(kDirections, given);
  if (found == std::end(kDirections))
    throw ModelError(where +
                     ": direction: one of x, y, z, table_x, table_y, table_z, approach, about_tilt, about_turn, "
                     "approach_z is wanted");
  if (!j.contains("axes") || !j["axes"].is_array()) throw ModelError(where + ": axes: a list is wanted");
  std::vector<SmoothAxis> axes;
  for (const json& entry : j["axes"]) {
    if (!entry.is_object() || !entry.contains("column") || !entry["column"].is_string())
      throw ModelError(where + ": axes.column: a text is wanted");
    axes.push_back({entry["column"].get<std::string>(), number_at(entry, "low", where + ": axes"),
                    number_at(entry, "high", where + ": axes"), number_at(entry, "length_scale", where + ": axes")});
  }
  auto term = std::make_shared<SmoothTerm>(std::move(axes),
                                           static_cast<SmoothDirection>(found - std::begin(kDirections)), context);
  if (term->id() != "smooth:" + detail) throw ModelError(where + ": its axes are those of " + term->id());
  term->read_parameters(j);
  return term;
}

std::shared_ptr<const SmoothTerm> make_smooth(std::vector<SmoothAxis> axes, SmoothDirection direction,
                                              const EffectContext& context) {
  return std::make_shared<SmoothTerm>(std::move(axes), direction, context);
}

Family smooth_family() {
  return {
      .name = "smooth",
      .what = "a smooth function of one or two quantities, where no family explains the residual",
      .remedy = "more readings spread over the quantities it depends on",
      .absurd = 0,
      .candidates = [](const CandidateScope&) { return std::vector<EffectPtr>(); },  // built by the search itself
      .read = [](const std::string& detail, const json& j, const EffectContext& context) -> EffectPtr {
        return SmoothTerm::read(detail, j, context);
      },
  };
}

}  // namespace trunnion
