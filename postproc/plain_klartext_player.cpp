#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>

#include "postproc/plain_player.h"

namespace trunnion {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

/// A Klartext block as its words by name: X, IY, DR (its sign), M codes in a list. Words are set apart by blanks.
struct KlartextWords {
  std::map<std::string, double> value;
  std::vector<std::string> word;
  std::vector<int> m;

  explicit KlartextWords(std::string line) {
    line = line.substr(0, line.find(';'));
    std::string apart;
    for (char c : line) {
      if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 32);
      // A letter behind a digit begins a word: X+1Y+2.
      if (c >= 'A' && c <= 'Z' && !apart.empty() && std::isdigit(static_cast<unsigned char>(apart.back())))
        apart += ' ';
      apart += c == ',' ? '.' : static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
    std::istringstream text(apart);
    for (std::string piece; text >> piece;) {
      if (word.empty() && std::isdigit(static_cast<unsigned char>(piece[0]))) continue;
      std::size_t letters = 0;
      while (letters < piece.size() && std::isalpha(static_cast<unsigned char>(piece[letters]))) ++letters;
      const std::string name = piece.substr(0, letters);
      std::string number = piece.substr(letters);
      word.push_back(piece);
      if (number == "+" || number == "-") value[name] = number == "+" ? 1 : -1;
      if (number.starts_with('+')) number.erase(0, 1);
      double parsed = 0;
      const auto [end, error] =
          std::from_chars(number.data(), number.data() + number.size(), parsed, std::chars_format::fixed);
      if (number.empty() || error != std::errc() || end != number.data() + number.size()) continue;
      if (name == "M")
        m.push_back(code_number(parsed));
      else
        value[name] = parsed;
    }
  }

  std::string first() const { return word.empty() ? "" : word.front(); }
  bool says(const std::string& name) const { return std::find(word.begin(), word.end(), name) != word.end(); }
  bool holds(const std::string& name) const { return value.contains(name); }
  double of(const std::string& name) const { return holds(name) ? value.at(name) : 0; }
};

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

class PlainKlartextPlayer : public PlainPlayer {
 public:
  explicit PlainKlartextPlayer(const ScanSettings& settings) : settings_(settings), tcp_(settings.tcp) {
    at_.fill(kNotKnown);
    shortest_ = settings.control.turn_path == "shortest";
    if (const auto found = settings.work_offsets_mm.find("G54"); found != settings.work_offsets_mm.end())
      offset_ = found->second;
  }

  std::optional<PlayedMove> play(const std::string& line) override {
    if (ended_) return std::nullopt;
    const KlartextWords w(line);
    const std::string first = w.first();
    std::optional<PlayedMove> move;
    for (const int m : w.m) before(m);
    if (first == "BEGIN") unit_ = w.says("INCH") ? 25.4 : 1;
    if (first == "END") ended_ = true;
    if (first == "TOOL" && w.says("CALL")) call_tool(w);
    if (first == "CC") pole(w);
    if (first == "CYCL" && w.says("DEF")) shift(w);
    if (first == "FUNCTION") {
      if (w.says("TCPM")) control_tip(!w.says("RESET"));
      great_circle_ = w.says("TCPM") && w.says("VECTOR");
    }
    if (first == "PLANE") plane(w);
    if (first == "L" || first == "LN" || first == "C" || first == "CR" || first == "CT" || first == "CP")
      move = moved(w, first);
    for (const int m : w.m) {
      if (m == 140) at_[0] = at_[1] = at_[2] = kNotKnown;
      if (m == 2 || m == 30) ended_ = true;
    }
    return move;
  }

  void forget() override { at_.fill(kNotKnown); }

 private:
  void before(int m) {
    if (m == 6) at_.fill(kNotKnown);
    if (m == 94) at_[kTurn] -= 360 * std::floor(at_[kTurn] / 360);
    if (m == 126 || m == 127) shortest_ = m == 126;
    if (m == 128 || m == 129) {
      control_tip(m == 128);
      great_circle_ = false;
    }
  }

  void control_tip(bool on) {
    if (settings_.tcp_forced || on == tcp_) return;
    tcp_ = on;
    tip_frame_.reset();
    if (on && settings_.control.tcp_frame == "start")
      tip_frame_ = settings_.chain->r_from_w({Angle::degrees(at_[kTilt]), Angle::degrees(at_[kTurn])}).inverse();
    at_[0] = at_[1] = at_[2] = kNotKnown;
  }

  void call_tool(const KlartextWords& w) {
    for (std::size_t i = 2; i < w.word.size() && i < 3; ++i)
      if (std::isdigit(static_cast<unsigned char>(w.word[i][0])) || w.word[i][0] == '"' || w.word[i][0] == 'Q')
        at_.fill(kNotKnown);
    if (w.says("X")) plane_ = {1, 2, 0};
    if (w.says("Y")) plane_ = {2, 0, 1};
    if (w.says("Z")) plane_ = {0, 1, 2};
  }

  double zero(std::size_t axis) const { return (axis < 3 && !plane_frame_ ? offset_[axis] : 0) + shift_[axis]; }

  void pole(const KlartextWords& w) {
    bool any = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string name(1, "XYZ"[i]);
      if (w.holds(name)) pole_[i] = w.of(name) * unit_ + zero(i);
      if (w.holds("I" + name)) pole_[i] = at_[i] + w.of("I" + name) * unit_;
      any |= w.holds(name) || w.holds("I" + name);
    }
    if (!any) pole_ = {at_[0], at_[1], at_[2]};
  }

  void shift(const KlartextWords& w) {
    // CYCL DEF 7.1 X+10
    if (w.word.size() < 3) return;
    const std::string& number = w.word[2];
    if (number.starts_with("19.") && number != "19.0") leave_plane();
    if (!number.starts_with("7.") || number == "7.0") return;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const std::string name(1, settings_.letters[i]);
      const double unit = i < 3 ? unit_ : 1;
      if (w.holds(name)) shift_[i] = w.of(name) * unit;
      if (w.holds("I" + name)) shift_[i] += w.of("I" + name) * unit;
    }
  }

  void plane(const KlartextWords& w) {
    leave_plane();
    if (w.says("RESET")) {
      if (!w.says("STAY")) at_[kTilt] = at_[kTurn] = kNotKnown;
      return;
    }
    const auto turn = [](double degrees, int about) {
      return Matrix3d(AngleAxisd(radians(degrees), Vector3d::Unit(about)));
    };
    plane_frame_ = Eigen::Isometry3d::Identity();
    plane_frame_->linear() = w.says("EULER") ? turn(w.of("EULPR"), 2) * turn(w.of("EULNU"), 0) * turn(w.of("EULROT"), 2)
                                             : turn(w.of("SPC"), 2) * turn(w.of("SPB"), 1) * turn(w.of("SPA"), 0);
    for (std::size_t i = 0; i < 3; ++i)
      plane_frame_->translation()[static_cast<Eigen::Index>(i)] = offset_[i] + shift_[i];
    outside_ = shift_;
    shift_[0] = shift_[1] = shift_[2] = 0;
    at_[0] = at_[1] = at_[2] = kNotKnown;
    sense_ = w.holds("SEQ") ? w.of("SEQ") : w.of("SYM");
    if (!w.says("STAY")) across_plane();
  }

  void across_plane() {
    const Vector3d axis = plane_frame_->linear().col(2);
    const auto [tilt, turn] = descended_to_axis(settings_, axis, sense_ != 0 ? 100 * sense_ : at_[kTilt], at_[kTurn]);
    at_[kTilt] = tilt;
    at_[kTurn] = std::abs(axis.z()) > 1 - 1e-14 ? kNotKnown : turn;
  }

  void leave_plane() {
    if (!plane_frame_) return;
    plane_frame_.reset();
    for (std::size_t i = 0; i < 3; ++i) shift_[i] = outside_[i], at_[i] = kNotKnown;
  }

  std::optional<PlayedMove> moved(const KlartextWords& w, const std::string& first) {
    bool machine = false;
    for (const int m : w.m) machine |= m == 91 || m == 92;
    PlayedMove move;
    move.from = at_;
    bool any = false, asked = false;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const std::string name(1, settings_.letters[i]);
      const double unit = i < 3 ? unit_ : 1;
      for (const std::string& word : w.word) asked |= i >= kTilt && word.starts_with(name + "+Q12");
      if (!w.holds(name) && !w.holds("I" + name)) continue;
      any = true;
      double place = w.of(name) * unit + zero(i);
      if (i == kTurn && shortest_ && settings_.modulo_turn && !std::isnan(at_[i]))
        place += 360 * std::round((at_[i] - place) / 360);
      at_[i] = machine ? kNotKnown : w.holds("I" + name) ? at_[i] + w.of("I" + name) * unit : place;
    }
    if (asked) {
      across_plane();
      return std::nullopt;
    }
    if (machine) {
      if (!any) at_.fill(kNotKnown);
      return std::nullopt;
    }
    if (w.holds("TX")) {
      any = true;
      Vector3d axis = Vector3d(w.of("TX"), w.of("TY"), w.of("TZ")).normalized();
      if (tip_frame_) axis = tip_frame_->linear() * axis;
      const auto [tilt, turn] = descended_to_axis(settings_, axis, at_[kTilt], at_[kTurn]);
      at_[kTilt] = tilt;
      if (axis.z() <= 1 - 1e-14) at_[kTurn] = turn;
    }
    if (!any && first[0] != 'C') return std::nullopt;
    move.feed = !w.says("FMAX");
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
    if (first[0] == 'C') {
      if (first == "CP") round_pole(w);
      move.to = at_;
      make_arc(move, w, first);
      tangent_ = (std::cos(move.sweep_rad) * move.across - std::sin(move.sweep_rad) * move.along) *
                 (move.sweep_rad < 0 ? -1 : 1);
    } else {
      move.to = at_;
      tangent_ = {move.to[0] - move.from[0], move.to[1] - move.from[1], move.to[2] - move.from[2]};
    }
    for (const double place : move.to)
      if (std::isnan(place)) return std::nullopt;
    if (w.holds("F")) feed_ = w.of("F");
    const bool straight = move.to[0] != move.from[0] || move.to[1] != move.from[1] || move.to[2] != move.from[2];
    if (move.feed && move.begins_known() && feed_ > 0)
      move.seconds = 60 * move.way() / (feed_ * (unit_ == 1 || !(straight || move.arc) ? 1 : 2.54));
    return move;
  }

  void round_pole(const KlartextWords& w) {
    const std::size_t a = plane_[0], b = plane_[1];
    const double x = at_[a] - pole_[a], y = at_[b] - pole_[b];
    const double end = w.holds("PA") ? radians(w.of("PA")) : std::atan2(y, x) + radians(w.of("IPA"));
    at_[a] = pole_[a] + std::hypot(x, y) * std::cos(end);
    at_[b] = pole_[b] + std::hypot(x, y) * std::sin(end);
  }

  void make_arc(PlayedMove& move, const KlartextWords& w, const std::string& first) const {
    move.arc = true;
    const Vector3d begin(move.from[0], move.from[1], move.from[2]), end(move.to[0], move.to[1], move.to[2]);
    const Vector3d normal = Vector3d::Unit(static_cast<Eigen::Index>(plane_[2]));
    const Vector3d flat = (end - begin) - normal * normal.dot(end - begin);
    double sense = w.of("DR");
    if (first == "CT") {
      const Vector3d across = normal.cross(tangent_);
      move.centre = begin + across * flat.squaredNorm() / (2 * flat.dot(across));
      sense = flat.dot(across) > 0 ? 1 : -1;
    } else if (first == "CR") {
      const double radius = w.of("R") * unit_;
      const double height = std::sqrt(std::max(0.0, radius * radius - flat.squaredNorm() / 4));
      move.centre = begin + flat / 2 + (radius > 0 ? sense : -sense) * height * normal.cross(flat).normalized();
    } else {
      move.centre = {pole_[0], pole_[1], pole_[2]};
      move.centre += normal * normal.dot(begin - move.centre);
    }
    move.along = begin - move.centre;
    move.across = normal.cross(move.along);
    const Vector3d to = end - move.centre;
    double sweep = sense * std::atan2(to.dot(move.across), to.dot(move.along));
    while (sweep <= 1e-12) sweep += 2 * std::numbers::pi;
    if (flat.norm() == 0) sweep = 2 * std::numbers::pi;
    if (w.holds("IPA")) sweep = std::abs(radians(w.of("IPA")));
    move.sweep_rad = sense * sweep;
  }

  ScanSettings settings_;
  bool tcp_, shortest_ = false, ended_ = false, great_circle_ = false;
  double unit_ = 1, sense_ = 0, feed_ = 0;
  std::array<double, 3> offset_{}, pole_{};
  AxisValues at_{}, shift_{}, outside_{};
  std::array<std::size_t, 3> plane_{0, 1, 2};
  std::optional<Eigen::Isometry3d> tip_frame_, plane_frame_, none_;
  Vector3d tangent_ = Vector3d::Zero();
};

}  // namespace

std::unique_ptr<PlainPlayer> plain_klartext_player(const ScanSettings& settings) {
  return std::make_unique<PlainKlartextPlayer>(settings);
}

}  // namespace trunnion
