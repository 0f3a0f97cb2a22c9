#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "postproc/motion.h"

namespace trunnion {

/// A piece of a Klartext block: letters, and what stands behind them.
struct Piece {
  std::string name;  ///< upper case: X, IX, FMAX, DR, SPA
  WordPlace place;   ///< in the line
  bool number = false;
  char sign = 0;          ///< + or - without a number: DR+
  bool variable = false;  ///< Q5, -QL3: not computed
  std::string variable_name;
};

/// Takes a line apart: an optional number, then pieces, a comment at its end. Texts in quotes are no pieces.
class KlartextLine {
 public:
  explicit KlartextLine(std::string_view line);

  std::span<const Piece> pieces() const { return pieces_; }
  /// From the block's function to its end, in capitals.
  std::string text() const;
  std::string_view comment() const { return comment_; }
  bool empty() const { return pieces_.empty() && !strange_; }
  bool strange() const { return strange_; }    ///< bytes that are no piece stand in it
  bool optional() const { return optional_; }  ///< / before it: block delete
  std::string function() const { return pieces_.empty() ? "" : pieces_.front().name; }

 private:
  std::size_t take(std::size_t at, std::size_t end);
  std::size_t value(std::size_t at, std::size_t end, Piece& piece);

  std::string_view line_;
  std::size_t text_ = 0;
  std::vector<Piece> pieces_;
  std::string_view comment_;
  bool strange_ = false, optional_ = false;
};

}  // namespace trunnion
