#pragma once

#include <string>
#include <string_view>

#include "kinematics/machine.h"
#include "postproc/correction.h"
#include "postproc/dialect.h"
#include "postproc/motion.h"

namespace trunnion {

/// What a correction did to a program, or to a part of it.
struct CorrectionCounts {
  std::uint64_t lines = 0;
  std::uint64_t corrected_blocks = 0;  ///< blocks that move and were corrected, changed or not
  std::uint64_t copied_moves = 0;      ///< blocks that move while an axis was not yet programmed, or no longer known
  std::uint64_t changed_words = 0;
  std::uint64_t added_words = 0;
  std::uint64_t inserted_blocks = 0;
  std::uint64_t beyond_tolerance = 0;     ///< blocks that the largest subdivision does not bring within tolerance
  double largest_deviation_mm = 0;        ///< |d| met
  double largest_tilt_rad = 0;            ///< rotation of the pose error met
  double largest_residual_rad = 0;        ///< tilt left near the singularity
  double largest_position_change_mm = 0;  ///< of X Y Z from one block's correction to the next's
  double largest_rotary_change_rad = 0;   ///< of A and C likewise
  double largest_c_correction_rad = 0;

  bool changed() const { return changed_words + added_words + inserted_blocks > 0; }
  CorrectionCounts& operator+=(const CorrectionCounts& other);
};

/// The machine's bounds on what may be corrected.
struct CorrectionGuard {
  CorrectionLimits limits;
  Length change = Length::micrometres(200);   ///< of the position's correction from one block at feed to the next
  Angle rotary_change = Angle::degrees(0.1);  ///< of A's and C's likewise
  std::array<std::optional<std::pair<double, double>>, kAxes> stroke;  ///< mm and deg, lowest and highest
  double tolerance_mm = 0.0002;                                        ///< of the tip between end points
  double tolerance_rad = 2e-6;                                         ///< of the tool axis between end points
  int most_pieces = 1000;                                              ///< of one line
  int most_arc_pieces = 20000;                                         ///< of one arc
};

/// Strokes and limits of a machine file.
CorrectionGuard guard_of(const Machine& machine);

/// Lines that were inserted behind a line of the original.
struct Insertion {
  std::uint64_t line = 0;
  std::uint32_t count = 0;
};

/// What one chunk of a program became.
struct CorrectedChunk {
  std::string text;
  CorrectionCounts counts;
  std::vector<Insertion> inserted;
  std::vector<Refusal> refusals;
};

/// Rewrites the words of scanned blocks. What it writes for a block depends on that block and on where the one before
/// left the machine, which it computes anew at the beginning of a chunk: chunks may be written in any order.
class ChunkWriter {
 public:
  /// The correctors for blocks with tool-centre-point control and without must outlive it.
  ChunkWriter(const Corrector& with_tcp, const Corrector& without_tcp, CorrectionGuard guard,
              std::array<char, kAxes> letters, DialectText text, bool keep_going)
      : with_tcp_(with_tcp),
        without_tcp_(without_tcp),
        guard_(guard),
        letters_(letters),
        text_(text),
        keep_going_(keep_going) {}

  /// The text of the chunk, corrected. Stops at the first block it refuses unless it is to keep going; then the block
  /// is copied.
  CorrectedChunk write(std::string_view text, const ScannedChunk& scanned);

 private:
  using Vector3 = Eigen::Vector3d;
  using Ticks = std::array<Decimal, kAxes>;  // a correction in program units, rounded as it is written
  /// The words of one block as written: the five axes, then the three of a tool axis told as a vector.
  static constexpr std::size_t kWords = kAxes + 3;
  using NewWords = std::array<std::optional<Decimal>, kWords>;

  /// The correction of one place.
  struct Solution {
    AxisValues programmed{};
    Commanded commanded;  // as written
    Ticks ticks{};
    Angle tilt_by, turn_by;  // what the words of the rotary axes are changed by
    Corrector::Linear linear;
    Angle residual;
  };
  /// What else of a block changes.
  struct NewFeed {
    std::optional<Decimal> word;          // F of every piece, or their time: it keeps the duration of a block
    bool timed = false;                   // the word is told as time; the old feed mode comes back behind the block
    bool lines_for_arc = false;           // the words of the arc go
    char arc_code = 0;                    // '1', '2' or '3' to stand in the block
    Vector3 centre_mm = Vector3::Zero();  // an arc that stays one is moved by this
  };
  /// The ends of the pieces into which a block is divided.
  struct Way {
    std::vector<Solution> ends;
    bool within_tolerance = true;
  };
  /// The state of a block's pieces while they are put into words.
  struct Pen {
    Ticks before{};                      // what the axes stood corrected by
    Ticks last{};                        // and behind the last piece
    const AxisValues* last_place;        // programmed
    bool lines = false;                  // a bent way that becomes lines: axes without words move as well
    std::array<Decimal, kAxes> moved{};  // what incremental words have said so far
  };

  const Corrector& corrector(const MotionBlock& block) const { return block.tcp ? with_tcp_ : without_tcp_; }
  Commanded commanded(const MotionBlock& block, const AxisValues& at) const;
  AxisValues place_between(const MotionBlock& block, const AxisValues& from, const AxisValues& to, double s) const;
  AxisValues on_way(const MotionBlock& block, double s) const;
  Commanded sent_between(const MotionBlock& block, const Commanded& from, const Commanded& to, double s) const;
  bool turns(const MotionBlock& block) const;
  void solve(const MotionBlock& block, const AxisValues& at, Solution& solution) const;
  Solution solved(const MotionBlock& block, const AxisValues& at) const;
  void check(const AxisValues& at, const Solution& solution) const;
  void check_change(const Solution& before, const Solution& now) const;
  double tilt_left_rad(const MotionBlock& block, const Commanded& wanted, const Commanded& sent) const;
  bool holds_between(const MotionBlock& block, const Solution& from, double from_part, const Solution& to,
                     double to_part, double& tip_mm, double& tilt_rad) const;
  std::optional<Vector3> moved_arc(const MotionBlock& block, const Ticks& before, const Solution& end) const;
  bool is_short(const MotionBlock& block) const;
  Way way(const MotionBlock& block, const Solution& end) const;
  NewWords words(const MotionBlock& block, const Solution& end, bool final, Pen& pen) const;
  void direction_words(const MotionBlock& block, const Solution& end, bool final, const Pen& pen,
                       NewWords& words) const;
  NewFeed new_feed(const MotionBlock& block, const Ticks& before, const Ticks& after, std::size_t pieces) const;
  Ticks ticks_before(const MotionBlock& block) const;
  void correct(const MotionBlock& block);
  void set_position(const MotionBlock& block);
  void count(const Solution& solution);

  void rewrite(const MotionBlock& block, const NewWords& words, const NewFeed& feed);
  bool rewrite_plainly(const MotionBlock& block, const Solution& end, const Ticks& before);
  void rewrite_numbers(const MotionBlock& block, const NewWords& words);
  void replace_number(const WordPlace& word, Decimal value);
  void add_words(const MotionBlock& block, const NewWords& words, const NewFeed& feed, bool all);
  void insert(const MotionBlock& block, const NewWords& words, const NewFeed& feed);
  void append_word(const MotionBlock& block, std::size_t slot, Decimal value, bool blank);
  void append_number_in(Decimal number, NumberStyle style);
  void append_feed(const MotionBlock& block, const NewFeed& feed, bool blank);
  void append_block_begin(const MotionBlock& block);
  const WordPlace* word_of(const MotionBlock& block, std::size_t slot) const;
  std::string arc_code(const MotionBlock& block, char digit) const;
  void copy_to(std::uint32_t place);
  void end_line(const MotionBlock& block);
  void restore_feed(const MotionBlock& block);
  void insert_line_end(const MotionBlock& block);

  const Corrector& with_tcp_;
  const Corrector& without_tcp_;
  CorrectionGuard guard_;
  std::array<char, kAxes> letters_;
  DialectText text_;
  bool keep_going_;

  std::string_view source_;
  std::uint32_t copied_ = 0;  // bytes of source_ that are in out_
  CorrectedChunk out_;
  Ticks ticks_{};  // what the axes stand corrected by
  double ticks_unit_mm_ = 1;
  std::optional<Solution> last_;  // of the block before
  bool lines_since_arc_ = false;  // the block before was an arc and left a straight move in force
};

}  // namespace trunnion
