#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "postproc/motion.h"
#include "postproc/slide_senses.h"
#include "postproc/tool_axis.h"

namespace trunnion {

inline constexpr double kInch_mm = 25.4;
inline constexpr double kFarthest =
    1e6;  ///< mm, inch or degrees: beyond any machine, within exact arithmetic of digits

inline constexpr double kFastest = 1e9;  ///< of F

/// Thrown inside one line, told with its number by the scan.
struct LineRefused {
  std::string reason;
  Refusal::Kind kind = Refusal::Kind::refused;
  bool lasting = false;  ///< what follows in the program cannot be followed either
};
/// For what changes the state of the program in a way that is not followed.
[[noreturn]] void refuse(const std::string& what);
/// For what moves the tool, but leaves modes and zeros as they are: the program is known again with its axes.
[[noreturn]] void refuse_move(const std::string& what);
/// For what is no block of the dialect at all (InputError).
[[noreturn]] void bad(const std::string& what);

/// Behind the reason of a lasting refusal that is passed over.
inline constexpr const char* kCopiedToEnd = "; from here on the program is copied";

/// Where a text says that a program was corrected; npos: nowhere.
std::size_t find_mark(std::string_view text);
/// Whether a comment says that the program was corrected.
bool contains_mark(std::string_view comment);
/// For a program that was corrected before: it would be corrected twice.
[[noreturn]] void refuse_corrected();

/// How a block tells its arc; lengths in mm.
struct ArcTold {
  int sense = 0;  ///< 1 counter-clockwise seen against the plane's third axis, -1 clockwise
  std::array<std::optional<double>, 3> centre;  ///< by axis, from the begin unless absolute
  AxisSet centre_absolute = 0;
  std::optional<double> radius_mm;               ///< negative: more than half a turn
  std::optional<std::array<double, 3>> through;  ///< a point on the way, in the program's frame without zero
  bool tangent = false;                          ///< goes on from the move before without a corner
  std::optional<double> sweep_rad;               ///< the arc's own angle, where it is told
  std::optional<int> turns;                      ///< whole turns more
};

/// One block that moves, as a dialect reads it. The dialect fills the word places and flags of `block` and `extras`;
/// ProgramState does the rest.
struct Move {
  enum class Kind { rapid, line, arc } kind = Kind::rapid;
  MotionBlock block;
  BlockExtras extras;
  bool has_extras = false;
  AxisSet shortest = 0;             ///< rotary axes whose words ask for the shorter way: DC()
  AxisSet explicit_increments = 0;  ///< words that count from the place before whatever the mode, part of block.wrapped
  ArcTold arc;
  std::array<std::optional<double>, 3> computed;  ///< mm, places of axes without words, the program's zero not added
  std::optional<Eigen::Vector3d> tool_axis;       ///< told as a vector, in the program's frame

  void clear();
  /// The word of an axis; throws for a second one.
  void add(std::size_t axis, const WordPlace& word, char letter);
};

/// Where a program has brought the machine and in which state: what all dialects have in common. Dialects set the modes
/// and hand over blocks that move.
class ProgramState {
 public:
  explicit ProgramState(const ScanSettings& settings);

  // Modes.
  double unit_mm = 1;
  bool incremental = false;
  std::array<std::uint8_t, 3> plane{0, 1, 2};  ///< first, second and third axis
  std::string_view cutter;                     ///< what switched cutter radius compensation on; empty: off
  FeedMode feed_mode = FeedMode::per_minute;
  double feed = 0;  ///< 0: not known
  double feed_unit_mm = 1;
  bool turn_shortest = false;          ///< an absolute C is reached the shorter way
  std::optional<ToolTurning> turning;  ///< none: as the machine file says

  const AxisValues& at() const { return at_; }
  bool knows(std::size_t axis) const { return holds(known_, axis); }
  bool tcp() const { return tcp_; }
  double zero_of(std::size_t axis) { return zero(axis); }  ///< mm or deg: a program's 0 in the coordinates of at()
  double scale(std::size_t axis) const { return axis < 3 ? unit_mm : 1; }

  /// Axes that go where the program does not say.
  void forget(AxisSet axes) { known_ &= static_cast<AxisSet>(~axes); }

  void select_offset(std::string code);
  AxisValues& shift();  ///< of the program's zero; throws for a plane that was defined but not turned to
  const std::string& offset() const { return system_; }
  /// Tool-centre-point control as the program says, unless it is forced. `name` for messages.
  void set_tcp(bool on, const std::string& name);
  /// A tilted plane in W: p = zero + origin + rotation XYZ. Moves wait until the tool stands across it.
  void define_plane(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& origin_mm, const std::string& name);
  /// The control turns the tool across the plane.
  /// Of two ways that with a tilt of the sign of `sense`, unless that is 0.
  void turn_to_plane(const std::string& name, int sense = 0);
  void leave_plane();
  bool plane_waits() const { return !plane_waits_.empty(); }
  /// C counts anew from 0 ... 360 deg.
  void reduce_turn();
  bool in_plane() const { return plane_frame_.has_value(); }

  /// G92: the words of `move` say where the machine stands.
  void set_position(Move& move, std::uint64_t line, ScannedChunk& chunk);
  /// A block that moves: adds it to `chunk`, or to those that are copied because an axis is not known.
  void move(Move& move, std::uint64_t line, ScannedChunk& chunk);

 private:
  double work_zero(std::size_t axis);
  double zero(std::size_t axis);
  AxisSet counting(const Move& move) const;
  void place_words(const Move& move);
  void take_tool_axis(const Move& move);
  std::vector<AxisSolution> reachable(const Eigen::Vector3d& axis_w, const std::string& name) const;
  void stand_at(const AxisSolution& solution);
  const ProgramFrame* frame() const;
  void new_frame();
  Arc arc(const Move& move, const AxisValues& from);
  ToolTurning turning_now() const;
  void describe(Move& move, std::uint64_t line);

  ScanSettings settings_;
  bool tcp_;
  std::string system_ = "G54";
  bool offset_known_ = false;
  std::array<double, 3> offset_{};
  AxisValues shift_{}, shift_outside_{};
  std::optional<ProgramFrame> tcp_frame_;          // of tool-centre-point control that began at a turned table
  std::optional<ProgramFrame> plane_frame_;        // a tilted plane
  std::string plane_waits_;                        // its name while the tool does not stand across it
  std::shared_ptr<const BlockExtras> frame_only_;  // of blocks that have nothing else
  bool axis_by_vectors_ = false;

  AxisValues at_{};  // where the program has brought the axes, zero included
  AxisSet known_ = 0;
  AxisSet raw_since_ = 0;
  double turns_deg_ = 0;  // whole turns by which C stands from where its words say
  AxisSet in_turn_ = 0;   // rotary axes whose last word is within 0 ... 360 deg
  std::array<NumberStyle, kAxes> style_{};
  std::optional<Eigen::Vector3d> tangent_;  // of the move before, at its end
  std::int8_t tilt_sense_ = 1, turn_sense_ = 1;
  std::optional<SlideSenses> slides_;
  double time_s_ = 0;  // at feed
};

}  // namespace trunnion
