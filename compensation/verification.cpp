#include "compensation/verification.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "compensation/limits.h"
#include "compensation/number_text.h"
#include "compensation/set_documents.h"
#include "error.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr std::size_t kVerified = 3000;
constexpr std::size_t kFirstVerified = 100000;  // of Halton's sequence: poses that no projection has used
constexpr std::size_t kTried = 600;             // while a spacing is looked for
constexpr double kSpacingShare = 0.05;

class Nothing : public PlayedCompensation {
 public:
  AxisCorrection at(const Situation&) const override { return {}; }
};

class Ideal : public PlayedCompensation {
 public:
  explicit Ideal(const CompensationTask& task) : task_(task) {}
  AxisCorrection at(const Situation& s) const override {
    return ideal_correction(task_.model, task_.chain, task_.machine.limits, s);
  }

 private:
  const CompensationTask& task_;
};

/// Whether the control takes a set of this spacing.
bool within_limits(const Controller& controller, const CompensationTask& task, Angle spacing) {
  try {
    controller.emit(task, spacing, {});
    return true;
  } catch (const RangeError&) {
    return false;
  }
}

double lost(double with_mm, double without_mm) {
  return std::sqrt(std::max(0.0, with_mm * with_mm - without_mm * without_mm));
}

nlohmann::ordered_json volume_json(const WorkingVolume& v, char tilt) {
  const auto pair = [](double low, double high) { return nlohmann::ordered_json::array({low, high}); };
  const auto degrees = [&](Range<Angle> r) {
    return pair(rounded(r.low.in_degrees(), 9), rounded(r.high.in_degrees(), 9));
  };
  const auto mm = [&](Range<Length> r) { return pair(r.low.in_millimetres(), r.high.in_millimetres()); };
  return {{std::string(1, tilt) + "_deg", degrees(v.a)},
          {"C_deg", degrees(v.c)},
          {"X_mm", mm(v.x)},
          {"Y_mm", mm(v.y)},
          {"Z_mm", mm(v.z)},
          {"tool_length_mm", v.tool_length.in_millimetres()}};
}

std::optional<AtRest> at_rest(const CompensationTask& task, const PlayedCompensation& played) {
  if (!reference_deg(task.volume)) return std::nullopt;
  const WorkingVolume& v = task.volume;
  AtRest most;
  for (const Length x : {v.x.low, v.x.high})
    for (const Length y : {v.y.low, v.y.high})
      for (const Length z : {v.z.low, v.z.high}) {
        Situation s;
        s.point_r_mm = {x.in_millimetres(), y.in_millimetres(), z.in_millimetres()};
        s.tool_length_mm = v.tool_length.in_millimetres();
        const AxisCorrection c = played.at(s);
        most.linear_mm = std::max(most.linear_mm, c.linear_mm.norm());
        most.deviation_mm = std::max(most.deviation_mm, remaining({}, task.chain, s, c).position_mm.norm());
        most.rotary_rad = std::max({most.rotary_rad, std::abs(c.tilt_rad), std::abs(c.turn_rad)});
      }
  return most;
}

}  // namespace

namespace {

/// Tables say for which machine they were made.
void refuse_other_machine(const nlohmann::json& summary, const Machine& machine) {
  const auto made_for = summary.find("machine");
  if (made_for == summary.end() || !made_for->is_object()) return;
  for (const auto& [key, words, wanted] :
       {std::tuple("serial", "serial number", machine.serial), std::tuple("name", "the name", machine.name)}) {
    const std::string found = made_for->value(key, nlohmann::json()).dump();
    if (found != nlohmann::json(wanted).dump())
      throw RefusalError(std::string("verification.json: the tables are of a machine with ") + words + " " + found +
                         ", the machine file says \"" + wanted + "\"");
  }
}

}  // namespace

Spread spread(const Model& model, const KinematicChain& chain, const std::vector<Situation>& sample,
              const PlayedCompensation& played) {
  Spread total;
  for (const Situation& s : sample) {
    const Remaining left = remaining(model, chain, s, played.at(s));
    total.position_rms_mm += left.position_mm.squaredNorm();
    total.position_max_mm = std::max(total.position_max_mm, left.position_mm.norm());
    total.orientation_rms_rad += left.tilt_rad * left.tilt_rad;
  }
  const auto n = static_cast<double>(std::max<std::size_t>(1, sample.size()));
  total.position_rms_mm = std::sqrt(total.position_rms_mm / n);
  total.orientation_rms_rad = std::sqrt(total.orientation_rms_rad / n);
  return total;
}

std::string verification_json(const Verification& v, const Machine& machine) {
  using nlohmann::ordered_json;
  const auto um = [](double mm) { return rounded(mm * 1e3, 6); };
  const auto urad = [](double rad) { return rounded(rad * 1e6, 6); };
  ordered_json j;
  j["controller"] = v.controller;
  j["load_ready"] = v.load_ready();
  j["unconfirmed"] = v.unconfirmed;
  j["machine"] = {{"name", machine.name}, {"serial", machine.serial}};
  j["work_volume"] = volume_json(v.volume, machine.tilt_letter());
  j["poses"] = v.poses;
  j["position_rms_um"] = {{"before", um(v.before.position_rms_mm)},
                          {"ideal", um(v.ideal.position_rms_mm)},
                          {"tables", um(v.tables.position_rms_mm)}};
  j["position_max_um"] = {{"before", um(v.before.position_max_mm)},
                          {"ideal", um(v.ideal.position_max_mm)},
                          {"tables", um(v.tables.position_max_mm)}};
  j["orientation_rms_urad"] = {{"before", urad(v.before.orientation_rms_rad)},
                               {"ideal", urad(v.ideal.orientation_rms_rad)},
                               {"tables", urad(v.tables.orientation_rms_rad)}};
  j["lost_to"] = {{"format", um(v.lost_to_format_mm)},
                  {"spacing", um(v.lost_to_spacing_mm)},
                  {"quantisation", um(v.lost_to_quantisation_mm)}};
  ordered_json terms = ordered_json::array();
  for (const LostTerm& term : v.lost_terms) terms.push_back({{"term", term.term}, {"um", um(term.position_rms_mm)}});
  j["lost_terms"] = std::move(terms);
  j["at_reference"] = nullptr;
  if (v.at_reference)
    j["at_reference"] = {{"linear_um", um(v.at_reference->linear_mm)},
                         {"rotary_urad", urad(v.at_reference->rotary_rad)},
                         {"deviation_um", um(v.at_reference->deviation_mm)}};
  j["spacing_deg"] = rounded(v.spacing.in_degrees(), 9);
  j["worst_pose"] = {{std::string(1, machine.tilt_letter()) + "_deg", rounded(v.worst.at.a.in_degrees(), 6)},
                     {"C_deg", rounded(v.worst.at.c.in_degrees(), 6)},
                     {"x_mm", rounded(v.worst.point_r_mm.x(), 6)},
                     {"y_mm", rounded(v.worst.point_r_mm.y(), 6)},
                     {"z_mm", rounded(v.worst.point_r_mm.z(), 6)}};
  j["files"] = v.files;
  return j.dump(2) + "\n";
}

std::string verification_text(const Verification& v, const Machine& machine) {
  const auto row = [](const char* name, const Spread& s) {
    return printed("%-28s %9.3f um rms %9.3f um max %9.2f urad rms\n", name, s.position_rms_mm * 1e3,
                   s.position_max_mm * 1e3, s.orientation_rms_rad * 1e6);
  };
  std::string terms;
  for (const LostTerm& term : v.lost_terms)
    terms += (terms.empty() ? "what the format does not take, um rms each by itself: " : ", ") + term.term +
             formatted(" %.3f", term.position_rms_mm * 1e3);
  if (!terms.empty()) terms += "\n";
  if (v.at_reference)
    terms += printed(
        "at %c 0 C 0, where it is switched on, X Y Z move by %.3f um, %c and C by %.2f urad, tool against work by %.3f "
        "um\n",
        machine.tilt_letter(), v.at_reference->linear_mm * 1e3, machine.tilt_letter(), v.at_reference->rotary_rad * 1e6,
        v.at_reference->deviation_mm * 1e3);
  return row("nothing compensated", v.before) + row("five axes, ideally", v.ideal) +
         row("these tables, as played", v.tables) +
         printed("lost to the format %.3f um, to the distance of nodes (%.4g deg) %.3f um, to rounding %.3f um\n",
                 v.lost_to_format_mm * 1e3, v.spacing.in_degrees(), v.lost_to_spacing_mm * 1e3,
                 v.lost_to_quantisation_mm * 1e3) +
         terms +
         printed("worst pose: %c %.3f C %.3f deg, x %.1f y %.1f z %.1f mm; %zu poses\n", machine.tilt_letter(),
                 v.worst.at.a.in_degrees(), v.worst.at.c.in_degrees(), v.worst.point_r_mm.x(), v.worst.point_r_mm.y(),
                 v.worst.point_r_mm.z(), v.poses);
}

TableSet make_tables(const Controller& controller, const Machine& machine, const Model& model,
                     const TableOptions& options, const std::function<void(const std::string&)>& progress) {
  const auto tell = [&](const std::string& step) {
    if (progress) progress(step);
  };
  refuse_unknown_keys(controller, machine);
  const CompensationTask task(machine, model, options, controller.questions);
  const auto rms_of = [&](const std::vector<Situation>& sample, Angle spacing, Emission emission) {
    return spread(model, task.chain, sample, *controller.play(controller.emit(task, spacing, emission), task))
        .position_rms_mm;
  };

  // The spacing: tried on fewer poses, coarse to fine, against nodes four times as dense as the finest worth having.
  const std::vector<Situation> few = pose_sample(task.volume, model, kTried, kFirstVerified + kVerified);
  Angle spacing = controller.spacings.back();
  const bool chosen = options.tilt_spacing > Angle() && options.turn_spacing > Angle();
  if (chosen) spacing = std::min(options.tilt_spacing, options.turn_spacing);
  if (!chosen && controller.spacings.size() > 1) {
    tell("nodes as dense as they may be");
    const double dense = rms_of(few, controller.spacings.back(), {1, false});
    std::size_t tried = 0;
    for (const Angle candidate : controller.spacings) {
      tell("spacing " + std::to_string(++tried) + " of at most " + std::to_string(controller.spacings.size()));
      if (candidate != controller.spacings.front() && !within_limits(controller, task, candidate)) break;
      spacing = candidate;
      if (lost(rms_of(few, candidate, {1, false}), dense) <=
          std::max(controller.spacing_loss.in_millimetres(), kSpacingShare * dense))
        break;
    }
  }

  tell("tables written and played");
  std::vector<TableFile> files = controller.emit(task, spacing, {});
  const auto played = controller.play(files, task);
  const std::vector<Situation> sample = pose_sample(task.volume, model, kVerified, kFirstVerified);
  refuse_beyond_limits(controller, task, sample, *played);

  Verification v;
  v.controller = controller.name;
  for (const ProfileItem& item : task.profile.unconfirmed()) v.unconfirmed.push_back(item.key);
  v.volume = task.volume;
  v.poses = sample.size();
  v.spacing = spacing;
  v.at_reference = at_rest(task, *played);
  v.before = spread(model, task.chain, sample, Nothing());
  v.ideal = spread(model, task.chain, sample, Ideal(task));
  v.tables = spread(model, task.chain, sample, *played);
  tell("what is lost to format and spacing");
  const double exact = rms_of(sample, spacing, {1, false});
  const int refined = controller.spacings.size() > 1 ? 4 : 1;
  const auto dense = controller.play(controller.emit(task, spacing, {refined, false}), task);
  v.lost_to_format_mm = std::min(exact, spread(model, task.chain, sample, *dense).position_rms_mm);
  v.lost_terms = lost_terms(task, *dense);
  v.lost_to_spacing_mm = lost(exact, v.lost_to_format_mm);
  v.lost_to_quantisation_mm = lost(v.tables.position_rms_mm, exact);
  double worst = -1;
  for (const Situation& s : sample) {
    const double left = remaining(model, task.chain, s, played->at(s)).position_mm.norm();
    if (left > worst) worst = left, v.worst = s;
  }
  if (!(v.tables.position_rms_mm <= v.before.position_rms_mm)) {
    throw RefusalError(v.controller + printed(": the tables would leave %.3f um rms where %.3f um are without them",
                                              v.tables.position_rms_mm * 1e3, v.before.position_rms_mm * 1e3));
  }

  TableSet set;
  std::vector<TableFile> commissioning;
  if (!v.load_ready()) {
    if (controller.commissioning) commissioning = controller.commissioning(task);
    for (TableFile& file : files) file.name = draft_name(file.name);
    for (TableFile& file : commissioning) file.name = "commissioning/" + draft_name(file.name);
  }
  for (const TableFile& file : files) v.files.push_back(file.name);
  const SetDocuments documents{controller, task, v, files, commissioning};
  set.files = files;
  if (!v.load_ready()) {
    set.files.push_back({"COMMISSIONING.md", commissioning_text(documents)});
    set.files.insert(set.files.end(), commissioning.begin(), commissioning.end());
  }
  set.files.push_back({"LOADING.md", loading_text(documents)});
  set.files.push_back({"verification.txt", verification_text(v, machine)});
  set.files.push_back({"verification.json", verification_json(v, machine)});
  set.verification = std::move(v);
  return set;
}

std::unique_ptr<PlayedCompensation> play_tables(const std::vector<TableFile>& files, const Machine& machine,
                                                const Model& model) {
  const auto summary = std::ranges::find(files, "verification.json", &TableFile::name);
  if (summary == files.end())
    throw InputError("verification.json", "missing: the folder of a `tables` command is wanted");
  const auto json = nlohmann::json::parse(summary->text, nullptr, false);
  if (json.is_discarded() || !json.is_object() || !json.contains("controller") || !json["controller"].is_string())
    throw InputError("verification.json", "controller: missing, the name of a controller is wanted");
  const Controller& controller = controller_named(json["controller"].get<std::string>());
  refuse_other_machine(json, machine);
  TableOptions options;
  if (const auto volume = json.find("work_volume");
      volume != json.end() && volume->contains("tool_length_mm") && (*volume)["tool_length_mm"].is_number())
    options.tool_length = Length::millimetres((*volume)["tool_length_mm"].get<double>());
  // Kept for as long as the played tables: they may ask the machine's chain and profile.
  struct Kept : PlayedCompensation {
    CompensationTask task;
    std::unique_ptr<PlayedCompensation> played;
    explicit Kept(CompensationTask t) : task(std::move(t)) {}
    AxisCorrection at(const Situation& s) const override { return played->at(s); }
  };
  auto kept = std::make_unique<Kept>(CompensationTask(machine, model, options, controller.questions));
  std::vector<TableFile> tables;
  for (const TableFile& file : files)
    if (!file.name.starts_with("commissioning/")) tables.push_back({final_name(file.name), file.text});
  kept->played = controller.play(tables, kept->task);
  return kept;
}

}  // namespace trunnion
