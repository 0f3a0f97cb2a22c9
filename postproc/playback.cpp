#include "postproc/playback.h"

#include <algorithm>
#include <cmath>
#include <limits>

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
    double deviation_mm = 0, tilt_rad = 0;  // of the table's pose error at the tip
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
    const PoseError error = field_.exactly_at(situation);
    const Eigen::Isometry3d moved = transform(error), w_from_r = (moved * chain_.r_from_w(at.rotary)).inverse();
    return {w_from_r * tip, w_from_r.linear() * chain_.r_from_t(at.rotary).linear().col(2), (moved * tip - tip).norm(),
            error.rotation_rad.norm()};
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

/// The largest use of every limit, place by place.
class LimitsMet {
 public:
  LimitsMet(const Corrector& corrector, const CorrectionGuard& guard, const std::array<char, kAxes>& letters)
      : guard_(guard), letters_(letters), measured_(corrector.tilt_range()), word_(corrector.settings()) {}

  /// Where the slides stand, mm, the rotary axes as programmed and as sent, and the table's pose error there.
  void take(std::uint64_t line, const Eigen::Vector3d& slides_mm, const Commanded& wanted, const Commanded& sent,
            double deviation_mm, double tilt_rad) {
    for (std::size_t i = 0; i < 3; ++i) axis_[i].take(slides_mm[static_cast<Eigen::Index>(i)], line);
    axis_[kTilt].take(wanted.rotary.a.in_degrees(), line);
    axis_[kTurn].take(wanted.rotary.c.in_degrees(), line);
    deviation_um_.take(1e3 * deviation_mm, line);
    tilt_urad_.take(1e6 * tilt_rad, line);
    turn_deg_.take(std::abs((sent.rotary.c - wanted.rotary.c).in_degrees()), line);
  }

  /// The end of a block at feed, if `on_feed` one that goes on from the block before.
  void end_block(std::uint64_t line, const Commanded& wanted, const Commanded& sent, bool on_feed) {
    const Eigen::Vector3d by_mm = sent.xyz_mm - wanted.xyz_mm;
    const double tilt = (sent.rotary.a - wanted.rotary.a).in_degrees();
    const double turn = (sent.rotary.c - wanted.rotary.c).in_degrees();
    if (on_feed && block_before_) {
      change_um_.take(1e3 * (by_mm - by_mm_).norm(), line);
      change_deg_.take(std::max(std::abs(tilt - tilt_), std::abs(turn - turn_)), line);
    }
    block_before_ = true;
    by_mm_ = by_mm, tilt_ = tilt, turn_ = turn;
  }
  void interrupt() { block_before_ = false; }

  std::vector<LimitUse> result() const {
    std::vector<LimitUse> list;
    for (std::size_t i = 0; i < kAxes; ++i)
      if (guard_.stroke[i])
        list.push_back(range(std::string("axis.") + letters_[i] + (i < 3 ? ".range_mm" : ".range_deg"),
                             i < 3 ? "mm" : "deg", axis_[i], guard_.stroke[i]->first, guard_.stroke[i]->second));
    list.push_back(range(std::string("probed ") + letters_[kTilt], "deg", axis_[kTilt], measured_.low.in_degrees(),
                         measured_.high.in_degrees()));
    const CorrectionLimits& limits = guard_.limits;
    list.push_back(largest("limits.correction_um", "um", deviation_um_, limits.deviation.in_micrometres()));
    list.push_back(largest("limits.correction_urad", "urad", tilt_urad_, limits.tilt.in_microradians()));
    list.push_back(largest("limits.correction_C_deg", "deg", turn_deg_, word_.largest_rotary_change.in_degrees()));
    list.push_back(largest("limits.change_um", "um", change_um_, guard_.change.in_micrometres()));
    list.push_back(largest("limits.change_deg", "deg", change_deg_, guard_.rotary_change.in_degrees()));
    return list;
  }

 private:
  struct Used {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    std::uint64_t low_line = 0, high_line = 0;
    void take(double value, std::uint64_t line) {
      if (value < low) low = value, low_line = line;
      if (value > high) high = value, high_line = line;
    }
    bool any() const { return low <= high; }
  };
  static LimitUse largest(std::string limit, std::string unit, const Used& used, double allowed) {
    LimitUse use{.limit = std::move(limit), .unit = std::move(unit), .low = {}, .allowed_low = {}};
    use.high = used.any() ? used.high : 0;
    use.allowed_high = allowed;
    use.high_line = used.high_line;
    return use;
  }
  static LimitUse range(std::string limit, std::string unit, const Used& used, double from, double to) {
    LimitUse use = largest(std::move(limit), std::move(unit), used, to);
    use.low = used.any() ? used.low : 0;
    use.allowed_low = from;
    use.low_line = used.low_line;
    return use;
  }

  const CorrectionGuard& guard_;
  const std::array<char, kAxes>& letters_;
  Range<Angle> measured_;
  CorrectionSettings word_;
  std::array<Used, kAxes> axis_;
  Used deviation_um_, tilt_urad_, turn_deg_, change_um_, change_deg_;
  bool block_before_ = false;
  Eigen::Vector3d by_mm_ = Eigen::Vector3d::Zero();
  double tilt_ = 0, turn_ = 0;
};

/// The work of play_back: both programs side by side, block by block of the original.
class Playback {
 public:
  Playback(const OpenProgram& original, const OpenProgram& corrected, const Corrector& with_tcp,
           const ProgramCorrection& how, const ProgramCorrectionResult& correction)
      : how_(how),
        correction_(correction),
        meant_lines_(original()),
        sent_lines_(corrected()),
        meant_player_(plain_player(how.dialect, how.scan)),
        sent_player_(plain_player(how.dialect, how.scan)),
        machine_(with_tcp.chain(), with_tcp.field(), with_tcp.settings().tool_length_mm),
        senses_(machine_, how.scan.follow_senses),
        limits_(with_tcp, how.guard, how.scan.letters) {}

  PlaybackResult run() {
    auto refusal = correction_.refusals.begin();
    for (std::uint64_t number = 1; meant_lines_.next(meant_line_); ++number) {
      const Refusal* refused = nullptr;
      for (; refusal != correction_.refusals.end() && refusal->line == number; ++refusal) refused = &*refusal;
      if (sent_line_ + 1 == correction_.header_line) next_sent();
      if (refused != nullptr && refused->behind == Refusal::Behind::copied) {
        pass_over_the_rest(number);
        break;
      }
      take_block(number, refused);
    }
    if (sent_lines_.next(line_)) throw InputError("the corrected program goes on behind the original's end");
    result_.samples = after_.count();
    result_.before = before_.result();
    result_.after = after_.result();
    result_.limits = limits_.result();
    return result_;
  }

 private:
  std::optional<PlayedMove> next_sent() {
    ++sent_line_;
    if (!sent_lines_.next(line_)) throw InputError("the corrected program ends before the original does");
    return sent_player_->play(line_);
  }

  void pass_over_the_rest(std::uint64_t number) {
    result_.copied_from = number;
    ++result_.refused;
    do {
      if (!sent_lines_.next(line_) || line_ != meant_line_)
        throw InputError(how_.name, number, "the corrected program is no copy here");
      ++number;
    } while (meant_lines_.next(meant_line_));
  }

  void take_block(std::uint64_t number, const Refusal* refused) {
    std::optional<PlayedMove> meant = meant_player_->play(meant_line_);
    if (meant) senses_.tell(*meant);
    if (meant && how_.scan.follow_time) time_s_ += meant->seconds;
    pieces_.clear();
    bool takes_up = false;
    if (const auto piece = next_sent()) pieces_.push_back(*piece);
    if (insertion_ != correction_.inserted.end() && insertion_->line == number) {
      for (std::uint32_t i = 0; i < insertion_->count; ++i)
        if (const auto piece = next_sent()) pieces_.push_back(*piece);
      takes_up = insertion_->takes_up;
      ++insertion_;
    }
    if (refused != nullptr) {
      ++result_.refused;
      off_ = true;
      limits_.interrupt();
      if (refused->behind == Refusal::Behind::axes_unknown) {
        meant_player_->forget();
        sent_player_->forget();
      }
      return;
    }
    if (meant.has_value() == pieces_.empty())
      throw InputError(how_.name, number, "the corrected program moves otherwise here");
    if (!meant) return;
    ++result_.moves;
    compare(number, *meant, takes_up);
    off_ = false;
  }

  void compare(std::uint64_t number, const PlayedMove& meant, bool takes_up) {
    const KinematicChain* chain = &machine_.chain();
    const double first = takes_up ? 1 : 0, n = static_cast<double>(pieces_.size()) - first;
    Commanded wanted, sent;
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      const bool on_the_spot = takes_up && k == 0;
      for (const double s : {0.5, 1.0}) {
        if (s < 1 && (on_the_spot || !meant.feed || !meant.begins_known())) continue;
        if (s < 1 && off_ && k == 0) continue;  // it sets out from where nothing was corrected
        const double part = on_the_spot ? 0 : (static_cast<double>(k) - first + s) / n;
        wanted = commanded(meant.at(part, chain), meant, time_s_);
        sent = commanded(pieces_[k].at(s, chain), meant, time_s_);
        const PlayedMachine::Tool aim = machine_.meant(wanted, meant.tcp),
                                  as_programmed = machine_.held(wanted, meant.tcp),
                                  as_sent = machine_.held(sent, meant.tcp);
        const PathStretch there{.line = number,
                                .tip_before_mm = (as_programmed.tip_w_mm - aim.tip_w_mm).norm(),
                                .tip_after_mm = (as_sent.tip_w_mm - aim.tip_w_mm).norm(),
                                .tilt_before_rad = as_programmed.axis_w.cross(aim.axis_w).norm(),
                                .tilt_after_rad = as_sent.axis_w.cross(aim.axis_w).norm()};
        before_.add(there.tip_before_mm, there.tilt_before_rad, number);
        after_.add(there.tip_after_mm, there.tilt_after_rad, number);
        result_.along.add(there);
        if (s == 1)
          limits_.take(number, machine_.slides_mm(sent, meant.tcp), wanted, sent, as_sent.deviation_mm,
                       as_sent.tilt_rad);
      }
    }
    limits_.end_block(number, wanted, sent, meant.feed && meant.begins_known());
  }

  const ProgramCorrection& how_;
  const ProgramCorrectionResult& correction_;
  Lines meant_lines_, sent_lines_;
  std::unique_ptr<PlainPlayer> meant_player_, sent_player_;
  PlayedMachine machine_;
  Senses senses_;
  LimitsMet limits_;
  Collected before_, after_;
  std::string meant_line_, line_;
  std::uint64_t sent_line_ = 0;
  std::vector<Insertion>::const_iterator insertion_ = correction_.inserted.begin();
  double time_s_ = 0;
  std::vector<PlayedMove> pieces_;
  bool off_ = false;  // the block before was copied: the machine stands uncorrected
  PlaybackResult result_;
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
  return Playback(original, corrected, with_tcp, how, correction).run();
}

}  // namespace trunnion
