#include "app/terminal.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>

namespace trunnion {

bool colour_wanted() {
  const char *no = std::getenv("NO_COLOR"), *term = std::getenv("TERM");
  return isatty(STDOUT_FILENO) == 1 && (no == nullptr || *no == '\0') && term != nullptr && std::string(term) != "dumb";
}

std::string painted(const std::string& text, Paint paint) {
  if (paint == Paint::plain || !colour_wanted()) return text;
  const char* code = paint == Paint::good ? "32" : paint == Paint::doubtful ? "33" : paint == Paint::bad ? "1;31" : "2";
  return std::string("\x1b[") + code + "m" + text + "\x1b[0m";
}

std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::istringstream words(text);
  std::string line, all;
  for (std::string word; words >> word;) {
    if (!line.empty() && indent + line.size() + 1 + word.size() > width) {
      all += line + "\n" + std::string(indent, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return all + line;
}

}  // namespace trunnion
