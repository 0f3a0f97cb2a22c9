#pragma once

#include "postproc/dialects/klartext_line.h"
#include "postproc/program_state.h"

namespace trunnion {

/// The serial scan of Klartext.
class HeidenhainScanner : public ProgramScanner {
 public:
  explicit HeidenhainScanner(const ScanSettings& settings) : settings_(settings), state_(settings) {
    state_.turning = ToolTurning::axes;
  }

  bool scan(std::string_view line, std::uint32_t begin, ScannedChunk& chunk) override;

 private:
  bool follow_codes(const KlartextLine& block);
  void execute(const KlartextLine& block, std::string_view line, ScannedChunk& chunk);

  // Moves.
  std::optional<std::size_t> axis_of(std::string_view name) const;
  WordPlace placed(WordPlace word) const;

  /// What a block says besides its axes.
  struct Told {
    bool rapid = false, machine = false, ends = false, stops = false, has_feed = false;
    int sense = 0;
    const Piece* radius = nullptr;
    const Piece* angle = nullptr;  // PA or IPA
    std::array<const Piece*, 3> direction{};
    bool normal = false, plane_angles = false;
    std::vector<int> m;
  };
  void path(const KlartextLine& block, std::string_view line, ScannedChunk& chunk);
  void take(const Piece& piece, bool arc, Told& told, bool& feed_of_m);

  /// Q120, Q121 and Q122 are the angles of the plane that PLANE ... STAY has left to the program.
  void take_variable(const Piece& piece, std::size_t axis, Told& told);
  void take_feed(const Piece& piece, Told& told, bool feed_of_m);
  double feed_unit_mm() const;
  void add_arc_word(const Piece& piece, ArcWord::Tells tells, std::uint8_t axis);
  void tell_arc(const std::string& function, const Told& told);

  /// CP PA+30 or IPA+720: round the pole, the third axis along with it.
  void turn_about_pole(const Told& told);
  void take_direction(const Told& told);
  void pole(const KlartextLine& block);

  // Other blocks.
  void begin_or_end(const KlartextLine& block);
  void tool(const KlartextLine& block);
  void before_move(int m);
  void behind_move(int m);
  void miscellaneous(const KlartextLine& block);
  void assignment(const KlartextLine& block);
  void special_function(const KlartextLine& block);
  double value(const KlartextLine& block, std::string_view name) const;
  void plane(const KlartextLine& block);

  /// Cycle 7 shifts the zero; some say nothing about the path; what mills or drills waits for its call.
  void cycle(const KlartextLine& block);
  static bool resets(const KlartextLine& block);
  void take_shift(const KlartextLine& block);

  ScanSettings settings_;
  ProgramState state_;
  Move move_;
  std::uint64_t line_ = 0;
  std::uint32_t begin_ = 0;
  bool ended_ = false, lost_ = false, codes_followed_ = false;
  bool feed_on_circumference_ = false;  // M116
  int plane_sense_ = 0;                 // SEQ
  bool pole_known_ = false;
  std::array<double, 3> pole_{};  // mm, in the program's coordinates
};

}  // namespace trunnion
