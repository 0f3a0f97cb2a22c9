#include <Eigen/Geometry>
#include <algorithm>

#include "postproc/dialects/heidenhain_scanner.h"

// Blocks of Klartext that do not move: what they do to the state of the program.

namespace trunnion {
namespace {

/// Cycles that say nothing about the path, or wait for a call, which is refused: not those of patterns, probing,
/// calibration and tool measurement, which run where they are defined.
bool waits_for_its_call(std::int64_t cycle) {
  constexpr std::pair<int, int> kWaiting[] = {{1, 6},     {9, 9},     {13, 18},   {20, 25},   {27, 29},    {32, 32},
                                              {39, 39},   {200, 209}, {210, 215}, {225, 225}, {230, 233},  {240, 241},
                                              {251, 258}, {262, 267}, {270, 278}, {290, 292}, {1271, 1281}};
  return std::ranges::any_of(kWaiting, [&](const auto& r) { return cycle >= r.first && cycle <= r.second; });
}

}  // namespace

void HeidenhainScanner::begin_or_end(const KlartextLine& block) {
  const std::string text = block.text();
  if (block.function() == "END") {
    ended_ = true;
    return;
  }
  const std::size_t last = text.find_last_not_of(" \t\r\n");
  const std::string_view whole = std::string_view(text).substr(0, last + 1);
  state_.unit_mm = whole.ends_with(" INCH") ? kInch_mm : 1;
  if (!whole.ends_with(" INCH") && !whole.ends_with(" MM")) bad("BEGIN PGM that ends neither with MM nor with INCH");
}

void HeidenhainScanner::tool(const KlartextLine& block) {
  const std::string text = block.text();
  if (text.starts_with("TOOL DEF")) return;
  const std::size_t first = text.find_first_not_of(" \t", 9);
  const bool changed =
      first != std::string::npos && std::string_view("0123456789\"Q").find(text[first]) != std::string_view::npos;
  if (changed) state_.forget(kAllAxes);
  for (const Piece& piece : block.pieces()) {
    if (piece.name == "X") state_.plane = {1, 2, 0};
    if (piece.name == "Y") state_.plane = {2, 0, 1};
    if (piece.name == "Z") state_.plane = {0, 1, 2};
    if (piece.name == "F") {
      state_.feed = piece.number ? piece.place.value.value() : 0;
      state_.feed_unit_mm = feed_unit_mm();
    }
  }
}

void HeidenhainScanner::before_move(int m) {
  switch (m) {
    case 6:
      state_.forget(kAllAxes);
      break;
    case 89:
    case 99:
      (m == 99 ? refuse_move
               : refuse)("M" + std::to_string(m) + ": calls a cycle; post the program with its single moves");
      break;
    case 97:
      refuse_move("M97: corners of small steps are moved by the control; post the tool's centre path");
      break;
    case 98:
    case 120:
    case 144:
    case 114:
      refuse("M" + std::to_string(m) + ": the control moves the path by itself; post the program without it");
      break;
    case 130:
      refuse_move("M130: a move in untilted coordinates; post it outside the tilted plane");
      break;
    case 94:
      state_.reduce_turn();
      break;
    case 116:
      feed_on_circumference_ = true;
      state_.feed = 0;
      break;
    case 117:
      feed_on_circumference_ = false;
      break;
    case 126:
    case 127:
      state_.turn_shortest = m == 126;
      break;
    case 128:
    case 129:
      state_.turning = ToolTurning::axes;
      state_.set_tcp(m == 128, "M" + std::to_string(m));
      move_.block.changes_modes = true;
      break;
    case 136:
    case 137:
      state_.feed_mode = m == 136 ? FeedMode::per_revolution : FeedMode::per_minute;
      break;
    default:
      break;
  }
}

void HeidenhainScanner::behind_move(int m) {
  if (m == 140) state_.forget(kLinearAxes);
}

void HeidenhainScanner::miscellaneous(const KlartextLine& block) {
  bool ends = false;
  for (const Piece& piece : block.pieces()) {
    if (piece.name != "M" || !piece.number) continue;
    const int m = static_cast<int>(std::min<std::int64_t>(piece.place.value.mantissa, 9999));
    before_move(m);
    behind_move(m);
    ends |= m == 2 || m == 30;
  }
  ended_ = ends;
}

void HeidenhainScanner::assignment(const KlartextLine& block) {
  const Piece& piece = block.pieces().front();
  const std::int64_t number = piece.number ? piece.place.value.mantissa : -1;
  if (number >= 9 && number <= 12)
    refuse("FN " + std::to_string(number) + ": jumps are not followed; post the program without them");
  if (number == 17 || number == 25)
    refuse("FN " + std::to_string(number) + ": sets the control's own data, it may move its zero");
}

void HeidenhainScanner::special_function(const KlartextLine& block) {
  const std::string text = block.text();
  if (text.starts_with("FUNCTION TCPM")) {
    if (text.find("AXIS SPAT") != std::string::npos)
      refuse("FUNCTION TCPM AXIS SPAT: rotary words are spatial angles; post it with AXIS POS");
    if (text.find("TIP-CENTER") != std::string::npos)
      refuse("FUNCTION TCPM REFPNT TIP-CENTER: not the tip goes straight between blocks; post it with TIP-TIP");
    state_.turning = text.find("PATHCTRL VECTOR") != std::string::npos ? ToolTurning::great_circle : ToolTurning::axes;
    state_.set_tcp(true, "FUNCTION TCPM");
  } else if (text.starts_with("FUNCTION RESET TCPM")) {
    state_.set_tcp(false, "FUNCTION RESET TCPM");
  } else if (!text.starts_with("FUNCTION MODE MILL") && !text.starts_with("FUNCTION FEED") &&
             !text.starts_with("FUNCTION DWELL") && !text.starts_with("FUNCTION S-PULSE") &&
             !text.starts_with("FUNCTION CORRDATA RESET")) {
    refuse(text.substr(0, text.find_first_of(" \r\n", 9)) + " is not known to dialect heidenhain");
  }
}

double HeidenhainScanner::value(const KlartextLine& block, std::string_view name) const {
  for (const Piece& piece : block.pieces())
    if (piece.name == name) {
      if (!piece.number) refuse(std::string(name) + " is not followed by a plain number");
      return piece.place.value.value();
    }
  bad("PLANE without " + std::string(name));
}

void HeidenhainScanner::plane(const KlartextLine& block) {
  const auto says = [&](std::string_view name) {
    return std::ranges::any_of(block.pieces(), [&](const Piece& piece) { return piece.name == name; });
  };
  const bool stays = says("STAY");
  const auto turn = [](double degrees, int about) {
    return Eigen::AngleAxisd(Angle::degrees(degrees).in_radians(), Eigen::Vector3d::Unit(about)).toRotationMatrix();
  };
  if (says("RESET")) {
    state_.leave_plane();
    if (!stays) state_.forget(kRotaryAxes);
    return;
  }
  Eigen::Matrix3d rotation;
  if (says("SPATIAL")) {
    // About the fixed axes X, then Y, then Z.
    rotation = turn(value(block, "SPC"), 2) * turn(value(block, "SPB"), 1) * turn(value(block, "SPA"), 0);
  } else if (says("EULER")) {
    rotation = turn(value(block, "EULPR"), 2) * turn(value(block, "EULNU"), 0) * turn(value(block, "EULROT"), 2);
  } else {
    refuse("PLANE: the plane is told otherwise than by SPATIAL or EULER; post it so");
  }
  plane_sense_ = 0;
  for (const Piece& piece : block.pieces())
    if (piece.name == "SEQ" || piece.name == "SYM") plane_sense_ = piece.sign == '-' ? -1 : 1;
  state_.define_plane(rotation, Eigen::Vector3d::Zero(), "PLANE");
  if (!stays) state_.turn_to_plane("PLANE", plane_sense_);
}

void HeidenhainScanner::cycle(const KlartextLine& block) {
  const std::string text = block.text();
  if (!text.starts_with("CYCL DEF")) refuse_move("CYCL CALL: a canned cycle; post the program with its single moves");
  const std::size_t digit = text.find_first_not_of(" \t", 8);
  const auto number = scan_number(text.substr(std::min(digit, text.size())));
  if (!number) bad("CYCL DEF without a number");
  const std::int64_t which = number->number.mantissa / power_of_ten(number->number.decimals);
  const bool first = number->number.decimals == 0 || number->number.mantissa % 10 == 0;
  switch (which) {
    case 7:
      if (text.find('#') != std::string::npos) refuse("cycle 7 from a datum table; give the shift by its values");
      if (!first) take_shift(block);
      break;
    case 8:
      if (!first && block.pieces().size() > 2) refuse("cycle 8: mirrors the program; post it without");
      break;
    case 10:
    case 11:
    case 26:
      if (!first && !resets(block))
        refuse("cycle " + std::to_string(which) + ": mirrors, turns or scales the program; post it without");
      break;
    case 12:
      refuse("cycle 12: calls a program; post it without");
      break;
    case 19:
      if (!first && !resets(block)) refuse("cycle 19: post the tilted plane with PLANE SPATIAL");
      if (!first) state_.leave_plane();
      break;
    case 247:
      refuse("cycle 247: selects a datum while the program runs; give each its own program and job");
      break;
    default:
      if (!waits_for_its_call(which))
        refuse("cycle " + std::to_string(which) + ": runs where it is defined; post the program with its single moves");
  }
}

bool HeidenhainScanner::resets(const KlartextLine& block) {
  return std::ranges::all_of(block.pieces().subspan(2),
                             [](const Piece& piece) {
                               return !piece.variable &&
                                      (!piece.number || piece.place.value.mantissa == 0 || piece.name == "SCL");
                             }) &&
         std::ranges::none_of(
             block.pieces().subspan(2),
             [](const Piece& piece) { return piece.name == "SCL" && piece.place.value.value() != 1; }) &&
         block.pieces().size() > 0;
}

void HeidenhainScanner::take_shift(const KlartextLine& block) {
  for (const Piece& piece : block.pieces().subspan(1)) {
    const bool incremental = piece.name.size() == 2 && piece.name[0] == 'I';
    const auto axis = axis_of(incremental ? piece.name.substr(1) : piece.name);
    if (!axis) continue;
    if (!piece.number) refuse("cycle 7 with variables; give the shift by its values");
    double& shift = state_.shift()[*axis];
    const double by = state_.scale(*axis) * piece.place.value.value();
    shift = incremental ? shift + by : by;
  }
}

}  // namespace trunnion
