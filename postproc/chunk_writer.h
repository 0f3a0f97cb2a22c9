#pragma once

#include "postproc/block_text.h"

namespace trunnion {

/// Rewrites the words of scanned blocks. What it writes for a block depends on that block and on where the one before
/// left the machine, which it computes anew at the beginning of a chunk: chunks may be written in any order.
class ChunkWriter {
 public:
  /// The correctors for blocks with tool-centre-point control and without must outlive it.
  ChunkWriter(const Corrector& with_tcp, const Corrector& without_tcp, CorrectionGuard guard,
              std::array<char, kAxes> letters, DialectText text, bool keep_going)
      : solver_(with_tcp, without_tcp, guard, letters),
        block_text_(letters, text),
        text_(text),
        keep_going_(keep_going) {}

  /// The text of the chunk, corrected. Stops at the first block it refuses unless it is to keep going; then the block
  /// is copied.
  CorrectedChunk write(std::string_view text, const ScannedChunk& scanned);
  ChunkWriter(const ChunkWriter&) = delete;

 private:
  /// The state of a block's pieces while they are put into words.
  struct Pen {
    Ticks before{};                      // what the axes stood corrected by
    Ticks last{};                        // and behind the last piece
    const AxisValues* last_place;        // programmed
    bool lines = false;                  // a bent way that becomes lines: axes without words move as well
    std::array<Decimal, kAxes> moved{};  // what incremental words have said so far
  };

  NewWords words(const MotionBlock& block, const Solution& end, bool final, Pen& pen) const;
  void direction_words(const MotionBlock& block, const Solution& end, bool final, const Pen& pen,
                       NewWords& words) const;
  /// The feed of a block whose way is divided into so many pieces, written on so many lines.
  NewFeed new_feed(const MotionBlock& block, const Ticks& before, const Ticks& after, std::size_t pieces,
                   std::size_t lines) const;
  Ticks ticks_before(const MotionBlock& block) const;
  void remember(const Solution& solution);
  void correct(const MotionBlock& block);
  void correct(const MotionBlock& block, Solution& end, const Ticks& before, bool whole,
               const std::optional<Solution>& begin);
  std::optional<Solution> taken_up(const MotionBlock& block);
  void note_turns_inside(const MotionBlock& block, const Solution& end);
  void leave(const MotionBlock& block, const Solution& with, const Solution& without);
  void set_position(const MotionBlock& block);
  void count(const Solution& solution);

  PathSolver solver_;
  BlockText block_text_;
  DialectText text_;
  bool keep_going_;

  Ticks ticks_{};  // what the axes stand corrected by
  double ticks_unit_mm_ = 1;
  std::array<Solution, 2> kept_;  // of the block before and of the one at hand, by turns
  Solution* last_ = nullptr;      // of the block before, where it is known
  bool lines_since_arc_ = false;  // the block before was an arc and left a straight move in force
};

}  // namespace trunnion
