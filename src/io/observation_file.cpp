#include "io/observation_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "error.h"
#include "io/csv.h"
#include "io/text_file.h"
#include "units/nearest_name.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);
constexpr double kUnitTolerance = 1e-3;

/// Where the known columns stand in the file.
struct Columns {
  std::size_t kind = kAbsent, a = kAbsent, c = kAbsent, point = kAbsent, artifact = kAbsent, value_um = kAbsent,
              value_urad = kAbsent, repeat = kAbsent, time = kAbsent, a_dir = kAbsent, c_dir = kAbsent,
              temperature = kAbsent, sigma = kAbsent;
  std::array<std::size_t, 3> position{kAbsent, kAbsent, kAbsent}, normal{kAbsent, kAbsent, kAbsent},
      axis{kAbsent, kAbsent, kAbsent};
  std::array<std::size_t, 4> quaternion{kAbsent, kAbsent, kAbsent, kAbsent};
  std::vector<std::size_t> extra;
};

/// Labels as small numbers.
class Labels {
 public:
  std::uint32_t of(std::string_view label, std::vector<std::string>& names) {
    if (!names.empty() && names[last_] == label) return last_;
    const auto found = known_.find(std::string(label));
    if (found != known_.end()) return last_ = found->second;
    names.emplace_back(label);
    return last_ = known_[names.back()] = static_cast<std::uint32_t>(names.size() - 1);
  }

 private:
  std::unordered_map<std::string, std::uint32_t> known_;
  std::uint32_t last_ = 0;
};

class Parser {
 public:
  Parser(std::string_view text, const std::string& name, const Machine& machine)
      : csv_(text, name), tilt_(1, machine.tilt_letter()) {
    set_.files = {name};
    find_columns();
    set_.rows.reserve(std::min<std::size_t>(text.size() / 60, std::size_t{1} << 20));  // a hostile file has size alone
  }

  ObservationSet parse(const ReadingProgress& progress) {
    std::vector<std::string_view> fields;
    while (csv_.next(fields)) {
      add(fields);
      if (progress && set_.rows.size() % kLinesBetweenProgress == 0) progress(csv_.line());
    }
    if (set_.rows.empty()) throw InputError(csv_.name(), "no rows after the header");
    return std::move(set_);
  }

 private:
  void find_columns() {
    const std::array<std::pair<std::string, std::size_t*>, 13> plain = {{{"kind", &at_.kind},
                                                                         {tilt_ + "_deg", &at_.a},
                                                                         {"C_deg", &at_.c},
                                                                         {"point", &at_.point},
                                                                         {"artifact", &at_.artifact},
                                                                         {"value_um", &at_.value_um},
                                                                         {"value_urad", &at_.value_urad},
                                                                         {"repeat", &at_.repeat},
                                                                         {"time_s", &at_.time},
                                                                         {tilt_ + "_dir", &at_.a_dir},
                                                                         {"C_dir", &at_.c_dir},
                                                                         {"temperature_C", &at_.temperature},
                                                                         {"sigma_um", &at_.sigma}}};
    const std::array<std::pair<const char*, std::size_t*>, 13> parts = {{{"x_mm", &at_.position[0]},
                                                                         {"y_mm", &at_.position[1]},
                                                                         {"z_mm", &at_.position[2]},
                                                                         {"nx", &at_.normal[0]},
                                                                         {"ny", &at_.normal[1]},
                                                                         {"nz", &at_.normal[2]},
                                                                         {"mx", &at_.axis[0]},
                                                                         {"my", &at_.axis[1]},
                                                                         {"mz", &at_.axis[2]},
                                                                         {"qw", &at_.quaternion[0]},
                                                                         {"qx", &at_.quaternion[1]},
                                                                         {"qy", &at_.quaternion[2]},
                                                                         {"qz", &at_.quaternion[3]}}};
    std::vector<std::string> known;
    for (const auto& [name, slot] : plain) known.push_back(name);
    for (const auto& [name, slot] : parts) known.emplace_back(name);
    const std::string other = tilt_ == "A" ? "B" : "A";
    for (std::size_t k = 0; k < csv_.header().size(); ++k) {
      const std::string& column = csv_.header()[k];
      bool found = false;
      for (const auto& [name, slot] : plain)
        if (name == column) *slot = k, found = true;
      for (const auto& [name, slot] : parts)
        if (name == column) *slot = k, found = true;
      if (found) continue;
      if (column == other + "_deg" || column == other + "_dir")
        throw InputError(csv_.name(), csv_.line(),
                         "header: column " + column + " found, but this machine tilts by " + tilt_);
      at_.extra.push_back(k);
      set_.extra_columns.push_back(column);
    }
    for (const auto& [slot, name] : {std::pair{at_.a, tilt_ + "_deg"}, std::pair{at_.c, std::string("C_deg")}})
      if (slot == kAbsent)
        throw InputError(csv_.name(), csv_.line(),
                         "header: column " + name + " is missing; the nearest there is \"" +
                             nearest_name(name, csv_.header()) + "\"");
    set_.has_time = at_.time != kAbsent;
    set_.has_temperature = at_.temperature != kAbsent;
    set_.has_tilt_sense = at_.a_dir != kAbsent;
    set_.has_turn_sense = at_.c_dir != kAbsent;
    set_.has_repeat = at_.repeat != kAbsent;
    set_.has_sigma = at_.sigma != kAbsent;
  }

  [[noreturn]] void fail(const std::string& text) const { throw InputError(csv_.name(), csv_.line(), text); }

  double number(const std::vector<std::string_view>& fields, std::size_t column, const char* name) const {
    if (column == kAbsent) fail(std::string("column ") + name + " is missing, this row needs it");
    return csv_.number(fields[column], column);
  }
  template <std::size_t N>
  std::array<double, N> numbers(const std::vector<std::string_view>& fields, const std::array<std::size_t, N>& columns,
                                const std::array<const char*, N>& names) const {
    std::array<double, N> values{};
    for (std::size_t k = 0; k < N; ++k) values[k] = number(fields, columns[k], names[k]);
    return values;
  }
  /// An optional number: the column may be missing or the field blank.
  double optional_number(const std::vector<std::string_view>& fields, std::size_t column, double otherwise) const {
    if (column == kAbsent || fields[column].empty()) return otherwise;
    return csv_.number(fields[column], column);
  }

  Eigen::Vector3d unit(const std::vector<std::string_view>& fields, const std::array<std::size_t, 3>& columns,
                       const std::array<const char*, 3>& names) const {
    const auto v = numbers(fields, columns, names);
    const Eigen::Vector3d vector(v[0], v[1], v[2]);
    const double length = vector.norm();
    if (!(std::abs(length - 1) <= kUnitTolerance)) {
      fail(printed("%s,%s,%s: length %.4g, a unit vector is wanted", names[0], names[1], names[2], length));
    }
    return vector / length;
  }

  int sense(const std::vector<std::string_view>& fields, std::size_t column) const {
    if (column == kAbsent || fields[column].empty()) return 1;
    const double value = csv_.number(fields[column], column);
    if (value != 1 && value != -1)
      fail(csv_.header()[column] + ": " + std::string(fields[column]) + " found, +1 or -1 is wanted");
    return static_cast<int>(value);
  }

  ReadingKind kind_of(std::string_view text) const {
    if (text == "contact") return ReadingKind::contact;
    if (text == "displacement") return ReadingKind::displacement;
    if (text == "rotation") return ReadingKind::rotation;
    if (text == "pose") return ReadingKind::pose;
    fail("kind: " + (text.empty() ? std::string("nothing") : "\"" + std::string(text.substr(0, 40)) + "\"") +
         " found, one of contact, displacement, rotation, pose is wanted");
  }

  void add(const std::vector<std::string_view>& fields) {
    constexpr double kLargest_mm = 1e5, kLargest_deg = 1e6;
    Observation row;
    row.line = static_cast<std::uint32_t>(csv_.line());
    if (at_.kind != kAbsent) row.kind = kind_of(fields[at_.kind]);
    const double a = csv_.number(fields[at_.a], at_.a), c = csv_.number(fields[at_.c], at_.c);
    if (std::abs(a) > 360)
      fail(tilt_ + "_deg: " + std::string(fields[at_.a]) + " found, a tilt within 360 deg is wanted");
    if (std::abs(c) > kLargest_deg)
      fail("C_deg: " + std::string(fields[at_.c]) + " found, an angle within a million degrees is wanted");
    row.at = {Angle::degrees(a), Angle::degrees(c)};
    if (at_.point != kAbsent) row.point = points_.of(fields[at_.point], set_.points);
    if (at_.artifact != kAbsent) row.artifact = artifacts_.of(fields[at_.artifact], set_.artifacts);
    if (row.kind != ReadingKind::rotation) {
      const auto p = numbers(fields, at_.position, {"x_mm", "y_mm", "z_mm"});
      for (std::size_t k = 0; k < 3; ++k)
        if (std::abs(p[k]) > kLargest_mm)
          fail(csv_.header()[at_.position[k]] + ": " + std::string(fields[at_.position[k]]) +
               " found, a place within 100 m is wanted");
      row.position_mm = {p[0], p[1], p[2]};
    }
    switch (row.kind) {
      case ReadingKind::contact:
        if (at_.point == kAbsent || fields[at_.point].empty())
          fail("point: nothing found, the label of the probed spot is wanted");
        row.direction = unit(fields, at_.normal, {"nx", "ny", "nz"});
        for (const std::size_t value : {at_.value_um, at_.value_urad})
          if (optional_number(fields, value, 0) != 0)
            fail(csv_.header()[value] + ": " + std::string(fields[value]) + " found in a contact, which has no value" +
                 (at_.kind == kAbsent ? "; the column kind is missing" : ""));
        break;
      case ReadingKind::displacement:
        row.direction = unit(fields, at_.normal, {"nx", "ny", "nz"});
        row.value = 1e-3 * number(fields, at_.value_um, "value_um");
        break;
      case ReadingKind::rotation:
        row.direction = unit(fields, at_.axis, {"mx", "my", "mz"});
        row.value = 1e-6 * number(fields, at_.value_urad, "value_urad");
        break;
      case ReadingKind::pose: {
        const auto q = numbers(fields, at_.quaternion, {"qw", "qx", "qy", "qz"});
        const Eigen::Quaterniond orientation(q[0], q[1], q[2], q[3]);
        if (!(std::abs(orientation.norm() - 1) <= kUnitTolerance)) {
          fail(formatted("qw,qx,qy,qz: length %.4g, a unit quaternion is wanted", orientation.norm()));
        }
        row.orientation = orientation.normalized();
        break;
      }
      case ReadingKind::surface:
      case ReadingKind::none:
        break;
    }
    const double repeat = optional_number(fields, at_.repeat, 0);
    if (repeat != std::floor(repeat) || std::abs(repeat) > 1e9)
      fail("repeat: " + std::string(fields[at_.repeat]) + " found, a whole number is wanted");
    row.repeat = static_cast<int>(repeat);
    row.time_s = optional_number(fields, at_.time, 0);
    row.tilt_sense = sense(fields, at_.a_dir);
    row.turn_sense = sense(fields, at_.c_dir);
    row.temperature_C = optional_number(fields, at_.temperature, 20);
    if (at_.sigma != kAbsent && !fields[at_.sigma].empty()) {
      const double sigma = csv_.number(fields[at_.sigma], at_.sigma);
      if (!(sigma > 0)) fail("sigma_um: " + std::string(fields[at_.sigma]) + " found, a number above 0 is wanted");
      // A rotation reading states it in urad, as its value.
      row.sigma = sigma * (row.kind == ReadingKind::rotation ? 1e-6 : 1e-3);
    }
    for (const std::size_t column : at_.extra) set_.extra_values.push_back(csv_.number(fields[column], column));
    set_.rows.push_back(row);
  }

  CsvReader csv_;
  std::string tilt_;
  Columns at_;
  ObservationSet set_;
  Labels points_, artifacts_;
};

}  // namespace

ObservationSet parse_observations(std::string_view text, const std::string& name, const Machine& machine,
                                  const ReadingProgress& progress) {
  return Parser(text, name, machine).parse(progress);
}

ObservationSet read_observations(const std::string& path, const Machine& machine) {
  const std::string text = read_text(path);
  return parse_observations(text, path, machine);
}

std::string observations_text(const ObservationSet& set, char tilt_letter) {
  const std::string tilt(1, tilt_letter);
  std::string text = tilt + "_deg,C_deg,point,artifact,x_mm,y_mm,z_mm,nx,ny,nz";
  if (set.has_repeat) text += ",repeat";
  if (set.has_time) text += ",time_s";
  if (set.has_tilt_sense) text += "," + tilt + "_dir";
  if (set.has_turn_sense) text += ",C_dir";
  text += '\n';
  for (const Observation& o : set.rows) {
    append_number(text, o.at.a.in_degrees());
    text += ',';
    append_number(text, o.at.c.in_degrees());
    text += ',' + set.points[o.point] + ',' + (set.artifacts.empty() ? std::string() : set.artifacts[o.artifact]);
    for (const Eigen::Vector3d* v : {&o.position_mm, &o.direction})
      for (Eigen::Index k = 0; k < 3; ++k) {
        text += ',';
        // A millionth of a mm, and of a direction: what is below is rounding of angles.
        append_number(text, std::round((*v)[k] * 1e9) / 1e9);
      }
    if (set.has_repeat) text += ',' + std::to_string(o.repeat);
    if (set.has_time) {
      text += ',';
      append_number(text, o.time_s);
    }
    if (set.has_tilt_sense) text += ',' + std::to_string(o.tilt_sense);
    if (set.has_turn_sense) text += ',' + std::to_string(o.turn_sense);
    text += '\n';
  }
  return text;
}

}  // namespace trunnion
