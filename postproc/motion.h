#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "postproc/block.h"

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
constexpr bool holds(AxisSet set, std::size_t axis) { return (set >> axis & 1) != 0; }
constexpr AxisSet only(std::size_t axis) { return static_cast<AxisSet>(1u << axis); }

/// A word of the text, by its bytes.
struct WordPlace {
  std::uint32_t text = 0;  ///< its letter
  std::uint32_t end = 0;
  Decimal number;
  NumberStyle style;
};

enum class BlockKind : std::uint8_t {
  rapid,         ///< G0: corrected at its end
  feed,          ///< G1, or an arc: corrected along its way
  set_position,  ///< G92: the words say where the machine stands, and it stands corrected
};
enum class FeedMode : std::uint8_t { per_minute, inverse_time, per_revolution };

/// The circular part of a move: two axes turn about a centre, the third and the rotary axes go along in proportion.
struct Arc {
  std::uint8_t first = 0, second = 1;          ///< axes of the plane, from first to second is positive
  double centre_first = 0, centre_second = 0;  ///< mm, zero included
  double sweep_rad = 0;                        ///< signed, whole turns included
};

/// A block whose words a correction may change, as the serial scan of a program found it; nothing else of the text
/// matters to a correction. Places count from the beginning of the chunk.
struct MotionBlock {
  std::uint64_t line = 0;   ///< counted from 1
  std::uint32_t begin = 0;  ///< first byte of its line
  std::uint32_t end = 0;    ///< behind its line end
  BlockKind kind = BlockKind::rapid;
  bool incremental = false;
  bool tcp = true;                          ///< X Y Z turn with the table
  AxisSet programmed = 0;                   ///< axes that have a word
  std::array<std::uint8_t, kAxes> order{};  ///< the programmed axes as they stand in the text
  std::uint8_t words = 0;                   ///< how many
  std::array<WordPlace, kAxes> word{};      ///< by axis
  AxisValues from{};                        ///< where the programmed path begins; holds if from_known
  AxisValues target{};                      ///< where it ends: program value times unit plus zero
  AxisValues zero{};                        ///< work offset and shifts, mm or deg
  double unit_mm = 1;
  bool from_known = false;
  std::array<std::uint8_t, kAxes> decimals{};  ///< of what is written
  std::array<NumberStyle, kAxes> style{};      ///< of words that are added
  bool blank_before_words = false;             ///< how words are set apart
  AxisSet raw_since = 0;  ///< axes that copied blocks have put elsewhere since the last corrected block
  int tilt_sense = 1, turn_sense = 1;
  FeedMode feed_mode = FeedMode::per_minute;
  std::optional<WordPlace> feed_word;
  std::optional<WordPlace> feed_mode_word;  ///< G93, G94 or G95 where the block says it
  double feed = 0;                          ///< as programmed, in the units of its own block; 0: not known
  double feed_unit_mm = 1;                  ///< what that unit is
  std::optional<Arc> arc;
  bool arc_movable = false;              ///< its centre is told from its begin, or by a radius
  std::optional<WordPlace> motion_word;  ///< G1, G2 ... where the block says it
  std::array<WordPlace, 5> arc_word{};   ///< I J K R P
  std::uint8_t arc_words = 0;
  bool stops = false;          ///< an M0, M1, M2, M30 or M60 stands in the block
  bool changes_modes = false;  ///< it says more than motion, feed and words: units, offsets, distance mode
};

/// A block that must not be corrected, or cannot be: what stands there and why, for a person.
struct Refusal {
  std::uint64_t line = 0;
  std::string reason;
  enum class Kind { refused, out_of_range, bad_input } kind = Kind::refused;
};

/// What one chunk of a program holds for the corrector.
struct ScannedChunk {
  std::optional<MotionBlock> before;  ///< the last corrected block before the chunk
  std::vector<MotionBlock> blocks;
  std::vector<Refusal> refusals;  ///< ascending lines, of what the scan refused
  std::uint64_t lines = 0;
  std::uint64_t copied_moves = 0;  ///< blocks that move while not all five axes are known
};

/// What a scan is told about program and machine.
struct ScanSettings {
  std::array<char, kAxes> letters = {'X', 'Y', 'Z', 'A', 'C'};
  std::map<std::string, std::array<double, 3>> work_offsets_mm;  ///< by code: "G54"; empty: all zero
  int decimals = 4;  ///< least decimals of what is written, mm and degrees; inches get two more
  bool tcp = true;   ///< forced, or what the machine file says where the program does not
  bool tcp_forced = false;
  bool keep_going = false;  ///< copy refused blocks and go on
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

/// How a dialect writes what a correction inserts.
struct DialectText {
  std::string_view comment_open = "(";
  std::string_view comment_close = ")";
};

/// What a corrected program carries in its header comment; finding it again means: corrected already.
inline constexpr std::string_view kCorrectedMark = "corrected by trunnion";

}  // namespace trunnion
