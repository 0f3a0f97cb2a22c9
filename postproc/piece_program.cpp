#include "postproc/piece_program.h"

#include <charconv>
#include <cmath>
#include <optional>

#include "postproc/dialect.h"

namespace trunnion {
namespace {

constexpr double kClearance_mm = 5, kAbove_mm = 50;
constexpr double kUsualFeed_mm_per_min = 600;

/// What a control wants before, around and behind the moves.
struct Frame {
  std::string_view begin, end;          ///< of the program
  std::string_view tip_held, tip_free;  ///< tool-centre-point control on and off
  std::string_view rapid, rapid_end;    ///< before and behind a rapid's words
  std::string_view line, line_end;
  int decimals_mm = 4, decimals_deg = 4;
};

Frame frame_of(std::string_view dialect) {
  if (dialect == "fanuc")
    return {.begin = "%\nO1 (CONE FRUSTUM)\n",
            .end = "M30\n%\n",
            .tip_held = "G43.4 H1\n",
            .tip_free = "G49\n",
            .rapid = "G0",
            .line = "G1"};
  if (dialect == "sinumerik")
    return {.end = "M30\n",
            .tip_held = "TRAORI\n",
            .tip_free = "TRAFOOF\n",
            .rapid = "G0",
            .line = "G1",
            .decimals_mm = 5,
            .decimals_deg = 6};
  if (dialect == "heidenhain")
    return {.begin = "BEGIN PGM CONE MM\n",
            .end = "M30\nEND PGM CONE MM\n",
            .tip_held = "M128\n",
            .tip_free = "M129\n",
            .rapid = "L",
            .rapid_end = " R0 FMAX",
            .line = "L",
            .line_end = " R0"};
  return {.end = "M2\n", .rapid = "G0", .line = "G1", .decimals_mm = 5, .decimals_deg = 6};
}

/// The modes that the moves are meant in, and the tool.
std::string_view modes_of(std::string_view dialect, bool modulo_turn) {
  if (dialect == "fanuc") return "G21 G90 G94 G17 G40 G49 G80\nG54\n";
  if (dialect == "sinumerik") return "G710 G90 G94 G17 G40\nG54\nD1\n";
  if (dialect == "heidenhain") return modulo_turn ? "TOOL CALL 1 Z\nM126\n" : "TOOL CALL 1 Z\nM127\n";
  return "G21 G90 G94 G17 G54\n";
}

std::string fixed(double value, int decimals, bool sign_always = false) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals).ptr;
  std::string number(text, end);
  if (number[0] == '-' && number.find_first_not_of("-0.") == std::string::npos) number.erase(0, 1);
  return sign_always && number[0] != '-' ? "+" + number : number;
}

class Writer {
 public:
  Writer(const KinematicChain& chain, const PieceProgramStyle& style)
      : chain_(chain), style_(style), dialect_(dialect(style.dialect)), frame_(frame_of(style.dialect)) {}

  void begin(const TestPiece& piece) {
    add(frame_.begin);
    add(std::string(dialect_.text.comment_open) + "cone frustum, flank milling, tool diameter " +
        fixed(piece.tool.diameter.in_millimetres(), 3) + " mm" + std::string(dialect_.text.comment_close) + "\n");
    add(modes_of(style_.dialect, style_.modulo_turn));
  }

  void hold_tip(IndexedPosition at) {
    if (!dialect_.says_tcp) return;
    if (style_.control.tcp_frame == "start") at = {};
    add(std::string(frame_.rapid) + rotary_words(at) + std::string(frame_.rapid_end) + "\n");
    add(frame_.tip_held);
  }

  void end() {
    add(frame_.tip_free);
    add(frame_.end);
  }

  void rapid(const Eigen::Vector3d& tip_w_mm, IndexedPosition at) {
    add(std::string(frame_.rapid) + words(tip_w_mm, at) + std::string(frame_.rapid_end) + "\n");
  }

  /// Nothing where the words do not change.
  void line(const Eigen::Vector3d& tip_w_mm, IndexedPosition at, std::optional<double> feed = std::nullopt) {
    std::string text = words(tip_w_mm, at);
    if (!feed && text == last_line_) return;
    add(std::string(frame_.line) + text + std::string(frame_.line_end) +
        (feed ? " F" + fixed(*feed, dialect_.text.function_in_every_block ? 0 : 1) : "") + "\n");
    last_line_ = std::move(text);
  }

  std::string take() { return std::move(text_); }

 private:
  /// Lines, numbered where the control wants it.
  void add(std::string_view lines) {
    if (!dialect_.text.function_in_every_block) {
      text_ += lines;
      return;
    }
    for (std::size_t at = 0; at < lines.size();) {
      const std::size_t next = lines.find('\n', at) + 1;
      text_ += std::to_string(number_++) + " ";
      text_ += lines.substr(at, next - at);
      at = next;
    }
  }

  std::string words(const Eigen::Vector3d& tip_w_mm, IndexedPosition at) const {
    const bool beside_the_table = dialect_.says_tcp && style_.control.tcp_frame == "fixed";
    const Eigen::Vector3d place =
        (beside_the_table ? Eigen::Vector3d(chain_.r_from_w(at) * tip_w_mm) : tip_w_mm) - style_.work_offset_mm;
    std::string text;
    for (Eigen::Index k = 0; k < 3; ++k)
      text += std::string(" ") + "XYZ"[k] + fixed(place[k], frame_.decimals_mm, dialect_.text.sign_always);
    return text + rotary_words(at);
  }

  std::string rotary_words(IndexedPosition at) const {
    const bool assigned = style_.dialect == "sinumerik";
    const auto number = [&](double deg) { return fixed(deg, frame_.decimals_deg, dialect_.text.sign_always); };
    const std::string equals = assigned ? "=" : "";
    const std::string tilt = std::string(" ") + style_.tilt_letter + equals + number(at.a.in_degrees());
    if (!assigned || !style_.modulo_turn) return tilt + " C" + equals + number(at.c.in_degrees());
    // A turning axis is sent the shorter way to a place of its one turn; 360 deg as rounded is 0.
    double turn = at.c.in_degrees() - 360 * std::floor(at.c.in_degrees() / 360);
    if (turn > 360 - 0.5 * std::pow(10.0, -frame_.decimals_deg)) turn = 0;
    return tilt + " C=DC(" + number(turn) + ")";
  }

  const KinematicChain& chain_;
  const PieceProgramStyle& style_;
  const Dialect& dialect_;
  Frame frame_;
  std::string text_, last_line_;
  std::size_t number_ = 0;
};

}  // namespace

std::string piece_program(const TestPiece& piece, std::span<const ToolPosition> path, const KinematicChain& chain,
                          const PieceProgramStyle& style) {
  const Eigen::Isometry3d frame = w_from_cone(piece.cone);
  const auto clear_of = [&](const ToolPosition& p) -> Eigen::Vector3d {
    const ConePoint on = cone_point(piece.cone, frame, Angle::radians(p.phi_rad), Length());
    return p.nominal.tip_w_mm + kClearance_mm * on.normal_w;
  };
  const auto above = [&](const ToolPosition& p) -> Eigen::Vector3d {
    return clear_of(p) + (piece.cone.height.in_millimetres() + kAbove_mm) * p.nominal.axis_w;
  };
  const ToolPosition &first = path.front(), &last = path.back();
  Writer writer(chain, style);
  writer.begin(piece);
  writer.hold_tip(first.at);
  writer.rapid(above(first), first.at);
  writer.rapid(clear_of(first), first.at);
  writer.line(first.nominal.tip_w_mm, first.at, piece.feed_mm_per_min.value_or(kUsualFeed_mm_per_min));
  for (const ToolPosition& p : path.subspan(1)) writer.line(p.nominal.tip_w_mm, p.at);
  writer.line(clear_of(last), last.at);
  writer.rapid(above(last), last.at);
  writer.end();
  return writer.take();
}

}  // namespace trunnion
