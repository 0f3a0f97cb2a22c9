#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "postproc/plain_player.h"

namespace trunnion {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The words of a line by name; G and M codes and calls apart.
struct PlainWords {
  struct Word {
    double value = 0;
    bool point = false;
    char counts = 0;  // A for AC(), I for IC(), D for DC()
  };
  std::map<std::string, Word> word;
  std::vector<double> g, m;
  std::map<std::string, std::string> call;

  bool holds(const std::string& name) const { return word.contains(name); }
  double of(const std::string& name) const { return word.contains(name) ? word.at(name).value : 0; }
};

class WordReader {
 public:
  WordReader(const std::string& line, bool names) : names_(names) {
    bool comment = false;
    for (const char c : line) {
      if (c == ';' && !comment) break;
      if (c == '(' && !names) comment = true;
      const bool blank = static_cast<unsigned char>(c) <= ' ' || c == '\x7f';
      if (!comment && (names || !blank)) text_ += blank ? ' ' : c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
      if (c == ')') comment = false;
    }
  }

  PlainWords words() {
    PlainWords words;
    if (text_.empty() || text_[0] == '%' || text_[0] == '#' || text_[0] == '/' || text_[0] == '<') return words;
    while (at_ < text_.size()) {
      if (!letter(text_[at_])) {
        ++at_;
        continue;
      }
      std::string name;
      while (at_ < text_.size() && letter(text_[at_]) && (names_ || name.empty())) name += text_[at_++];
      if (names_ && name.size() == 1) {
        std::size_t digits = at_;
        while (digits < text_.size() && digit(text_[digits])) ++digits;
        if (digits > at_ && digits < text_.size() && text_[digits] == '=') {
          name += text_.substr(at_, digits - at_);
          at_ = digits;
        }
      }
      if (names_ && name.size() > 1)
        while (at_ < text_.size() && (letter(text_[at_]) || digit(text_[at_]))) name += text_[at_++];
      if (names_) blanks();
      PlainWords::Word word;
      if (at_ < text_.size() && text_[at_] == '=') {
        ++at_;
        blanks();
        std::string wrap;
        while (at_ < text_.size() && letter(text_[at_])) wrap += text_[at_++];
        if (!wrap.empty()) word.counts = wrap[0];
        while (at_ < text_.size() && (text_[at_] == '(' || text_[at_] == ' ')) ++at_;
        if (number(word)) words.word[name] = word;
      } else if (name.size() > 1) {
        std::string inside;
        if (at_ < text_.size() && text_[at_] == '(') {
          const std::size_t close = text_.find(')', at_);
          inside = text_.substr(at_ + 1, close - at_ - 1);
          at_ = close == std::string::npos ? text_.size() : close;
        }
        words.call[name] = inside;
      } else if (number(word)) {
        if (name == "G") words.g.push_back(word.value);
        if (name == "M") words.m.push_back(word.value);
        words.word[name] = word;
      }
    }
    return words;
  }

 private:
  static bool letter(char c) { return (c >= 'A' && c <= 'Z') || c == '_'; }
  static bool digit(char c) { return c >= '0' && c <= '9'; }
  void blanks() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }
  bool number(PlainWords::Word& word) {
    if (at_ < text_.size() && text_[at_] == '+') ++at_;
    const char* const begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), word.value, std::chars_format::fixed);
    if (error != std::errc()) return false;
    word.point = std::string(begin, end).find('.') != std::string::npos;
    at_ += static_cast<std::size_t>(end - begin);
    return true;
  }

  std::string text_;
  std::size_t at_ = 0;
  bool names_;
};

class PlainIsoPlayer : public PlainPlayer {
 public:
  PlainIsoPlayer(const std::string& dialect, const ScanSettings& settings)
      : settings_(settings), fanuc_(dialect == "fanuc"), siemens_(dialect == "sinumerik"), tcp_(settings.tcp) {
    at_.fill(kUnknown);
    motion_ = fanuc_ ? 0 : 1;
    great_circle_ = siemens_ && settings.control.orientation_path == "great circle";
    select("G54");
  }

  std::optional<PlayedMove> play(const std::string& line) override {
    if (line.find('%') == 0 && !siemens_ && ++percents_ == 2) ended_ = true;
    if (ended_) return std::nullopt;
    words_ = WordReader(line, siemens_).words();
    machine_ = home_ = used_ = false;
    set_ = 0;
    const double feed_unit = unit_;
    for (const double g : words_.g) code(g);
    for (const auto& [name, inside] : words_.call) named(name, inside);
    for (const double m : words_.m) {
      if (m == 6 || (m == 61 && !fanuc_ && !siemens_)) at_.fill(kUnknown);
      if (m == 2 || m == 30 || (m == 17 && siemens_)) ended_ = true;
    }
    if (siemens_ && words_.holds("D")) at_[2] = kUnknown;
    if (words_.holds("F") && !used_) feed_ = {words_.of("F"), feed_unit};
    if (used_) return std::nullopt;
    return moved();
  }

  void forget() override { at_.fill(kUnknown); }

 private:
  void code(double g) {
    const int n = code_number(10 * g + 0.5);
    if (n == 0 || n == 10 || n == 20 || n == 30) motion_ = n / 10;
    if (n == 40) used_ = fanuc_ || siemens_;
    if (n == 170) plane_ = {0, 1, 2};
    if (n == 180) plane_ = {2, 0, 1};
    if (n == 190) plane_ = {1, 2, 0};
    if (siemens_ ? n == 700 || n == 7000 : n == 200) unit_ = 25.4;
    if (siemens_ ? n == 710 || n == 7100 : n == 210) unit_ = 1;
    if (n == 930 || n == 940 || n == 950) feed_mode_ = n / 10;
    if (n == 900 || n == 910) incremental_ = n == 910;
    if (n == 530 || n == 1530) machine_ = true;
    if (n == 280 || n == 300 || n == 740 || n == 750) home_ = siemens_ ? n > 700 : n < 700;
    if (n == 54 * 10 || (n > 540 && n < 600)) offset(n);
    if (siemens_ && n >= 5000 && n < 6000) select("G" + std::to_string(n / 10));
    if (fanuc_) fanuc_code(n);
    if (!fanuc_ && !siemens_) linuxcnc_code(n);
    if (siemens_ && (n == 250 || n == 260)) used_ = true;
    if (n == 520 || n == 920 || n == 921 || n == 922 || n == 923) set_ = siemens_ ? 0 : n;
  }

  void linuxcnc_code(int n) {
    if (n == 901 || n == 911) absolute_centre_ = n == 901;
    if (n == 430 || n == 431 || n == 432 || n == 490) at_[2] = kUnknown;
    if (n == 431 || n == 281 || n == 301 || n == 100) used_ = true;
  }

  void fanuc_code(int n) {
    if (n == 434 || n == 435 || n == 430 || n == 440 || n == 490) {
      control_tip(n == 434 || n == 435);
      vectors_ = n == 435;
      at_[2] = kUnknown;
    }
    if (n == 270 || n == 290) home_ = true;
    if (n == 682) {
      const auto turn = [&](const char* word, int about) {
        return Matrix3d(AngleAxisd(angle(scaled(word)), Vector3d::Unit(about)));
      };
      enter_plane(turn("I", 2) * turn("J", 0) * turn("K", 2), unit_ * Vector3d(scaled("X"), scaled("Y"), scaled("Z")));
      used_ = true;
    }
    if (n == 531 || n == 536) across_plane();
    if (n == 690) leave_plane();
  }

  void named(const std::string& name, const std::string& inside) {
    if (name == "TRAORI" || name == "TRAFOOF") control_tip(name == "TRAORI");
    if (name == "ORIVECT" || name == "ORIPLANE" || name == "ORIAXES") great_circle_ = name != "ORIAXES";
    if (name == "CIP") motion_ = 4;
    if (name == "CT") motion_ = 5;
    if (name == "SUPA") machine_ = true;
    if (name == "RET") ended_ = true;
    if (name == "TRANS" || name == "ATRANS" || name == "ROT" || name == "MIRROR" || name == "SCALE") {
      for (std::size_t i = 0; i < kAxes; ++i)
        shift_[i] = (name == "ATRANS" ? shift_[i] : 0) + words_.of(letter(i)) * (i < 3 ? unit_ : 1);
      used_ = true;
    }
    if (name == "CYCLE800") swivel(inside);
  }

  void swivel(const std::string& inside) {
    std::vector<double> value;
    std::string one;
    for (const char c : inside + ",") {
      if (c == ',') {
        double number = 0;
        const char* begin = one.data() + (one.starts_with('+') ? 1 : 0);
        std::from_chars(begin, one.data() + one.size(), number);
        value.push_back(number);
        one.clear();
      } else if (c != ' ') {
        one += c;
      }
    }
    if (inside.find_first_not_of(' ') == std::string::npos) return leave_plane();
    value.resize(20);
    Matrix3d rotation = Matrix3d::Identity();
    const int mode = std::max(0, code_number(value[3]));
    for (int i = 0; i < 3; ++i)
      if (const int about = (mode >> (2 * i)) & 3; about != 0)
        rotation =
            rotation * Matrix3d(AngleAxisd(angle(value[7 + static_cast<std::size_t>(i)]), Vector3d::Unit(about - 1)));
    enter_plane(rotation, unit_ * (Vector3d(value[4], value[5], value[6]) +
                                   rotation * Vector3d(value[10], value[11], value[12])));
    across_plane();
  }

  static double angle(double degrees) { return degrees * std::numbers::pi / 180; }
  std::string letter(std::size_t axis) const { return std::string(1, settings_.letters[axis]); }

  /// A number of a word in program units, whatever a missing point means.
  double scaled(const std::string& name) const {
    const double value = words_.of(name);
    if (!fanuc_ || !words_.holds(name) || words_.word.at(name).point) return value;
    return settings_.control.whole_numbers == "increments" ? value * (unit_ == 1 ? 1e-3 : 1e-4) : value;
  }

  void offset(int n) {
    if (fanuc_ && (n == 540 || n == 541) && words_.holds("P"))
      return select("G54.1P" + std::to_string(code_number(words_.of("P"))));
    select("G" + std::to_string(n / 10) + (n % 10 != 0 ? "." + std::to_string(n % 10) : ""));
  }

  void select(const std::string& system) {
    const auto found = settings_.work_offsets_mm.find(system);
    offset_ = found == settings_.work_offsets_mm.end() ? std::array<double, 3>{} : found->second;
  }

  void control_tip(bool on) {
    if (settings_.tcp_forced || on == tcp_) return;
    tcp_ = on;
    tip_frame_.reset();
    if (on && settings_.control.tcp_frame == "start")
      tip_frame_ = settings_.chain->r_from_w({Angle::degrees(at_[kTilt]), Angle::degrees(at_[kTurn])}).inverse();
    at_[0] = at_[1] = at_[2] = kUnknown;
  }

  void enter_plane(const Matrix3d& rotation, const Vector3d& origin) {
    leave_plane();
    plane_frame_ = Eigen::Isometry3d::Identity();
    plane_frame_->linear() = rotation;
    for (std::size_t i = 0; i < 3; ++i)
      plane_frame_->translation()[static_cast<Eigen::Index>(i)] =
          origin[static_cast<Eigen::Index>(i)] + offset_[i] + shift_[i];
    outside_ = shift_;
    shift_[0] = shift_[1] = shift_[2] = 0;
    at_[0] = at_[1] = at_[2] = kUnknown;
  }

  void across_plane() {
    const Vector3d axis = plane_frame_->linear().col(2);
    const auto [tilt, turn] = descended_to_axis(settings_, axis, at_[kTilt], at_[kTurn]);
    at_[kTilt] = tilt;
    at_[kTurn] = turn;
    if (std::abs(axis.z()) > 1 - 1e-14) at_[kTurn] = kUnknown;
  }

  void leave_plane() {
    if (!plane_frame_) return;
    plane_frame_.reset();
    for (std::size_t i = 0; i < 3; ++i) shift_[i] = outside_[i], at_[i] = kUnknown;
  }

  double zero(std::size_t axis) const { return (axis < 3 && !plane_frame_ ? offset_[axis] : 0) + shift_[axis]; }

  std::optional<PlayedMove> moved() {
    if (set_ == 921) shift_ = kept_ = {};
    if (set_ == 922) kept_ = shift_, shift_ = {};
    if (set_ == 923) shift_ = kept_;
    PlayedMove move;
    move.from = at_;
    bool any = false;
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (!words_.holds(letter(i))) continue;
      any = true;
      take(i, words_.word.at(letter(i)));
    }
    if (home_ && !any) at_.fill(kUnknown);
    if (machine_ || home_ || set_ != 0) return std::nullopt;
    const bool vector = siemens_ ? words_.holds("A3") : vectors_ && words_.holds("I");
    if (vector) {
      Vector3d axis = siemens_ ? Vector3d(words_.of("A3"), words_.of("B3"), words_.of("C3"))
                               : Vector3d(scaled("I"), scaled("J"), scaled("K"));
      if (tip_frame_) axis = tip_frame_->linear() * axis;
      const bool upright = axis.normalized().z() > 1 - 1e-14;
      const auto [tilt, turn] = descended_to_axis(settings_, axis.normalized(), at_[kTilt], at_[kTurn]);
      at_[kTilt] = tilt;
      if (!upright) at_[kTurn] = turn;
    }
    const bool centre = words_.holds("I") || words_.holds("J") || words_.holds("K") || words_.holds("R") ||
                        words_.holds("I1") || words_.holds("J1") || words_.holds("K1");
    if (!any && !vector && !(motion_ >= 2 && centre)) return std::nullopt;
    move.to = at_;
    move.feed = motion_ != 0;
    move.tcp = tcp_ || plane_frame_.has_value();
    move.great_circle = great_circle_ && tcp_ && !plane_frame_;
    if (tcp_ && !plane_frame_ && !settings_.tcp_forced && settings_.control.tcp_frame == "fixed") {
      move.tcp = false;
      move.straight_on_part = true;
    }
    if (const auto& frame = plane_frame_ ? plane_frame_ : tcp_ ? tip_frame_ : none_) {
      move.frame = frame->linear();
      move.frame_origin_mm = frame->translation();
    }
    if (motion_ >= 2) make_arc(move);
    if (move.feed && move.begins_known() && feed_[0] > 0) {
      const double unit = move.way() == 0 || move.to[0] != move.from[0] || move.to[1] != move.from[1] ||
                                  move.to[2] != move.from[2] || move.arc
                              ? feed_[1]
                              : 1;
      if (feed_mode_ == 93) move.seconds = words_.holds("F") ? 60 / feed_[0] : 0;
      if (feed_mode_ == 94) move.seconds = 60 * move.way() / (feed_[0] * unit);
    }
    tangent_ = move.arc ? Vector3d((std::cos(move.sweep_rad) * move.across - std::sin(move.sweep_rad) * move.along) *
                                   (move.sweep_rad < 0 ? -1 : 1))
                        : Vector3d(move.to[0] - move.from[0], move.to[1] - move.from[1], move.to[2] - move.from[2]);
    for (const double place : move.to)
      if (std::isnan(place)) return std::nullopt;
    return move;
  }

  void take(std::size_t i, const PlainWords::Word& word) {
    const double value = scaled(letter(i)) * (i < 3 ? unit_ : 1);
    const bool counts = word.counts == 'I' || (word.counts == 0 && incremental_);
    if (set_ == 520) {
      shift_[i] = value;
    } else if (set_ == 920) {
      shift_[i] = at_[i] - (i < 3 ? offset_[i] : 0) - value;
    } else if (machine_ || home_) {
      at_[i] = kUnknown;
    } else if (counts) {
      at_[i] += value;
    } else {
      double place = value + zero(i);
      const bool shorter = word.counts == 'D' || settings_.control.turn_path == "shortest" ||
                           (fanuc_ && settings_.control.turn_path == "dialect");
      if (i == kTurn && shorter && settings_.modulo_turn && !std::isnan(at_[i]))
        place += 360 * std::round((at_[i] - place) / 360);
      at_[i] = place;
    }
  }

  void make_arc(PlayedMove& move) const {
    move.arc = true;
    const Vector3d begin(move.from[0], move.from[1], move.from[2]), end(move.to[0], move.to[1], move.to[2]);
    Vector3d normal = Vector3d::Unit(static_cast<Eigen::Index>(plane_[2]));
    double sense = motion_ == 2 ? -1 : 1;
    const Vector3d flat = (end - begin) - normal * normal.dot(end - begin);
    const double radius = words_.holds("CR") ? words_.of("CR") * unit_ : scaled("R") * unit_;
    if (motion_ == 4) {
      Vector3d through;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::string name = std::string(1, "IJK"[i]) + "1";
        const Eigen::Index axis = static_cast<Eigen::Index>(i);
        through[axis] = !words_.holds(name) ? begin[axis]
                        : incremental_      ? begin[axis] + words_.of(name) * unit_
                                            : words_.of(name) * unit_ + zero(i);
      }
      // The bisecting planes of both chords and the plane of the three points.
      normal = (through - begin).cross(end - begin);
      Matrix3d planes;
      planes << (through - begin).transpose(), (end - begin).transpose(), normal.transpose();
      move.centre = planes.inverse() * Vector3d((through - begin).dot(through + begin) / 2,
                                                (end - begin).dot(end + begin) / 2, normal.dot(begin));
      normal.normalize();
    } else if (motion_ == 5) {
      const Vector3d across = normal.cross(tangent_);
      move.centre = begin + across * flat.squaredNorm() / (2 * flat.dot(across));
      sense = flat.dot(across) > 0 ? 1 : -1;
    } else if (words_.holds("R") || words_.holds("CR")) {
      const double height = std::sqrt(std::max(0.0, radius * radius - flat.squaredNorm() / 4));
      move.centre = begin + flat / 2 + (radius > 0 ? sense : -sense) * height * normal.cross(flat).normalized();
    } else {
      move.centre = begin;
      for (const std::size_t i : {plane_[0], plane_[1]}) {
        const std::string name(1, "IJK"[i]);
        const bool absolute = words_.holds(name) && words_.word.at(name).counts != 0
                                  ? words_.word.at(name).counts == 'A'
                                  : absolute_centre_;
        double& place = move.centre[static_cast<Eigen::Index>(i)];
        place = absolute ? scaled(name) * unit_ + zero(i) : place + scaled(name) * unit_;
      }
    }
    move.along = begin - move.centre;
    move.across = normal.cross(move.along);
    const Vector3d to = end - move.centre;
    double sweep = sense * std::atan2(to.dot(move.across), to.dot(move.along));
    while (sweep <= 1e-12) sweep += 2 * std::numbers::pi;
    if (flat.norm() == 0) sweep = 2 * std::numbers::pi;
    if (words_.holds("TURN")) sweep += 2 * std::numbers::pi * words_.of("TURN");
    if (!fanuc_ && !siemens_ && words_.holds("P")) sweep += 2 * std::numbers::pi * (words_.of("P") - 1);
    move.sweep_rad = sense * sweep;
  }

  ScanSettings settings_;
  bool fanuc_, siemens_;
  bool tcp_, vectors_ = false;
  std::array<double, 3> offset_{};
  AxisValues at_{}, shift_{}, kept_{}, outside_{};
  int motion_ = 1, percents_ = 0;
  double unit_ = 1;
  std::array<double, 2> feed_{};  // F and its unit
  int feed_mode_ = 94;
  bool great_circle_ = false, incremental_ = false, absolute_centre_ = false, ended_ = false;
  std::array<std::size_t, 3> plane_{0, 1, 2};
  std::optional<Eigen::Isometry3d> tip_frame_, plane_frame_, none_;
  Vector3d tangent_ = Vector3d::Zero();
  // Of the line.
  PlainWords words_;
  bool machine_ = false, home_ = false, used_ = false;
  int set_ = 0;
};

}  // namespace

std::unique_ptr<PlainPlayer> plain_iso_player(const std::string& dialect, const ScanSettings& settings) {
  return std::make_unique<PlainIsoPlayer>(dialect, settings);
}

}  // namespace trunnion
