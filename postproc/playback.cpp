#include "postproc/playback.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "geometric_errors/pose_error.h"
#include "postproc/plain_player.h"

namespace trunnion {
namespace {

/// A program line by line.
class Lines {
 public:
  explicit Lines(ReadBytes read) : read_(std::move(read)), buffer_(std::size_t{1} << 16, '\0') {}

  bool next(std::string& line) {
    line.clear();
    for (;;) {
      if (at_ == end_) {
        end_ = read_(buffer_.data(), buffer_.size());
        at_ = 0;
        if (end_ == 0) return !line.empty();
      }
      const char c = buffer_[at_++];
      line += c;
      if (c == '\n') return true;
    }
  }

 private:
  ReadBytes read_;
  std::string buffer_;
  std::size_t at_ = 0, end_ = 0;
};

/// The senses are those that the program means: a correction's own steps are smaller than any backlash.
Commanded commanded(const AxisValues& at, const PlayedMove& meant, double time_s) {
  return {Eigen::Vector3d(at[0], at[1], at[2]),
          {Angle::degrees(at[kTilt]), Angle::degrees(at[kTurn])},
          meant.tilt_sense,
          meant.turn_sense,
          meant.linear_sense,
          time_s};
}

/// The machine as its model tells it, played by the plain transforms: nothing of how a correction is found.
class PlayedMachine {
 public:
  PlayedMachine(const KinematicChain& chain, const ErrorField& field, double tool_length_mm)
      : chain_(chain), field_(field), tool_(0, 0, -tool_length_mm), tool_length_mm_(tool_length_mm) {}

  const KinematicChain& chain() const { return chain_; }

  /// Where the slides carry the spindle's reference, in R.
  Eigen::Vector3d slides_mm(const Commanded& at, bool tcp) const {
    return tip_r(at, tcp) - chain_.r_from_t(at.rotary) * tool_ + tool_;
  }

  struct Tool {
    Eigen::Vector3d tip_w_mm, axis_w;
  };
  /// As the nominal machine holds it: what the program means.
  Tool meant(const Commanded& at, bool tcp) const {
    const Eigen::Isometry3d w_from_r = chain_.r_from_w(at.rotary).inverse();
    return {w_from_r * tip_r(at, tcp), w_from_r.linear() * chain_.r_from_t(at.rotary).linear().col(2)};
  }
  /// As the machine holds it, its table out of place by the pose error: p_actual = T(Delta) r_from_w p_w.
  Tool held(const Commanded& at, bool tcp) const {
    const Eigen::Vector3d tip = tip_r(at, tcp);
    Situation situation;
    situation.at = at.rotary;
    situation.point_r_mm = tip;
    situation.tilt_sense = at.tilt_sense;
    situation.turn_sense = at.turn_sense;
    situation.linear_sense = {double(at.linear_sense[0]), double(at.linear_sense[1]), double(at.linear_sense[2])};
    situation.time_s = at.time_s;
    situation.tool_length_mm = tool_length_mm_;
    const Eigen::Isometry3d w_from_r = (transform(field_.exactly_at(situation)) * chain_.r_from_w(at.rotary)).inverse();
    return {w_from_r * tip, w_from_r.linear() * chain_.r_from_t(at.rotary).linear().col(2)};
  }

 private:
  Eigen::Vector3d tip_r(const Commanded& at, bool tcp) const {
    if (tcp) return chain_.r_from_w(at.rotary) * at.xyz_mm;
    return at.xyz_mm + chain_.r_from_t(at.rotary) * tool_ - tool_;
  }

  const KinematicChain& chain_;
  const ErrorField& field_;
  Eigen::Vector3d tool_;
  double tool_length_mm_;
};

/// In which sense the axes moved last; to and fro of a slide by less than a micrometre is rounding.
class Senses {
 public:
  Senses(const PlayedMachine& machine, bool slides) : machine_(machine), slides_(slides) {}

  void tell(PlayedMove& move) {
    follow(move, kTilt, tilt_);
    follow(move, kTurn, turn_);
    move.tilt_sense = tilt_;
    move.turn_sense = turn_;
    if (slides_) follow_slides(move);
  }

 private:
  static void follow(const PlayedMove& move, std::size_t axis, int& sense) {
    if (!std::isnan(move.from[axis]) && move.to[axis] != move.from[axis])
      sense = move.to[axis] > move.from[axis] ? 1 : -1;
  }
  void follow_slides(PlayedMove& move) {
    constexpr double kStill_mm = 1e-3;
    const bool known = move.begins_known();
    for (const double s : {0.25, 0.5, 0.75, 0.9, 1.0}) {
      if (s < 1 && !(known && move.feed)) continue;
      const Eigen::Vector3d now = machine_.slides_mm(commanded(move.at(s, &machine_.chain()), move, 0), move.tcp);
      for (std::size_t i = 0; i < 3; ++i) {
        const double way = now[static_cast<Eigen::Index>(i)] - turned_mm_[i];
        const bool on = way * linear_[i] > 0;
        if (!known || on || std::abs(way) > kStill_mm) {
          linear_[i] = static_cast<std::int8_t>(!known ? 0 : way > 0 ? 1 : -1);
          turned_mm_[i] = now[static_cast<Eigen::Index>(i)];
        }
      }
    }
    move.linear_sense = linear_;
  }

  const PlayedMachine& machine_;
  bool slides_;
  int tilt_ = 1, turn_ = 1;
  std::array<std::int8_t, 3> linear_{};
  std::array<double, 3> turned_mm_{};
};

/// Largest and root mean square of errors as they come.
class Collected {
 public:
  void add(double tip_mm, double tilt_rad, std::uint64_t line) {
    if (!(tip_mm <= error_.largest_tip_mm)) error_.largest_tip_mm = tip_mm, error_.tip_line = line;
    if (!(tilt_rad <= error_.largest_tilt_rad)) error_.largest_tilt_rad = tilt_rad, error_.tilt_line = line;
    tip2_ += tip_mm * tip_mm;
    tilt2_ += tilt_rad * tilt_rad;
    ++count_;
  }
  PathError result() const {
    PathError error = error_;
    const double n = static_cast<double>(std::max<std::uint64_t>(count_, 1));
    error.rms_tip_mm = std::sqrt(tip2_ / n);
    error.rms_tilt_rad = std::sqrt(tilt2_ / n);
    return error;
  }
  std::uint64_t count() const { return count_; }

 private:
  PathError error_;
  double tip2_ = 0, tilt2_ = 0;
  std::uint64_t count_ = 0;
};

}  // namespace

std::vector<PlayedPlace> played_places(const OpenProgram& program, const ScanSettings& settings, double step_mm,
                                       double step_deg, const std::string& dialect) {
  Lines lines(program());
  const std::unique_ptr<PlainPlayer> player = plain_player(dialect, settings);
  std::vector<PlayedPlace> places;
  std::string line;
  for (std::uint64_t number = 1; lines.next(line); ++number) {
    const std::optional<PlayedMove> move = player->play(line);
    if (!move || !move->feed) continue;
    int pieces = 1;
    if (move->begins_known()) {
      double steps = 1;
      for (std::size_t i = 0; i < kAxes; ++i) {
        double way = std::abs(move->to[i] - move->from[i]);
        if (move->arc && i < 3) way += std::abs(move->sweep_rad) * move->along.norm();
        steps = std::max(steps, way / (i < 3 ? step_mm : step_deg));
      }
      pieces = static_cast<int>(std::min(std::ceil(steps), 1e6));
    }
    for (int k = 1; k <= pieces; ++k)
      places.push_back({number, move->at(static_cast<double>(k) / pieces, settings.chain), move->tcp});
  }
  return places;
}

PlaybackResult play_back(const OpenProgram& original, const OpenProgram& corrected, const Corrector& with_tcp,
                         const ProgramCorrection& how, const ProgramCorrectionResult& correction) {
  Lines meant_lines(original()), sent_lines(corrected());
  const std::unique_ptr<PlainPlayer> meant_player = plain_player(how.dialect, how.scan);
  const std::unique_ptr<PlainPlayer> sent_player = plain_player(how.dialect, how.scan);
  Collected before, after;
  PlaybackResult result;
  std::string line;
  auto insertion = correction.inserted.begin();
  std::uint64_t sent_line = 0;
  const auto next_sent = [&] {
    ++sent_line;
    if (!sent_lines.next(line)) throw InputError("the corrected program ends before the original does");
    return sent_player->play(line);
  };
  const PlayedMachine machine(with_tcp.chain(), with_tcp.field(), with_tcp.settings().tool_length_mm);
  Senses senses(machine, how.scan.follow_senses);
  double time_s = 0;
  std::vector<PlayedMove> pieces;
  for (std::uint64_t number = 1; meant_lines.next(line); ++number) {
    std::optional<PlayedMove> meant = meant_player->play(line);
    if (meant) senses.tell(*meant);
    if (meant && how.scan.follow_time) time_s += meant->seconds;
    if (sent_line + 1 == correction.header_line) next_sent();
    pieces.clear();
    bool takes_up = false;
    if (const auto piece = next_sent()) pieces.push_back(*piece);
    if (insertion != correction.inserted.end() && insertion->line == number) {
      for (std::uint32_t i = 0; i < insertion->count; ++i)
        if (const auto piece = next_sent()) pieces.push_back(*piece);
      takes_up = insertion->takes_up;
      ++insertion;
    }
    if (meant.has_value() == pieces.empty())
      throw InputError(how.name, number, "the corrected program moves otherwise here");
    if (!meant) continue;
    ++result.moves;
    const KinematicChain* chain = &machine.chain();
    const double first = takes_up ? 1 : 0, n = static_cast<double>(pieces.size()) - first;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const bool on_the_spot = takes_up && k == 0;
      for (const double s : {0.5, 1.0}) {
        if (s < 1 && (on_the_spot || !meant->feed || !meant->begins_known())) continue;
        const double part = on_the_spot ? 0 : (static_cast<double>(k) - first + s) / n;
        const Commanded wanted = commanded(meant->at(part, chain), *meant, time_s);
        const Commanded sent = commanded(pieces[k].at(s, chain), *meant, time_s);
        const PlayedMachine::Tool aim = machine.meant(wanted, meant->tcp),
                                  as_programmed = machine.held(wanted, meant->tcp),
                                  as_sent = machine.held(sent, meant->tcp);
        const PathStretch there{.line = number,
                                .tip_before_mm = (as_programmed.tip_w_mm - aim.tip_w_mm).norm(),
                                .tip_after_mm = (as_sent.tip_w_mm - aim.tip_w_mm).norm(),
                                .tilt_before_rad = as_programmed.axis_w.cross(aim.axis_w).norm(),
                                .tilt_after_rad = as_sent.axis_w.cross(aim.axis_w).norm()};
        before.add(there.tip_before_mm, there.tilt_before_rad, number);
        after.add(there.tip_after_mm, there.tilt_after_rad, number);
        result.along.add(there);
      }
    }
  }
  if (sent_lines.next(line)) throw InputError("the corrected program goes on behind the original's end");
  result.samples = after.count();
  result.before = before.result();
  result.after = after.result();
  return result;
}

}  // namespace trunnion
