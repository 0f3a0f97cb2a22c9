#include "io/machine_file.h"

#include "error.h"
#include "io/text_file.h"
#include "io/toml_reader.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

Range<Angle> degrees(const std::pair<double, double>& r) { return {Angle::degrees(r.first), Angle::degrees(r.second)}; }
Range<Length> millimetres(const std::pair<double, double>& r) {
  return {Length::millimetres(r.first), Length::millimetres(r.second)};
}

constexpr double kFarthest_mm = 1e5;  ///< of an axis from R's origin: no machine is that large

void read_axis(TomlReader table, Axis& axis) {
  if (const auto direction = table.numbers("direction", 3)) {
    const Eigen::Vector3d v((*direction)[0], (*direction)[1], (*direction)[2]);
    if (!(v.norm() > 1e-6)) table.fail("direction", "a vector without length found");
    if (axis.rotary() && std::abs(v.normalized().dot(axis.direction)) < 0.5)
      table.fail("direction", std::string("it is not along ") +
                                  (axis.letter == 'A'   ? "X"
                                   : axis.letter == 'B' ? "Y"
                                                        : "Z") +
                                  " or near it, as axis " + axis.letter + " is");
    if (!axis.rotary() && (v.normalized() - axis.direction).norm() > 1e-9)
      table.fail("direction", std::string("a linear axis ") + axis.letter + " runs along R's " + axis.letter);
    axis.direction = v.normalized();
  }
  if (axis.rotary()) {
    if (const auto origin = table.numbers("origin_mm", 3)) {
      axis.origin_mm = {(*origin)[0], (*origin)[1], (*origin)[2]};
      if (const double far = axis.origin_mm.norm(); far > kFarthest_mm)
        table.fail("origin_mm", formatted("%g mm from R's origin found, 100 m at most is wanted", far));
    }
    if (const auto range = table.range("range_deg")) axis.range_angle = degrees(*range);
    if (const auto modulo = table.truth("modulo")) axis.modulo = *modulo;
  } else if (const auto range = table.range("range_mm")) {
    axis.range_length = millimetres(*range);
  }
  table.finish();
}

/// One text of a few; the first where none is said.
std::string chosen(TomlReader& table, const std::string& key, const std::vector<std::string>& among) {
  const std::string found = table.text(key).value_or(among.front());
  if (std::ranges::find(among, found) != among.end()) return found;
  std::string list;
  for (std::size_t i = 0; i < among.size(); ++i)
    list += (i == 0 ? "" : i + 1 == among.size() ? " or " : ", ") + ("\"" + among[i] + "\"");
  table.fail(key, "\"" + found + "\" found, " + list + " is wanted");
}

void read_profile(TomlReader& table, const std::string& prefix, std::map<std::string, ProfileValue>& profile) {
  for (const std::string& key : table.keys()) {
    const toml::node& node = *table.node(key);
    if (node.is_table()) {
      TomlReader inner = *table.table(key);
      read_profile(inner, prefix + key + ".", profile);
    } else if (node.is_string()) {
      profile[prefix + key] = *table.text(key);
    } else if (node.is_boolean()) {
      profile[prefix + key] = *table.truth(key);
    } else if (node.is_number()) {
      profile[prefix + key] = *table.number(key);
    } else {
      table.fail(key, "a text, a number, true or false is wanted");
    }
  }
}

}  // namespace

Machine parse_machine(std::string_view text, const std::string& name) {
  const toml::table document = TomlReader::parse(text, name);
  TomlReader top(document, name, "");
  top.check_format("trunnion-machine");
  Machine machine;
  machine.name = top.required_text("name");
  machine.serial = top.required_text("serial");
  const std::string code = top.required_text("structure");
  try {
    machine.structure = parse_structure(code);
  } catch (const ModelError& e) {
    top.fail("structure", std::string(e.what()).substr(std::string("structure ").size()));
  }
  machine.axes = default_axes(machine.structure);
  machine.controller = top.text("controller").value_or("");
  static const std::vector<std::string> kControllers = {"linuxcnc",   "sinumerik-840d", "isg-twincat",
                                                        "heidenhain", "fanuc-30i",      "aerotech"};
  if (!machine.controller.empty() && std::ranges::find(kControllers, machine.controller) == kControllers.end()) {
    std::string list;
    for (const std::string& known : kControllers) list += (list.empty() ? "" : ", ") + known;
    top.fail("controller", "\"" + machine.controller + "\" found, one of " + list + " is wanted");
  }
  if (auto axes = top.table("axis")) {
    TomlReader names = *axes;
    for (const std::string& key : names.keys())
      if (key.size() != 1 || !machine.axes.contains(key[0]))
        axes->fail(key, "the structure \"" + code + "\" has no such axis");
    for (auto& [letter, axis] : machine.axes)
      if (auto table = axes->table(std::string(1, letter))) read_axis(*table, axis);
    axes->finish();
  }
  if (auto probe = top.table("probe")) {
    machine.probe.sigma = Length::micrometres(probe->positive("sigma_um", machine.probe.sigma.in_micrometres()));
    machine.probe.ball_radius =
        Length::millimetres(probe->positive("ball_radius_mm", machine.probe.ball_radius.in_millimetres()));
    probe->finish();
  }
  if (auto control = top.table("control")) {
    machine.tcp = chosen(*control, "tcp", {"on", "off"});
    // What its programs mean is the affair of those who read them.
    machine.profile["control.tcp_frame"] = chosen(*control, "tcp_frame", {"zero", "start", "fixed"});
    machine.profile["control.whole_numbers"] = chosen(*control, "whole_numbers", {"ask", "units", "increments"});
    machine.profile["control.turn_path"] = chosen(*control, "turn_path", {"dialect", "shortest", "as written"});
    machine.profile["control.orientation_path"] = chosen(*control, "orientation_path", {"ask", "axes", "great circle"});
    control->finish();
  }
  if (auto limits = top.table("limits")) {
    machine.limits.deviation =
        Length::micrometres(limits->positive("correction_um", machine.limits.deviation.in_micrometres()));
    machine.limits.tilt =
        Angle::microradians(limits->positive("correction_urad", machine.limits.tilt.in_microradians()));
    machine.limits.rotary_word =
        Angle::degrees(limits->positive("correction_C_deg", machine.limits.rotary_word.in_degrees()));
    // What of them only programs meet stands beside the control's facts.
    for (const char* key : {"change_um", "change_deg"})
      if (limits->number(key)) machine.profile[std::string("limits.") + key] = limits->positive(key, 1);
    limits->finish();
  }
  if (auto volume = top.table("work_volume")) {
    if (const auto r = volume->range(std::string(1, machine.tilt_letter()) + "_deg"))
      machine.work_volume.a = degrees(*r);
    if (const auto r = volume->range("C_deg")) machine.work_volume.c = degrees(*r);
    if (const auto r = volume->range("X_mm")) machine.work_volume.x = millimetres(*r);
    if (const auto r = volume->range("Y_mm")) machine.work_volume.y = millimetres(*r);
    if (const auto r = volume->range("Z_mm")) machine.work_volume.z = millimetres(*r);
    volume->finish();
  }
  if (auto profile = top.table("profile")) read_profile(*profile, "", machine.profile);
  top.finish();
  return machine;
}

Machine read_machine(const std::string& path) { return parse_machine(read_text(path, std::size_t{1} << 24), path); }

}  // namespace trunnion
