#include "postproc/playback.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "error.h"

namespace trunnion {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

bool known(const AxisValues& at) {
  return std::none_of(at.begin(), at.end(), [](double place) { return std::isnan(place); });
}

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

/// The words of a line by letter; G and M codes apart. Enough for programs that the scan has let through.
struct PlainWords {
  std::array<double, 26> value{};
  std::array<bool, 26> has{};
  std::vector<double> g, m;

  bool holds(char letter) const { return has[static_cast<std::size_t>(letter - 'A')]; }
  double of(char letter) const { return value[static_cast<std::size_t>(letter - 'A')]; }
};

PlainWords plain_words(const std::string& line) {
  std::string text;
  bool comment = false;
  for (const char c : line) {
    if (c == ';' && !comment) break;
    if (c == '(') comment = true;
    if (!comment && c != '+' && static_cast<unsigned char>(c) > ' ' && c != '\x7f') text += c;
    if (c == ')') comment = false;
  }
  PlainWords words;
  if (text.empty() || text[0] == '%' || text[0] == '#' || text[0] == '/') return words;
  const char* const end = text.data() + text.size();
  for (const char* at = text.data(); at != end;) {
    const char letter = static_cast<char>(*at >= 'a' && *at <= 'z' ? *at - 'a' + 'A' : *at);
    ++at;
    if (letter < 'A' || letter > 'Z') continue;
    double value = kUnknown;
    at = std::from_chars(at, end, value, std::chars_format::fixed).ptr;
    if (std::isnan(value)) continue;
    if (letter == 'G')
      words.g.push_back(value);
    else if (letter == 'M')
      words.m.push_back(value);
    words.value[static_cast<std::size_t>(letter - 'A')] = value;
    words.has[static_cast<std::size_t>(letter - 'A')] = true;
  }
  return words;
}

/// One move: all five axes, and how it runs between.
struct Move {
  AxisValues from{}, to{};
  bool feed = false;
  bool arc = false;
  std::size_t first = 0, second = 1;
  double centre_first = 0, centre_second = 0, sweep_rad = 0;
  int tilt_sense = 1, turn_sense = 1;

  AxisValues at(double s) const {
    if (s >= 1) return to;
    AxisValues place;
    for (std::size_t i = 0; i < kAxes; ++i) place[i] = from[i] + s * (to[i] - from[i]);
    if (arc) {
      const double angle = s * sweep_rad, c = std::cos(angle), n = std::sin(angle);
      const double a = from[first] - centre_first, b = from[second] - centre_second;
      place[first] = centre_first + c * a - n * b;
      place[second] = centre_second + n * a + c * b;
    }
    return place;
  }
};

class PlainPlayer {
 public:
  explicit PlainPlayer(const ScanSettings& settings) : letters_(settings.letters), offsets_(settings.work_offsets_mm) {
    at_.fill(kUnknown);
    select("G54");
  }

  /// The move that a line makes with all axes known, before and after.
  std::optional<Move> play(const std::string& line) {
    if (line.find('%') == 0 && ++percents_ == 2) ended_ = true;
    if (ended_) return std::nullopt;
    const PlainWords w = plain_words(line);
    bool machine = false, home = false, offset_words = false;
    double set = 0;
    for (const double g : w.g) {
      if (g <= 3)
        motion_ = static_cast<int>(g);
      else if (g == 17)
        first_ = 0, second_ = 1;
      else if (g == 18)
        first_ = 2, second_ = 0;
      else if (g == 19)
        first_ = 1, second_ = 2;
      else if (g == 20)
        unit_ = 25.4;
      else if (g == 21)
        unit_ = 1;
      else if (g == 90)
        incremental_ = false;
      else if (g == 91)
        incremental_ = true;
      else if (g == 90.1)
        absolute_centre_ = true;
      else if (g == 91.1)
        absolute_centre_ = false;
      else if (g == 28 || g == 30)
        home = true;
      else if (g == 53)
        machine = true;
      else if (g == 43.1 || g == 28.1 || g == 30.1 || g == 10)
        offset_words = true;
      else if (g == 52 || g == 92 || g == 92.1 || g == 92.2 || g == 92.3)
        set = g;
      else if (g >= 54 && g < 60)
        select(code(g));
      if (g == 43 || g == 43.1 || g == 43.2 || g == 49) at_[2] = kUnknown;
    }
    for (const double m : w.m) {
      if (m == 6 || m == 61) at_.fill(kUnknown);
      if (m == 2 || m == 30) ended_ = true;
    }
    if (offset_words) return std::nullopt;
    if (set == 92.1) shift_ = kept_ = {};
    if (set == 92.2) kept_ = shift_, shift_ = {};
    if (set == 92.3) shift_ = kept_;
    bool words = false;
    Move move;
    move.from = at_;
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (!w.holds(letters_[i])) continue;
      const double value = w.of(letters_[i]) * (i < 3 ? unit_ : 1), offset = i < 3 ? offset_[i] : 0;
      words = true;
      if (set == 52)
        shift_[i] = value;
      else if (set == 92)
        shift_[i] = at_[i] - offset - value;
      else if (machine || home)
        at_[i] = kUnknown;
      else
        at_[i] = incremental_ ? at_[i] + value : value + offset + shift_[i];
    }
    if (home && !words) at_.fill(kUnknown);
    if (machine || home || set != 0) return std::nullopt;
    const bool centre = w.holds('I') || w.holds('J') || w.holds('K') || w.holds('R');
    if (!words && !(motion_ >= 2 && centre)) return std::nullopt;
    move.to = at_;
    move.feed = motion_ != 0;
    if (motion_ >= 2) make_arc(move, w);
    for (const auto& [axis, sense] : {std::pair(kTilt, &tilt_sense_), std::pair(kTurn, &turn_sense_)})
      if (!std::isnan(move.from[axis]) && move.to[axis] != move.from[axis])
        *sense = move.to[axis] > move.from[axis] ? 1 : -1;
    move.tilt_sense = tilt_sense_;
    move.turn_sense = turn_sense_;
    if (!known(move.to)) return std::nullopt;
    return move;
  }

 private:
  static std::string code(double g) {
    const int tenths = static_cast<int>(std::lround(10 * g));
    return "G" + std::to_string(tenths / 10) + (tenths % 10 != 0 ? "." + std::to_string(tenths % 10) : "");
  }

  void select(const std::string& system) {
    const auto found = offsets_.find(system);
    offset_ = found == offsets_.end() ? std::array<double, 3>{} : found->second;
  }

  void make_arc(Move& move, const PlainWords& w) const {
    move.arc = true;
    move.first = first_;
    move.second = second_;
    const double sense = motion_ == 3 ? 1 : -1;
    const double a0 = move.from[first_], b0 = move.from[second_], a1 = move.to[first_], b1 = move.to[second_];
    if (w.holds('R')) {
      const double r = w.of('R') * unit_, chord = std::hypot(a1 - a0, b1 - b0);
      const double h = std::sqrt(std::max(0.0, r * r - chord * chord / 4)) * (r > 0 ? sense : -sense);
      move.centre_first = (a0 + a1) / 2 - h * (b1 - b0) / chord;
      move.centre_second = (b0 + b1) / 2 + h * (a1 - a0) / chord;
    } else {
      const auto centre = [&](std::size_t axis, double from) {
        const char letter = "IJK"[axis];
        const double value = w.holds(letter) ? w.of(letter) * unit_ : 0;
        return absolute_centre_ ? value + offset_[axis] + shift_[axis] : from + value;
      };
      move.centre_first = centre(first_, a0);
      move.centre_second = centre(second_, b0);
    }
    const double begin = std::atan2(b0 - move.centre_second, a0 - move.centre_first);
    const double end = std::atan2(b1 - move.centre_second, a1 - move.centre_first);
    double turn = sense * (end - begin);
    while (turn <= 1e-12) turn += 2 * std::numbers::pi;
    while (turn > 2 * std::numbers::pi + 1e-12) turn -= 2 * std::numbers::pi;
    if (a0 == a1 && b0 == b1) turn = 2 * std::numbers::pi;
    if (w.holds('P')) turn += 2 * std::numbers::pi * (w.of('P') - 1);
    move.sweep_rad = sense * turn;
  }

  std::array<char, kAxes> letters_;
  std::map<std::string, std::array<double, 3>> offsets_;
  std::array<double, 3> offset_{};
  AxisValues at_{}, shift_{}, kept_{};
  int motion_ = 1, percents_ = 0;
  double unit_ = 1;
  bool incremental_ = false, absolute_centre_ = false, ended_ = false;
  std::size_t first_ = 0, second_ = 1;
  int tilt_sense_ = 1, turn_sense_ = 1;
};

/// The senses are those that the program means: a correction's own steps are smaller than any backlash.
Commanded commanded(const AxisValues& at, const Move& meant) {
  return {Eigen::Vector3d(at[0], at[1], at[2]),
          {Angle::degrees(at[kTilt]), Angle::degrees(at[kTurn])},
          meant.tilt_sense,
          meant.turn_sense};
}

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
                                       double step_deg) {
  Lines lines(program());
  PlainPlayer player(settings);
  std::vector<PlayedPlace> places;
  std::string line;
  for (std::uint64_t number = 1; lines.next(line); ++number) {
    const std::optional<Move> move = player.play(line);
    if (!move || !move->feed) continue;
    int pieces = 1;
    if (known(move->from)) {
      double steps = 1;
      for (std::size_t i = 0; i < kAxes; ++i) {
        double way = std::abs(move->to[i] - move->from[i]);
        if (move->arc && i < 3)
          way += std::abs(move->sweep_rad) * std::hypot(move->from[move->first] - move->centre_first,
                                                        move->from[move->second] - move->centre_second);
        steps = std::max(steps, way / (i < 3 ? step_mm : step_deg));
      }
      pieces = static_cast<int>(std::min(std::ceil(steps), 1e6));
    }
    for (int k = 1; k <= pieces; ++k) places.push_back({number, move->at(static_cast<double>(k) / pieces)});
  }
  return places;
}

PlaybackResult play_back(const OpenProgram& original, const OpenProgram& corrected, const Corrector& with_tcp,
                         const Corrector& without_tcp, const ProgramCorrection& how,
                         const ProgramCorrectionResult& correction) {
  const Corrector& judge = how.scan.tcp ? with_tcp : without_tcp;
  Lines meant_lines(original()), sent_lines(corrected());
  PlainPlayer meant_player(how.scan), sent_player(how.scan);
  Collected before, after;
  PlaybackResult result;
  std::string line;
  auto insertion = correction.inserted.begin();
  std::uint64_t sent_line = 0;
  const auto next_sent = [&] {
    ++sent_line;
    if (!sent_lines.next(line)) throw InputError("the corrected program ends before the original does");
    return sent_player.play(line);
  };
  std::vector<Move> pieces;
  for (std::uint64_t number = 1; meant_lines.next(line); ++number) {
    const std::optional<Move> meant = meant_player.play(line);
    if (sent_line + 1 == correction.header_line) next_sent();
    pieces.clear();
    if (const auto piece = next_sent()) pieces.push_back(*piece);
    if (insertion != correction.inserted.end() && insertion->line == number) {
      for (std::uint32_t i = 0; i < insertion->count; ++i)
        if (const auto piece = next_sent()) pieces.push_back(*piece);
      ++insertion;
    }
    if (meant.has_value() == pieces.empty())
      throw InputError(how.name, number, "the corrected program moves otherwise here");
    if (!meant) continue;
    ++result.moves;
    const double n = static_cast<double>(pieces.size());
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      for (const double s : {0.5, 1.0}) {
        if (s < 1 && (!meant->feed || !known(meant->from))) continue;
        const Commanded wanted = commanded(meant->at((static_cast<double>(k) + s) / n), *meant);
        const Commanded sent = commanded(pieces[k].at(s), *meant);
        const PathStretch there{.line = number,
                                .tip_before_mm = judge.tip_error_mm(wanted, wanted),
                                .tip_after_mm = judge.tip_error_mm(wanted, sent),
                                .tilt_before_rad = judge.tilt_error(wanted, wanted.rotary).in_radians(),
                                .tilt_after_rad = judge.tilt_error(wanted, sent.rotary).in_radians()};
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
