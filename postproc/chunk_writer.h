#pragma once

#include <string>
#include <string_view>

#include "kinematics/machine.h"
#include "postproc/correction.h"
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
              std::array<char, kAxes> letters, bool keep_going)
      : with_tcp_(with_tcp), without_tcp_(without_tcp), guard_(guard), letters_(letters), keep_going_(keep_going) {}

  /// The text of the chunk, corrected. Stops at the first block it refuses unless it is to keep going; then the block
  /// is copied.
  CorrectedChunk write(std::string_view text, const ScannedChunk& scanned);

 private:
  using Ticks = std::array<Decimal, kAxes>;  // a correction in program units, rounded as it is written
  using NewWords = std::array<std::optional<Decimal>, kAxes>;

  /// The correction of one place.
  struct Solution {
    AxisValues programmed{};
    Commanded commanded;  // as written
    Ticks ticks{};
    Corrector::Linear linear;
    Angle residual;
  };
  /// One block of what is written for a programmed one.
  struct Piece {
    Solution end;
    NewWords words;
  };
  /// What else of a block changes: it keeps the duration of a block that a correction would change.
  struct NewFeed {
    std::optional<Decimal> word;          // F of every piece
    bool inverse_time_meanwhile = false;  // G93, and G94 with the old F behind it
    bool lines_for_arc = false;           // I J K R P go
    int arc_code = 0;                     // G1, G2 or G3 to stand in the block
  };
  /// The ends of the pieces into which a block is divided.
  struct Way {
    std::vector<Solution> ends;
    bool arc = false;  // it stays an arc
    bool within_tolerance = true;
  };

  const Corrector& corrector(const MotionBlock& block) const { return block.tcp ? with_tcp_ : without_tcp_; }
  Solution solve(const MotionBlock& block, const AxisValues& at) const;
  void check(const AxisValues& at, const Solution& solution) const;
  bool holds_between(const MotionBlock& block, const Solution& from, double from_part, const Solution& to,
                     double to_part, double& tip_mm, double& tilt_rad) const;
  bool stays_an_arc(const MotionBlock& block, const Solution& begin, const Solution& end) const;
  bool bends_less(const MotionBlock& block, const Solution& begin, const Solution& end) const;
  Way way(const MotionBlock& block, const Solution& end) const;
  std::vector<Piece> pieces(const MotionBlock& block, const std::vector<Solution>& way, const Ticks& before) const;
  NewFeed new_feed(const MotionBlock& block, const Ticks& before, const Ticks& after, std::size_t pieces) const;
  Ticks ticks_before(const MotionBlock& block) const;
  void correct(const MotionBlock& block);
  void set_position(const MotionBlock& block);
  void count(const Solution& solution);

  void rewrite(const MotionBlock& block, const NewWords& words, const NewFeed& feed);
  void insert(const MotionBlock& block, const NewWords& words, const NewFeed& feed);
  void append_word(const MotionBlock& block, std::size_t axis, Decimal value, bool blank);
  void append_feed(const MotionBlock& block, Decimal value, bool blank);
  void copy_to(std::uint32_t place);
  void end_line(const MotionBlock& block);
  void restore_feed(const MotionBlock& block);
  void insert_line_end(const MotionBlock& block);

  const Corrector& with_tcp_;
  const Corrector& without_tcp_;
  CorrectionGuard guard_;
  std::array<char, kAxes> letters_;
  bool keep_going_;

  std::string_view source_;
  std::uint32_t copied_ = 0;  // bytes of source_ that are in out_
  CorrectedChunk out_;
  Ticks ticks_{};  // what the axes stand corrected by
  double ticks_unit_mm_ = 1;
  std::optional<Solution> last_;  // of the block before
  bool lines_since_arc_ = false;  // the block before was an arc and left G1 in force
};

}  // namespace trunnion
