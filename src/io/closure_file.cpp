#include "io/closure_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/csv.h"

namespace trunnion {

using nlohmann::json;

namespace {

json stage_json(const ClosureStage& stage, bool has_holdout) {
  return {{"rms_um", stage.rms_um},
          {"reduced_chi2", stage.reduced_chi2},
          {"holdout_rms_um", has_holdout ? json(stage.holdout_rms_um) : json()},
          {"holdout_plain_rms_um", has_holdout ? json(stage.holdout_plain_rms_um) : json()}};
}

json parameters_json(const Effect& effect) {
  json parameters = effect.to_json().value("parameters", json::object());
  for (const Parameter& p : effect.shape())
    parameters[p.name] = {{"value", to_unit(p.value, p.unit)}, {"std", nullptr}, {"unit", unit_text(p.unit).text}};
  return parameters;
}

}  // namespace

json closure_json(const ClosureResult& r) {
  json j;
  j["format"] = "trunnion-closure";
  j["version"] = 1;
  j["noise_um"] = r.noise_um;
  j["verdict"] = verdict_text(r.verdict);
  j["before"] = stage_json(r.before, r.has_holdout);
  j["after"] = stage_json(r.after, r.has_holdout);
  j["effects"] = json::array();
  for (const AcceptedEffect& e : r.effects) {
    json entry;
    entry["id"] = e.effect->id();
    entry["origin"] = e.effect->origin() == Origin::machine ? "machine" : "measurement";
    entry["kind"] = e.smooth ? "smooth" : "catalogue";
    entry["depends_on"] = e.effect->depends_on();
    entry["parameters"] = parameters_json(*e.effect);
    entry["p_value"] = e.p_value;
    entry["visible_fraction"] = e.visible_fraction;
    entry["rms_before_um"] = e.rms_before_um;
    entry["rms_after_um"] = e.rms_after_um;
    entry["holdout_before_um"] = e.holdout_before_um;
    entry["holdout_after_um"] = e.holdout_after_um;
    entry["not_separable_from"] = e.not_separable_from;
    entry["partly_separable_from"] = e.partly_separable_from;
    entry["separate_by"] = e.separate_by;
    entry["alternatives"] = json::array();
    for (const Alternative& a : e.alternatives)
      entry["alternatives"].push_back(
          {{"id", a.id}, {"correlation", a.correlation}, {"log_likelihood_behind", a.log_likelihood}});
    entry["compensated"] = e.effect->is_compensated();
    entry["needs"] = e.needs;
    entry["largest_um"] = e.largest_um;
    entry["rigid_within_poses"] = e.rigid_within_poses;
    entry["not_credible"] = e.absurd;
    j["effects"].push_back(std::move(entry));
  }
  j["untestable"] = json::array();
  for (const Untestable& u : r.untestable) j["untestable"].push_back({{"id", u.id}, {"separate_by", u.separate_by}});
  j["refused"] = r.refused;
  j["readings"] = r.problem.readings.size();
  j["thinned"] = r.thinned != nullptr;
  j["columns_scanned"] = r.columns_scanned;
  j["outliers"] = json::array();
  for (const std::size_t i : r.outliers)
    j["outliers"].push_back(r.problem.observations->place(r.problem.readings[i].row));
  return j;
}

std::string residual_csv(const ClosureResult& r, char tilt_letter) {
  const ObservationSet& set = *r.problem.observations;
  std::string text = "file,line,";
  text += tilt_letter;
  text += "_deg,C_deg,point,artifact,order,order_in_pose,repeat,time_s,temperature_C,";
  text += tilt_letter;
  text += "_dir,C_dir,x_mm,y_mm,z_mm,nx,ny,nz";
  for (const std::string& column : set.extra_columns) text += "," + column;
  text += ",residual_before_um,residual_after_um,kept_back,left_out\n";
  for (std::size_t i = 0; i < r.problem.readings.size(); ++i) {
    const Reading& reading = r.problem.readings[i];
    const Situation& s = r.problem.situations[reading.row];
    text += set.files[set.file_of_row.empty() ? 0 : set.file_of_row[reading.row]] + "," +
            std::to_string(set.rows[reading.row].line);
    const auto number = [&](double value) {
      text += ',';
      append_number(text, value);
    };
    number(s.at.a.in_degrees());
    number(s.at.c.in_degrees());
    text.append(",").append(s.point).append(",").append(s.artifact);
    for (const double value :
         {s.order, s.order_in_pose, static_cast<double>(s.repeat), s.time_s, s.temperature_C,
          static_cast<double>(s.tilt_sense), static_cast<double>(s.turn_sense), s.point_r_mm.x(), s.point_r_mm.y(),
          s.point_r_mm.z(), s.approach_r.x(), s.approach_r.y(), s.approach_r.z()})
      number(value);
    for (std::size_t k = 0; k < set.extra_columns.size(); ++k)
      number(set.extra_values[reading.row * set.extra_columns.size() + k]);
    const double unit = reading.angular ? 1e5 : 1e3;  // a rotation as a displacement at 100 mm
    number(unit * r.residual_before[i]);
    number(unit * r.residual_after[i]);
    text += r.holdout[i] ? ",1" : ",0";
    text += std::ranges::find(r.outliers, i) != r.outliers.end() ? ",1\n" : ",0\n";
  }
  return text;
}

}  // namespace trunnion
