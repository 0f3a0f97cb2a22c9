#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/kinematic_chain.h"
#include "postproc/number.h"

namespace trunnion {

/// The five axes of a program in the order of every array here: X, Y, Z, the tilting axis (A or B), C.
inline constexpr std::size_t kAxes = 5;
inline constexpr std::size_t kTilt = 3;
inline constexpr std::size_t kTurn = 4;
/// Positions: mm for X Y Z, degrees as commanded for the rotary axes, so that the text's digits stay what they are.
using AxisValues = std::array<double, kAxes>;

/// Which of the five axes: bit i for axis i.
using AxisSet = std::uint8_t;
inline constexpr AxisSet kAllAxes = 0b11111;
inline constexpr AxisSet kLinearAxes = 0b00111;
inline constexpr AxisSet kRotaryAxes = 0b11000;
constexpr bool holds(AxisSet set, std::size_t axis) { return (set >> axis & 1) != 0; }
constexpr AxisSet only(std::size_t axis) { return static_cast<AxisSet>(1u << axis); }

/// A word of the text, by its bytes, X=IC(2), IY+3.
struct WordPlace {
  std::uint32_t text = 0;    ///< its first letter
  std::uint32_t number = 0;  ///< first byte of its number
  std::uint32_t number_end = 0;
  std::uint32_t end = 0;  ///< behind the word
  Decimal value;
  NumberStyle style;
};

/// What a block does to the position, and how it is corrected.
enum class BlockKind : std::uint8_t {
  rapid,         ///< corrected at its end
  feed,          ///< a line or an arc: corrected along its way
  set_position,  ///< G92: the words say where the machine stands, and it stands corrected
};
enum class FeedMode : std::uint8_t { per_minute, inverse_time, per_revolution };
/// How the tool turns on its way from one orientation to the next under tool-centre-point control.
enum class ToolTurning : std::uint8_t {
  axes,          ///< the rotary axes go in proportion
  great_circle,  ///< the tool axis goes in one plane, at one rate
  not_told,
};

/// The circular part of a move, in mm of the program's frame: after the part s of the way the tip is at
///   centre + (1 + s growth) (cos(s sweep) along + sin(s sweep) across) + s rise,
/// the rotary axes in proportion.
struct Arc {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();   ///< from the centre to the begin
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< a quarter turn further, as long
  Eigen::Vector3d rise = Eigen::Vector3d::Zero();
  double sweep_rad = 0;  ///< signed, whole turns included
  double growth = 0;     ///< of the radius from begin to end: what the program's rounding leaves
};

/// Where X Y Z of a program stand when they are not parallel to the axes of W or R: p = origin + rotation XYZ.
struct ProgramFrame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
};

/// A word that makes an arc of its block: it goes where the arc becomes lines, and follows where the arc is moved.
struct ArcWord {
  WordPlace word;
  enum class Tells : std::uint8_t {
    nothing_moved,  ///< a radius, turns, a sense; a point told from the begin
    centre,         ///< of `axis`, from the program's zero
    centre_from_begin,
    point,  ///< a place of `axis` that is corrected like the end
  } tells = Tells::nothing_moved;
  std::uint8_t axis = 0;
};

/// A word by its bytes alone.
struct TextPlace {
  std::uint32_t text = 0, end = 0;
  bool stands() const { return end != 0; }
};

/// What few blocks have.
struct BlockExtras {
  std::optional<Arc> arc;
  std::string_view arc_name;          ///< its code where it is neither G2 nor G3
  bool arc_movable = false;           ///< the block itself says where it is
  std::vector<ArcWord> arc_word;      ///< I J K R P CR= DR- ...
  TextPlace feed_mode_word;           ///< G93, G94 or G95 where the block says it
  std::optional<ProgramFrame> frame;  ///< in W with tcp, else in R
  /// The tool axis told as a vector: its words, in the program's frame.
  std::optional<std::array<WordPlace, 3>> direction;
  std::string_view undividable;      ///< what would be lost if the block were divided
  bool direction_in_effect = false;  ///< the program tells the tool axis by vectors; this block need not
};

/// What a block says of itself beside places and numbers.
struct BlockFacts {
  std::uint64_t line = 0;   ///< counted from 1
  std::uint32_t begin = 0;  ///< first byte of its line
  std::uint32_t end = 0;    ///< behind its line end
  BlockKind kind = BlockKind::rapid;
  AxisSet programmed = 0;                   ///< axes that have a word
  AxisSet incremental = 0;                  ///< axes whose words count, or would count, from the place before
  AxisSet wrapped = 0;                      ///< axes whose word says itself how it counts: X=IC(2), IX+2
  AxisSet in_turn = 0;                      ///< rotary axes whose words are to stay within 0 ... 360 deg
  std::array<std::uint8_t, kAxes> order{};  ///< the programmed axes as they stand in the text
  std::uint8_t words = 0;                   ///< how many
  bool tcp = true;                          ///< X Y Z turn with the table
  bool straight_on_part = false;  ///< without tcp: between its ends the tip goes straight on the part all the same
  bool cutter = false;            ///< cutter radius compensation is active
  ToolTurning turning = ToolTurning::axes;
  bool rotary_fixed = false;  ///< the control positions the rotary axes by itself: they get no words
  bool from_known = false;
  bool blank_before_words = true;  ///< how words are set apart
  bool stops = false;              ///< a program stop or end stands in the block
  bool changes_modes = false;      ///< it says more than motion, feed and words: units, offsets, distance mode
  AxisSet raw_since = 0;           ///< axes that copied blocks have put elsewhere since the last corrected block
  std::int8_t tilt_sense = 1, turn_sense = 1;
  std::array<std::int8_t, 3> linear_sense{};  ///< of the slides' last motions, 0: not known; if the scan follows them
  AxisSet turns_round = 0;                    ///< slides that turn round between the block's ends; likewise
  double time_s = 0;                          ///< at feed since the program's begin; if the scan follows it
  FeedMode feed_mode = FeedMode::per_minute;
  double unit_mm = 1;
  double feed = 0;          ///< as programmed, in the units of its own block; 0: not known
  double feed_unit_mm = 1;  ///< what that unit is
  TextPlace motion_word;    ///< G1, G2, L, C ... where the block says it
};

/// A block whose words a correction may change, as the serial scan of a program found it; nothing else of the text
/// matters to a correction. Places count from the beginning of the chunk.
struct MotionBlock : BlockFacts {
  std::array<std::uint8_t, kAxes> decimals{};  ///< of what is written
  std::array<NumberStyle, kAxes> style{};      ///< of words that are added
  std::array<WordPlace, kAxes> word{};         ///< by axis, those that are programmed
  WordPlace feed_word;                         ///< where the block says F: else its end is 0
  AxisValues from{};                           ///< where the programmed path begins; holds if from_known
  AxisValues target{};                         ///< where it ends: program value times unit plus zero
  AxisValues zero{};                           ///< work offset and shifts, mm or deg
  std::shared_ptr<const BlockExtras> extras;   ///< none for most

  /// To be filled anew: numbers that nothing tells to hold keep what they were.
  void clear() {
    static_cast<BlockFacts&>(*this) = {};
    feed_word.end = 0;
    extras.reset();
  }

  const Arc* arc() const { return extras && extras->arc ? &*extras->arc : nullptr; }
  const ProgramFrame* frame() const { return extras && extras->frame ? &*extras->frame : nullptr; }
  bool has_feed_word() const { return feed_word.end != 0; }
};

/// All axes in proportion after the part `s` of a way.
AxisValues between(const AxisValues& from, const AxisValues& to, double s);
/// `at` with X Y Z where an arc is after the part `s` of its way; none: as they are.
AxisValues with_arc(const Arc* arc, AxisValues at, double s);

/// A block that must not be corrected, or cannot be: what stands there and why, for a person.
struct Refusal {
  std::uint64_t line = 0;
  std::string reason;
  enum class Kind {
    refused,
    out_of_range,
    bad_input,
    for_good,  ///< refused even where refused blocks are to be copied
  } kind = Kind::refused;
  /// How the scan goes on behind the block where it is copied.
  enum class Behind : std::uint8_t {
    known,         ///< the machine stands where the block says, uncorrected
    axes_unknown,  ///< until they are programmed again
    copied,        ///< the rest of the program is copied
  } behind = Behind::known;
};

/// What was taken for granted of a control that nobody has confirmed, where a program makes use of it: bit i for the
/// i-th of Assumption (docs/dialects.md).
enum class Assumption : std::uint8_t {
  feed_in_tenths_of_inch,
  great_circle,
  feed_over_all_axes,
  offset_without_words,
  time_of_one_block,
  shared_block_numbers,
  high_speed_by_number,
};
inline constexpr std::size_t kAssumptions = 7;
using Assumptions = std::uint8_t;
constexpr Assumptions only(Assumption one) { return static_cast<Assumptions>(1u << static_cast<unsigned>(one)); }

/// What one chunk of a program holds for the corrector.
struct ScannedChunk {
  std::optional<MotionBlock> before;  ///< the last corrected block before the chunk
  std::vector<MotionBlock> blocks;
  std::vector<Refusal> refusals;  ///< ascending lines, of what the scan refused
  std::uint64_t lines = 0;
  std::uint64_t copied_moves = 0;        ///< blocks that move while not all five axes are known
  std::uint64_t untimed_moves = 0;       ///< whose duration is not known, where the scan follows the time
  std::uint64_t first_untimed_line = 0;  ///< the first of them
  Assumptions assumptions = 0;
};

/// What programs of a control mean where that depends on the control's own parameters (machine file: [control]).
struct ControlFacts {
  /// Where the frame of tool-centre-point control stands: on the table as it lies at zero ("zero"), as it lies where
  /// the control is switched on ("start"), or beside the table, not turning with it ("fixed").
  std::string tcp_frame = "zero";
  std::string whole_numbers = "ask";  ///< what X10 without a point is: "units", "increments", or refused: "ask"
  std::string turn_path = "dialect";  ///< how an absolute C is reached: "shortest", "as written", the dialect's default
  /// How the tool turns between two axes told as vectors where the program does not say: "axes", "great circle", "ask".
  std::string orientation_path = "ask";
};

/// What a scan is told about program and machine.
struct ScanSettings {
  std::array<char, kAxes> letters = {'X', 'Y', 'Z', 'A', 'C'};
  std::map<std::string, std::array<double, 3>> work_offsets_mm;  ///< by code: "G54"; empty: all zero
  int decimals = 4;  ///< least decimals of what is written, mm and degrees; inches get two more
  bool tcp = true;   ///< forced, or what the machine file says where the program does not
  bool tcp_forced = false;
  bool keep_going = false;                ///< copy refused blocks and go on
  ControlFacts control;                   ///< what the machine file says of its control
  bool modulo_turn = true;                ///< 0 and 360 deg of C are one place
  const KinematicChain* chain = nullptr;  ///< for tool axes told as vectors and tilted planes; must outlive the scan
  std::optional<std::pair<double, double>> tilt_stroke_deg;  ///< of the tilting axis
  bool follow_senses = false;                                ///< of X Y Z, where errors depend on them
  bool follow_time = false;                                  ///< likewise
  double tool_length_mm = 0;                                 ///< matters where the slides' senses are followed
};

/// The serial pass over a program: follows the modal state of one dialect and tells which words a correction may
/// change. It sees every line once, in order.
class ProgramScanner {
 public:
  virtual ~ProgramScanner() = default;
  /// Takes the next line, its line end included, which begins at byte `begin` of its chunk. False once a refusal or the
  /// settings ask for no more.
  virtual bool scan(std::string_view line, std::uint32_t begin, ScannedChunk& chunk) = 0;
};

/// What a corrected program carries in its header comment; finding it again means: corrected already.
inline constexpr std::string_view kCorrectedMark = "corrected by trunnion";

}  // namespace trunnion
