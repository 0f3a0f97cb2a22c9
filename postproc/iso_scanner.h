#pragma once

#include <span>

#include "postproc/block.h"
#include "postproc/program_state.h"

namespace trunnion {

/// What a G code does, as far as letter-and-number dialects agree.
enum class Code : std::uint8_t {
  unknown,
  harmless,
  taken_for_harmless,  ///< nobody has confirmed it
  rapid,
  line,
  clockwise,
  counter_clockwise,
  no_motion,     ///< G80: axis words wait for a motion code
  other_motion,  ///< moves where a correction cannot follow: refused where it moves, for its reason
  plane_xy,
  plane_zx,
  plane_yz,
  inch,
  metric,
  cutter_on,
  cutter_off,
  tool_length,  ///< Z stands elsewhere from here on
  work_offset,
  absolute,
  incremental,
  inverse_time,
  per_minute,
  per_revolution,
  machine_coordinates,  ///< G53: the block's axes go where the program's zero is not known
  home,                 ///< G28: the same, and all axes where none is named
  dwell,                ///< its words are times
  absolute_centre,
  relative_centre,
  refused,    ///< for its reason
  cycle,      ///< a canned cycle beside the motion codes: refused for its reason until one of those or its end comes
  cycle_end,  ///< G80 of such cycles
  special,    ///< the dialect's own affair
  alone,      ///< the same, and no other such code in the block
};

/// One G code of a dialect.
struct CodeEntry {
  int tenths = 0;  ///< 431 for G43.1
  Code code = Code::unknown;
  const char* reason = "";  ///< behind "G43.1: "
};

/// What else differs.
struct IsoRules {
  std::string_view dialect;
  IsoSyntax syntax;
  std::string_view letters_of_moves = "XYZABCUVWIJKR";  ///< a number beyond reason behind these is no program
  std::string_view harmless_letters;                    ///< words that say nothing about where the tool goes
  std::string_view harmless_expressions;                ///< letters whose word may be computed
  char turns_letter = 0;                                ///< P of an arc: its turns, the first counted
  int first_motion = 800;                               ///< the code that holds at the program's begin
  bool point_matters = false;                           ///< 10 and 10. may be different
  bool dwell_takes_feed = false;                        ///< F beside a dwell is its time
  int machine_feed_below_tenths = 0;  ///< inch codes below this one change lengths alone, F stays in the machine's unit
};

/// The words of one block, sorted by what they are.
struct IsoWords {
  std::array<int, 16> g{};  ///< G codes in tenths
  std::size_t g_count = 0;
  std::array<int, 8> m{};
  std::size_t m_count = 0;
  WordPlace feed;  ///< F: else its end is 0
  bool feed_expression = false;
  std::array<const Token*, 5> arc{};  ///< I J K R P
  bool offset_letter = false;         ///< L
  bool optional = false;              ///< block delete
  // What the codes ask for.
  int motion = -1, alone = -1;
  bool machine_coordinates = false, home = false, dwell = false, stops = false, ends = false, tool_change = false;
  bool changes_modes = false;
  bool changes_state = false;     ///< a code that is more than harmless
  bool turns_expression = false;  ///< P is computed
  bool rest_ignored = false;      ///< a declaration: what follows on the line are no words
  std::uint32_t begin = 0;        ///< of the line

  bool has_centre() const { return arc[0] != nullptr || arc[1] != nullptr || arc[2] != nullptr; }
};

/// "G43.1" of 431.
std::string code_name(char letter, int tenths);

/// The serial scan of dialects of letters and numbers. A dialect is a table of G codes and, derived, what only it has.
class IsoScanner : public ProgramScanner {
 public:
  IsoScanner(const ScanSettings& settings, const IsoRules& rules, std::span<const CodeEntry> codes);
  bool scan(std::string_view line, std::uint32_t begin, ScannedChunk& chunk) override;

 protected:
  /// A word that the base does not know; throws where the dialect does not either.
  virtual void take_letter(const Token& token, IsoWords& words);
  virtual void take_expression(const Token& token, IsoWords& words);
  virtual void take_parameter(std::string_view text);
  virtual void take_name(std::string_view line, const Token& token, IsoWords& words);
  /// Bytes that are no word; false: no block of this dialect.
  virtual bool take_other(std::string_view text);
  /// A code of kind special or alone, at its turn.
  virtual void take_code(int g, IsoWords& words);
  /// After all codes and M words are in force; true: the block's words are used up, nothing moves.
  virtual bool take_block(IsoWords& words, ScannedChunk& chunk);
  virtual void begin_block();
  virtual void take_m(int m, IsoWords& words) = 0;
  /// How an arc is told; by I J K or R here.
  virtual void tell_arc(const IsoWords& words);
  /// The unit of a number that has no point.
  virtual Decimal value_of(const Token& token, std::size_t axis) const;

  std::optional<std::size_t> axis_of(char letter) const;
  bool arc_mode() const;
  int motion() const { return motion_; }
  Code code_of(int tenths) const;
  WordPlace place(const Token& token) const;
  TextPlace text_place(const Token& token) const { return {begin_ + token.text, begin_ + token.end}; }
  /// The name of a word, a call or a label as it stands in the text.
  std::string_view name_of(const Token& token) const {
    return current_.substr(token.text, token.name_end - token.text);
  }
  void take_axis(std::size_t axis, const Token& token);
  void forget_words();
  std::uint64_t line_number() const { return line_; }
  const ScanSettings& settings() const { return settings_; }

  ProgramState state_;
  Move move_;
  Assumptions assumptions_ = 0;  ///< that the program has made use of
  bool absolute_centre_ = false;

 private:
  bool take_plain(std::string_view line, IsoWords& words);
  void collect(std::span<const Token> tokens, std::string_view line, IsoWords& words);
  void take_word(const Token& token, std::string_view line, IsoWords& words);
  void apply(int g, IsoWords& words);
  void execute(IsoWords& words, ScannedChunk& chunk);
  void run_move(const IsoWords& words, ScannedChunk& chunk);
  [[noreturn]] void refuse_motion(int motion) const;
  bool follow_codes(std::string_view line);
  const CodeEntry* entry(int tenths) const;

  ScanSettings settings_;
  IsoRules rules_;
  std::array<std::uint8_t, 10000> index_{};  // into codes_, counted from 1
  std::span<const CodeEntry> codes_;
  std::array<std::int8_t, 26> axis_by_letter_{};
  IsoTokenizer tokenize_;
  std::uint64_t line_ = 0;
  std::uint32_t begin_ = 0;
  std::string_view current_;  // the line
  bool anything_ = false, percent_ = false, ended_ = false, lost_ = false, codes_followed_ = false;
  int motion_, cycle_ = -1;
  bool feed_unit_told_ = true;
  bool tool_length_changed_ = false;
};

}  // namespace trunnion
