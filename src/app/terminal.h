#pragma once

#include <string>

namespace trunnion {

/// Whether standard output is a terminal that may be coloured: not with NO_COLOR set (https://no-color.org), nor TERM
/// "dumb".
bool colour_wanted();

enum class Paint { plain, good, doubtful, bad, faint };
/// `text` in a colour, where colours are wanted; else as it is.
std::string painted(const std::string& text, Paint paint);

/// `text` in lines of at most `width` columns, broken at blanks, those after the first indented.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width = 110);

}  // namespace trunnion
