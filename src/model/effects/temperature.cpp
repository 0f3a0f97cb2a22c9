#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

constexpr const char* kDefaultColumn = "temperature_C";

enum class Response { translation, rotation, expansion };

/// The machine follows a temperature, theta = T - 20 C, in one of three ways:
///   translation  D = g theta,       rotation  angles g theta about R's origin,
///   expansion    d_x = -alpha theta x (Y and Z alike): scales and screws that grow.
/// The id is temperature[:COLUMN][:rotation|expansion], the column temperature_C where it is not named.
Formula temperature(const std::string& detail) {
  std::string column = detail;
  Response response = Response::translation;
  const auto ending = [&column](std::string_view word) {
    if (column == word) return column.clear(), true;
    if (!column.ends_with(":" + std::string(word))) return false;
    column.resize(column.size() - word.size() - 1);
    return true;
  };
  if (ending("rotation"))
    response = Response::rotation;
  else if (ending("expansion"))
    response = Response::expansion;
  if (column.empty()) column = kDefaultColumn;

  Formula formula{.id = detail.empty() ? "temperature" : "temperature:" + detail, .depends_on = {column}};
  switch (response) {
    case Response::translation:
      for (const char* name : {"X", "Y", "Z"})
        formula.parameters.push_back({name, Unit::um_per_K, 0, from_unit(100, Unit::um_per_K)});
      formula.moves_table = true;
      formula.basis = [column](const Situation& s, const Eigen::VectorXd&) {
        return translations(beyond_zero(s, column));
      };
      break;
    case Response::rotation:
      for (const char* name : {"A", "B", "C"})
        formula.parameters.push_back({name, Unit::urad_per_K, 0, from_unit(200, Unit::urad_per_K)});
      formula.moves_table = true;
      formula.basis = [column](const Situation& s, const Eigen::VectorXd&) {
        return rotations(beyond_zero(s, column));
      };
      break;
    case Response::expansion:
      for (const char* name : {"EXX", "EYY", "EZZ"})
        formula.parameters.push_back({name, Unit::um_per_m_per_K, 0, from_unit(60, Unit::um_per_m_per_K)});
      formula.depends_on.insert(formula.depends_on.end(), {"x_mm", "y_mm", "z_mm"});
      formula.basis = [column](const Situation& s, const Eigen::VectorXd&) {
        Matrix6Xd b = Matrix6Xd::Zero(6, 3);
        b.topRows<3>().diagonal() = -beyond_zero(s, column) * s.point_r_mm;
        return b;
      };
      break;
  }
  return formula;
}

}  // namespace

Family temperature_family() {
  return {
      .name = "temperature",
      .what = "the machine moves or grows with a measured temperature",
      .remedy = "the same poses at two temperatures, with temperature_C or another column ending in _C recorded",
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            for (const std::string& column : temperature_columns(scope)) {
              const std::string name = column == kDefaultColumn ? "" : column;
              found.push_back(make_effect(temperature(name)));
              for (const char* response : {"rotation", "expansion"})
                found.push_back(make_effect(temperature(name.empty() ? response : name + ":" + response)));
            }
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(temperature(detail), json);
      },
  };
}

}  // namespace trunnion
