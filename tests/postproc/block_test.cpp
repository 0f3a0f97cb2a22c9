#include "postproc/block.h"

#include <gmock/gmock.h>

#include <random>

namespace trunnion {
namespace {

using testing::ElementsAre;

std::vector<TokenKind> kinds(std::string_view line) {
  IsoTokenizer tokenize;
  std::vector<TokenKind> found;
  for (const Token& token : tokenize(line)) found.push_back(token.kind);
  return found;
}

/// Whether the tokens cover `line` without gap.
bool lossless(std::string_view line) {
  IsoTokenizer tokenize;
  std::size_t at = 0;
  for (const Token& token : tokenize(line)) {
    if (token.begin != at || token.text < token.begin || token.end < token.text || token.end == token.begin)
      return false;
    at = token.end;
  }
  return at == line.size();
}

TEST(Tokens, OfAPlainBlock) {
  IsoTokenizer tokenize;
  const auto tokens = tokenize("N10 g1 X-10.50Y.5 F1000 (rough) ; end\r\n");
  ASSERT_EQ(tokens.size(), 8u);
  EXPECT_EQ(tokens[1].letter, 'G');
  EXPECT_EQ(tokens[2].value, (Decimal{-1050, 2}));
  EXPECT_EQ(tokens[2].begin, 6u);
  EXPECT_EQ(tokens[2].text, 7u);
  EXPECT_EQ(tokens[3].letter, 'Y');
  EXPECT_EQ(tokens[5].kind, TokenKind::comment);
  EXPECT_EQ(tokens[6].kind, TokenKind::comment);
  EXPECT_EQ(tokens[7].kind, TokenKind::line_end);
}

TEST(Tokens, TellWhatIsNoPlainWord) {
  using enum TokenKind;
  EXPECT_THAT(kinds("/ X#1 Y[1 + 2] Z<a b>\n"),
              ElementsAre(block_delete, expression, expression, expression, line_end));
  EXPECT_THAT(kinds("#1 = [2*3] (two)\n"), ElementsAre(parameter, comment, line_end));
  EXPECT_THAT(kinds("%\n"), ElementsAre(percent, line_end));
  EXPECT_THAT(kinds("X1 ? (open\n"), ElementsAre(word, other, other, line_end));
}

TEST(Tokens, CoverEveryByteOfAnyLine) {
  std::mt19937_64 random(77);
  const std::string_view alphabet =
      "GXYZAC019.-+ \t\r\n()[];#%/<>\0?\x7f="
      "\xc3\xa4";
  for (int i = 0; i < 200000; ++i) {
    std::string text;
    for (std::size_t n = random() % 24; n > 0; --n) text += alphabet[random() % alphabet.size()];
    for (std::string_view rest = text; !rest.empty();) {
      const std::string_view line = rest.substr(0, line_length(rest));
      ASSERT_TRUE(lossless(line)) << testing::PrintToString(text);
      rest.remove_prefix(line.size());
    }
  }
}

TEST(Lines, EndWithAnyOfThreeLineEnds) {
  EXPECT_EQ(line_length("X1\nY1"), 3u);
  EXPECT_EQ(line_length("X1\r\nY1"), 4u);
  EXPECT_EQ(line_length("X1\n\r\rY1"), 5u);
  EXPECT_EQ(line_length("X1\n\r\nY1"), 3u);
  EXPECT_EQ(line_length("X1"), 2u);
  EXPECT_EQ(line_end("X1\n\r\r"), "\n\r\r");
  EXPECT_EQ(line_end("X1\r\n"), "\r\n");
  EXPECT_EQ(line_end("X1"), "");
}

}  // namespace
}  // namespace trunnion
