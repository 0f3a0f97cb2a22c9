#include <Eigen/Geometry>
#include <cmath>

#include "postproc/dialects/dialects.h"
#include "postproc/iso_scanner.h"

namespace trunnion {
namespace fanuc_words {
namespace {

constexpr const char* kCycle = "a canned cycle; post the program with its single moves";
constexpr const char* kCurve = "curves are not corrected; post the program with lines and plane arcs";
constexpr const char* kMacro = "a macro call; post the program without it";
constexpr const char* kMapped = "coordinates are not those of the axes; post the program without it";
constexpr const char* kSkip = "the move ends where a signal comes, not where a program can say";
constexpr int kIncrement_metric = 3, kIncrement_inch = 4;  // decimals of the least input increment, IS-B

constexpr CodeEntry kCodes[] = {
    {0, Code::rapid},
    {10, Code::line},
    {20, Code::clockwise},
    {22, Code::other_motion, kCurve},
    {24, Code::other_motion, kCurve},
    {30, Code::counter_clockwise},
    {32, Code::other_motion, kCurve},
    {34, Code::other_motion, kCurve},
    {40, Code::dwell},
    {50, Code::taken_for_harmless},
    {51, Code::harmless},
    {54, Code::harmless},
    {62, Code::other_motion, kCurve},
    {71, Code::refused, kMapped},
    {80, Code::harmless},
    {90, Code::harmless},
    {100, Code::refused, "sets offsets, tools or parameters while the program runs; give them in the job"},
    {110, Code::harmless},
    {121, Code::refused, kMapped},
    {131, Code::harmless},
    {150, Code::harmless},
    {160, Code::refused, kMapped},
    {170, Code::plane_xy},
    {180, Code::plane_zx},
    {190, Code::plane_yz},
    {200, Code::inch},
    {210, Code::metric},
    {220, Code::harmless},
    {230, Code::harmless},
    {270, Code::home},
    {280, Code::home},
    {290, Code::home},
    {300, Code::home},
    {310, Code::refused, kSkip},
    {330, Code::other_motion, "spindle-synchronised motion"},
    {400, Code::cutter_off},
    {410, Code::cutter_on},
    {412, Code::cutter_on},
    {413, Code::cutter_on},
    {414, Code::cutter_on},
    {415, Code::cutter_on},
    {416, Code::cutter_on},
    {420, Code::cutter_on},
    {422, Code::cutter_on},
    {424, Code::cutter_on},
    {425, Code::cutter_on},
    {426, Code::cutter_on},
    {430, Code::special},
    {431, Code::refused,
     "tool length along a tilted tool without tool-centre-point control; post it with G43 or G43.4"},
    {434, Code::special},
    {435, Code::special},
    {440, Code::special},
    {450, Code::refused, "tool offsets along an axis are not followed"},
    {460, Code::refused, "tool offsets along an axis are not followed"},
    {470, Code::refused, "tool offsets along an axis are not followed"},
    {480, Code::refused, "tool offsets along an axis are not followed"},
    {490, Code::special},
    {500, Code::harmless},
    {501, Code::harmless},
    {510, Code::refused, kMapped},
    {511, Code::refused, kMapped},
    {520, Code::alone},
    {530, Code::machine_coordinates},
    {531, Code::special},
    {536, Code::special},
    {540, Code::special},
    {541, Code::special},
    {542, Code::refused,
     "a fixture offset that turns with the table moves the zero by itself; post the program without it"},
    {544, Code::refused, "the control turns the workpiece's frame by itself; post the program without it"},
    {550, Code::work_offset},
    {560, Code::work_offset},
    {570, Code::work_offset},
    {580, Code::work_offset},
    {590, Code::work_offset},
    {610, Code::harmless},
    {620, Code::harmless},
    {630, Code::harmless},
    {640, Code::harmless},
    {650, Code::refused, kMacro},
    {660, Code::refused, kMacro},
    {661, Code::refused, kMacro},
    {670, Code::harmless},
    {680, Code::refused, kMapped},
    {682, Code::alone},
    {683, Code::refused, "a plane from where the tool stands is not followed; post it with G68.2"},
    {684, Code::refused, "a plane told from another plane is not followed; post it with G68.2"},
    {690, Code::special},
    {730, Code::cycle, kCycle},
    {740, Code::cycle, kCycle},
    {760, Code::cycle, kCycle},
    {800, Code::cycle_end},
    {810, Code::cycle, kCycle},
    {820, Code::cycle, kCycle},
    {830, Code::cycle, kCycle},
    {840, Code::cycle, kCycle},
    {850, Code::cycle, kCycle},
    {860, Code::cycle, kCycle},
    {870, Code::cycle, kCycle},
    {880, Code::cycle, kCycle},
    {890, Code::cycle, kCycle},
    {900, Code::absolute},
    {910, Code::incremental},
    {920, Code::alone},
    {921, Code::alone},
    {930, Code::inverse_time},
    {940, Code::per_minute},
    {950, Code::per_revolution},
    {960, Code::harmless},
    {970, Code::harmless},
    {980, Code::harmless},
    {990, Code::harmless},
};

const IsoRules kRules = {.dialect = "fanuc",
                         .syntax = {.semicolon_ends_block = true},
                         .harmless_letters = "DEHQSTPL",
                         .harmless_expressions = "SDHQT",
                         .first_motion = 0,
                         .point_matters = true};

class FanucScanner : public IsoScanner {
 public:
  explicit FanucScanner(const ScanSettings& settings) : IsoScanner(settings, kRules, kCodes) {
    state_.turn_shortest = settings.control.turn_path != "as written";
    state_.turning = ToolTurning::axes;
  }

 protected:
  bool take_other(std::string_view text) override { return text[0] == '<' || text[0] == ':'; }

  void take_letter(const Token& token, IsoWords& words) override {
    if (token.letter == 'O') return;  // the program's name
    IsoScanner::take_letter(token, words);
  }

  void take_expression(const Token& token, IsoWords& words) override {
    static constexpr std::string_view kFlow = "DEGIPTW";  // DO END GOTO IF POPEN THEN WHILE
    if (kFlow.find(token.letter) != std::string_view::npos && !axis_of(token.letter))
      refuse("a macro statement; post the program without macros");
    IsoScanner::take_expression(token, words);
  }

  /// Common variables do no harm as long as no word that moves uses them; those from #1000 on are the control's own.
  void take_parameter(std::string_view text) override {
    const auto number = scan_number(text.substr(1));
    if (!number || number->number.decimals != 0 || number->number.mantissa >= 1000 || number->number.mantissa < 1)
      refuse("a variable of the control itself, or a computed one, is set: it may move the zero");
  }

  void take_m(int m, IsoWords& words) override {
    if (m == 6) words.tool_change = true;
    if (m == 2 || m == 30) words.ends = true;
    words.stops |= m == 0 || m == 1 || m == 2 || m == 30;
    if (m == 98 || m == 198) refuse("M" + std::to_string(m) + ": subprogram call; post the program without it");
    if (m == 99) refuse("M99: the end of a subprogram; correct the program that calls it, posted without the call");
  }

  Decimal value_of(const Token& token, std::size_t) const override {
    if (token.style.point || token.value.mantissa == 0) return token.value;
    const std::string& whole = settings().control.whole_numbers;
    if (whole == "units") return token.value;
    const std::string found = std::string(1, token.letter) + std::to_string(token.value.mantissa);
    if (whole == "ask")
      refuse_move(
          found + " has no point: whether it is " + std::to_string(token.value.mantissa) +
          " mm or so many increments is up to parameter 3401 bit 0; say whole_numbers = \"units\" or \"increments\" "
          "under [control] of the machine file");
    return {token.value.mantissa, state_.unit_mm == 1 ? kIncrement_metric : kIncrement_inch};
  }

  void take_code(int g, IsoWords& words) override {
    const std::string name = code_name('G', g);
    switch (g) {
      case 434:
      case 435:
        if (g == 435 && settings().control.tcp_frame == "fixed")
          refuse("G43.5 where the frame of tool-centre-point control does not turn with the table");
        state_.set_tcp(true, name);
        vectors_ = g == 435;
        break;
      case 430:
      case 440:
      case 490:
        state_.set_tcp(false, name);
        vectors_ = false;
        break;
      case 531:
      case 536:
        state_.turn_to_plane(name);
        return;
      case 540:
      case 541:
        take_offset(name, words);
        return;
      case 690:
        state_.leave_plane();
        return;
      default:
        return;
    }
    // Tool lengths change here.
    state_.forget(only(2));
    words.changes_modes = true;
  }

  bool take_block(IsoWords& words, ScannedChunk& chunk) override {
    const MotionBlock& block = move_.block;
    switch (words.alone) {
      case 520:
        if (state_.in_plane()) refuse("G52 in a tilted plane");
        for (std::size_t i = 0; i < block.words; ++i) {
          const std::size_t axis = block.order[i];
          state_.shift()[axis] = state_.scale(axis) * block.word[axis].value.value();
        }
        return true;
      case 682:
        define_plane(words);
        return true;
      case 920:
        if (block.words == 0) bad("G92 without axis words");
        state_.set_position(move_, line_number(), chunk);
        return true;
      case 921:
        if (state_.in_plane()) refuse("G92.1 in a tilted plane");
        state_.shift() = {};
        return true;
      default:
        break;
    }
    if (words.dwell) return true;  // X is a time there
    if (vectors_ && words.has_centre()) take_direction(words);
    return false;
  }

 private:
  /// G54, or G54.1 P1 and its like.
  void take_offset(const std::string& name, IsoWords& words) {
    const Token* which = words.arc[4];
    if (which == nullptr) {
      if (name == "G54.1") bad("G54.1 without P");
      state_.select_offset("G54");
    } else {
      if (which->value.decimals != 0 || which->value.mantissa < 1 || which->value.mantissa > 300)
        bad(name + ": P from 1 to 300 is wanted");
      state_.select_offset("G54.1P" + std::to_string(which->value.mantissa));
    }
    words.changes_modes = true;
  }

  double number(const Token* token, const char* wanted) const {
    if (token == nullptr) bad(wanted);
    return value_of(*token, 0).value();
  }

  /// G68.2 X Y Z I J K: the plane's zero, and its axes by Euler's angles about Z, X and Z, each as the one before left
  /// it.
  void define_plane(const IsoWords& words) {
    constexpr const char* wanted = "G68.2 wants X Y Z and I J K";
    if (words.arc[4] != nullptr && words.arc[4]->value.mantissa != 0)
      refuse("G68.2 P" + std::to_string(words.arc[4]->value.mantissa) +
             ": the plane is told otherwise than by Euler's angles; post it with P0");
    if (words.arc[3] != nullptr)
      refuse("G68.2 with R: an axis I J K and a turn about it, not Euler's angles; post it with three angles");
    Eigen::Vector3d origin, angle_rad;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Index axis = static_cast<Eigen::Index>(i);
      if (!holds(move_.block.programmed, i)) bad(wanted);
      origin[axis] = state_.unit_mm * move_.block.word[i].value.value();
      angle_rad[axis] = Angle::degrees(number(words.arc[i], wanted)).in_radians();
    }
    using Turn = Eigen::AngleAxisd;
    const Eigen::Matrix3d rotation =
        (Turn(angle_rad[0], Eigen::Vector3d::UnitZ()) * Turn(angle_rad[1], Eigen::Vector3d::UnitX()) *
         Turn(angle_rad[2], Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    state_.define_plane(rotation, origin, "G68.2");
  }

  /// I J K of a line under G43.5.
  void take_direction(const IsoWords& words) {
    if (words.motion >= 20 || arc_mode())
      refuse_move("an arc under G43.5, whose I J K are the tool's axis; post it with lines");
    for (std::size_t i = 0; i < 3; ++i)
      if (words.arc[i] == nullptr) bad("I, J and K of a tool axis stand together");
    std::array<WordPlace, 3> direction;
    Eigen::Vector3d axis;
    for (std::size_t i = 0; i < 3; ++i) {
      direction[i] = place(*words.arc[i]);
      direction[i].style.point = true;
      axis[static_cast<Eigen::Index>(i)] = direction[i].value.value();
    }
    if ((move_.block.programmed & kRotaryAxes) != 0) bad("a tool axis and a rotary axis in one block");
    move_.tool_axis = axis;
    move_.has_extras = true;
    move_.extras.direction = direction;
  }

  bool vectors_ = false;  // G43.5
};

}  // namespace
}  // namespace fanuc_words

std::unique_ptr<ProgramScanner> fanuc_scanner(const ScanSettings& settings) {
  using namespace fanuc_words;
  return std::make_unique<FanucScanner>(settings);
}

}  // namespace trunnion
