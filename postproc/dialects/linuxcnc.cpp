#include "postproc/dialects/dialects.h"
#include "postproc/iso_scanner.h"

namespace trunnion {
namespace linuxcnc_words {
namespace {

constexpr const char* kCycle = "a canned cycle; post the program with its single moves";
constexpr const char* kProbe = "probing ends where the part is, not where a program can say";
constexpr const char* kThread = "spindle-synchronised motion";
constexpr const char* kSpline = "splines are not corrected; post the program with lines";
constexpr const char* kForeignPlane = "planes of U V W";

constexpr CodeEntry kCodes[] = {
    {0, Code::rapid},
    {10, Code::line},
    {20, Code::clockwise},
    {30, Code::counter_clockwise},
    {40, Code::dwell},
    {50, Code::other_motion, kSpline},
    {51, Code::other_motion, kSpline},
    {52, Code::other_motion, kSpline},
    {53, Code::other_motion, kSpline},
    {70, Code::refused, "diameter programming belongs to a lathe"},
    {80, Code::harmless},
    {100, Code::alone},
    {170, Code::plane_xy},
    {171, Code::refused, kForeignPlane},
    {180, Code::plane_zx},
    {181, Code::refused, kForeignPlane},
    {190, Code::plane_yz},
    {191, Code::refused, kForeignPlane},
    {200, Code::inch},
    {210, Code::metric},
    {280, Code::home},
    {281, Code::alone},
    {300, Code::home},
    {301, Code::alone},
    {330, Code::other_motion, kThread},
    {331, Code::other_motion, kThread},
    {382, Code::other_motion, kProbe},
    {383, Code::other_motion, kProbe},
    {384, Code::other_motion, kProbe},
    {385, Code::other_motion, kProbe},
    {400, Code::cutter_off},
    {410, Code::cutter_on},
    {411, Code::cutter_on},
    {420, Code::cutter_on},
    {421, Code::cutter_on},
    {430, Code::tool_length},
    {431, Code::alone},
    {432, Code::tool_length},
    {490, Code::tool_length},
    {520, Code::alone},
    {530, Code::machine_coordinates},
    {540, Code::work_offset},
    {550, Code::work_offset},
    {560, Code::work_offset},
    {570, Code::work_offset},
    {580, Code::work_offset},
    {590, Code::work_offset},
    {591, Code::work_offset},
    {592, Code::work_offset},
    {593, Code::work_offset},
    {610, Code::harmless},
    {611, Code::harmless},
    {640, Code::dwell},
    {730, Code::other_motion, kCycle},
    {740, Code::other_motion, kCycle},
    {760, Code::other_motion, kCycle},
    {800, Code::no_motion},
    {810, Code::other_motion, kCycle},
    {820, Code::other_motion, kCycle},
    {830, Code::other_motion, kCycle},
    {840, Code::other_motion, kCycle},
    {850, Code::other_motion, kCycle},
    {860, Code::other_motion, kCycle},
    {870, Code::other_motion, kCycle},
    {880, Code::other_motion, kCycle},
    {890, Code::other_motion, kCycle},
    {900, Code::absolute},
    {901, Code::absolute_centre},
    {910, Code::incremental},
    {911, Code::relative_centre},
    {920, Code::alone},
    {921, Code::alone},
    {922, Code::alone},
    {923, Code::alone},
    {930, Code::inverse_time},
    {940, Code::per_minute},
    {950, Code::per_revolution},
    {960, Code::harmless},
    {970, Code::harmless},
    {980, Code::harmless},
    {990, Code::harmless},
};

const IsoRules kRules = {.dialect = "linuxcnc",
                         .harmless_letters = "DEHQSTPL",
                         .harmless_expressions = "SDPHQT",
                         .turns_letter = 'P',
                         .first_motion = 800};

class LinuxcncScanner : public IsoScanner {
 public:
  explicit LinuxcncScanner(const ScanSettings& settings) : IsoScanner(settings, kRules, kCodes) {}

 protected:
  void take_letter(const Token& token, IsoWords& words) override {
    if (token.letter == 'O') refuse("O word: subprograms and loops; post the program without them");
    IsoScanner::take_letter(token, words);
  }

  void take_expression(const Token& token, IsoWords& words) override {
    if (token.letter == 'O') refuse("O word: subprograms and loops; post the program without them");
    IsoScanner::take_expression(token, words);
  }

  /// Assignments are harmless as long as no word that moves uses them, but numbers from 5000 on are the control's own.
  void take_parameter(std::string_view text) override {
    const std::size_t digit = text.find_first_not_of(" \t", 1);
    if (digit != std::string_view::npos && text[digit] == '<') return;
    const auto number = scan_number(text.substr(std::min(digit, text.size())));
    if (!number || number->number.decimals != 0) refuse("# parameter by a computed number");
    if (number->number.mantissa > 5000 || number->number.mantissa < 1)
      refuse("#" + std::to_string(number->number.mantissa) +
             ": a parameter of the control itself, it may move its zero");
  }

  void take_m(int m, IsoWords& words) override {
    if (m == 6 || m == 61)
      words.tool_change = true;
    else if (m == 2 || m == 30)
      words.ends = words.stops = true;
    else if (m == 0 || m == 1 || m == 60)
      words.stops = true;
    else if (m == 98 || m == 99)
      refuse("M" + std::to_string(m) + ": subprogram call; post the program without it");
    else if (m >= 70 && m <= 73)
      refuse("M" + std::to_string(m) + ": saved and restored modes are not followed");
    else if (!((m >= 3 && m <= 9) || m == 19 || (m >= 48 && m <= 53) || (m >= 62 && m <= 68) || (m >= 100 && m <= 199)))
      refuse("M" + std::to_string(m) + " is not known to dialect linuxcnc");
  }

  bool take_block(IsoWords& words, ScannedChunk& chunk) override {
    const MotionBlock& block = move_.block;
    AxisValues& shift = state_.shift();
    switch (words.alone) {
      case 281:
      case 301:
        return true;
      case 431:
        state_.forget(only(2));
        return true;
      case 100:
        if (block.words > 0 || words.arc[3] != nullptr || !words.offset_letter)
          refuse("G10: sets offsets or tools while the program runs; give them in the job");
        return true;
      case 520:
        for (std::size_t i = 0; i < block.words; ++i) {
          const std::size_t axis = block.order[i];
          shift[axis] = state_.scale(axis) * block.word[axis].value.value();
        }
        return true;
      case 920:
        if (block.words == 0) bad("G92 without axis words");
        state_.set_position(move_, line_number(), chunk);
        return true;
      case 921:
        shift = stored_shift_ = {};
        return true;
      case 922:
        stored_shift_ = shift;
        shift = {};
        return true;
      case 923:
        shift = stored_shift_;
        return true;
      default:
        return false;
    }
  }

 private:
  AxisValues stored_shift_{};
};

}  // namespace
}  // namespace linuxcnc_words

std::unique_ptr<ProgramScanner> linuxcnc_scanner(const ScanSettings& settings) {
  using namespace linuxcnc_words;
  return std::make_unique<LinuxcncScanner>(settings);
}

}  // namespace trunnion
