#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "postproc/dialect.h"
#include "postproc/path_solver.h"

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
  /// Where an axis turns round within a block, or before one that cannot be divided: nothing is taken up there.
  std::uint64_t reversals_left = 0;
  double largest_reversal_left_mm = 0;
  std::uint64_t largest_reversal_left_line = 0;
  std::uint64_t untimed_moves = 0;  ///< whose duration is not known, where errors depend on the time
  std::uint64_t first_untimed_line = 0;
  Assumptions assumptions = 0;

  bool changed() const { return changed_words + added_words + inserted_blocks > 0; }
  CorrectionCounts& operator+=(const CorrectionCounts& other);
};

/// Lines that were inserted behind a line of the original.
struct Insertion {
  std::uint64_t line = 0;
  std::uint32_t count = 0;
  bool takes_up = false;  ///< the first piece only takes up what an axis loses where it turns round
};

/// What one chunk of a program became.
struct CorrectedChunk {
  std::string text;
  CorrectionCounts counts;
  std::vector<Insertion> inserted;
  std::vector<Refusal> refusals;
};

/// The words of one block as written: the five axes, then the three of a tool axis told as a vector.
inline constexpr std::size_t kWords = kAxes + 3;
/// A new value for each word, empty where it stays as it is written.
using NewWords = std::array<std::optional<Decimal>, kWords>;

/// What else of a block changes.
struct NewFeed {
  std::optional<Decimal> word;  ///< F of every piece, or their time: it keeps the duration of a block
  bool timed = false;           ///< the word is told as time; the old feed mode comes back behind the block
  bool lines_for_arc = false;   ///< the words of the arc go
  char arc_code = 0;            ///< '1', '2' or '3' to stand in the block
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< an arc that stays one is moved by this
  Ticks begin{};                                        ///< and its begin by these
};

/// Enough decimals for seven digits of a feed.
Decimal feed_decimal(double value);

/// The text of a chunk while its blocks are rewritten from the first to the last: what is not touched is copied byte
/// for byte, what is added is dressed as the block's own words are.
class BlockText {
 public:
  BlockText(std::array<char, kAxes> letters, DialectText text) : letters_(letters), text_(text) {}

  void begin(std::string_view source);
  /// All that was written, the rest of the source copied.
  CorrectedChunk finish();
  CorrectedChunk& out() { return out_; }

  /// The usual block: absolute words of the axes, whose numbers change by `by`; axes without words stand corrected by
  /// `before`. False, and nothing written, for any other.
  bool rewrite_plainly(const MotionBlock& block, const Ticks& by, const Ticks& before);
  /// A few numbers change, words are added behind the last.
  void rewrite_numbers(const MotionBlock& block, const NewWords& words);
  void rewrite(const MotionBlock& block, const NewWords& words, const NewFeed& feed);
  /// Copies what is left of the block's line, which ends then even where the program does.
  void end_line(const MotionBlock& block);
  /// A block more behind it.
  void insert(const MotionBlock& block, const NewWords& words, const NewFeed& feed);
  /// The feed as the program has it, behind blocks that told their time.
  void restore_feed(const MotionBlock& block);

 private:
  void copy_to(std::uint32_t place);
  const WordPlace* word_of(const MotionBlock& block, std::size_t slot) const;
  void append_number_in(Decimal number, NumberStyle style);
  void replace_number(const WordPlace& word, Decimal value);
  void append_word(const MotionBlock& block, std::size_t slot, Decimal value, bool blank);
  void append_feed(const MotionBlock& block, const NewFeed& feed, bool blank);
  void add_words(const MotionBlock& block, const NewWords& words, const NewFeed& feed, bool all);
  std::string arc_code(const MotionBlock& block, char digit) const;
  void append_block_begin(const MotionBlock& block);
  void insert_line_end(const MotionBlock& block);

  std::array<char, kAxes> letters_;
  DialectText text_;
  std::string_view source_;
  std::uint32_t copied_ = 0;  // bytes of source_ that are in out_
  CorrectedChunk out_;
};

}  // namespace trunnion
