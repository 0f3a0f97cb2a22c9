#pragma once

#include <string>
#include <vector>

#include "postproc/plain_player.h"
#include "shop.h"

namespace trunnion {

/// Where a program meant to be and where its correction sends the machine, at one place of one block.
struct PlayedPair {
  std::size_t line = 0;
  double part = 1;  ///< of the written block; 1: its end
  bool tcp = true;
  Commanded meant, sent;
};

inline Commanded place_of(const AxisValues& at) {
  return {{at[0], at[1], at[2]}, {Angle::degrees(at[kTilt]), Angle::degrees(at[kTurn])}};
}

/// Both programs read by the plain players, block against block; lines that were inserted as `result` tells.
inline std::vector<PlayedPair> played_pairs(const Shop& shop, std::string_view program, std::string_view corrected) {
  const auto meant_player = plain_player(shop.how.dialect, shop.how.scan);
  const auto sent_player = plain_player(shop.how.dialect, shop.how.scan);
  const auto take = [](std::string_view& text) {
    std::string line(text.substr(0, text.find('\n')));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    return line;
  };
  std::vector<PlayedPair> pairs;
  auto insertion = shop.result.inserted.begin();
  std::size_t written = 0;
  for (std::size_t line = 1; !program.empty(); ++line) {
    const auto meant = meant_player->play(take(program));
    if (++written == shop.result.header_line) {
      take(corrected);
      ++written;
    }
    std::vector<PlayedMove> pieces;
    std::size_t count = 1;
    if (insertion != shop.result.inserted.end() && insertion->line == line) count += (insertion++)->count;
    written += count - 1;
    for (std::size_t i = 0; i < count; ++i)
      if (const auto piece = sent_player->play(take(corrected))) pieces.push_back(*piece);
    EXPECT_EQ(meant.has_value(), !pieces.empty()) << line;
    if (!meant || pieces.empty()) continue;
    const double n = static_cast<double>(pieces.size());
    for (std::size_t k = 0; k < pieces.size(); ++k)
      for (const double s : {0.3, 0.5, 1.0}) {
        if (s < 1 && (!meant->feed || !meant->begins_known())) continue;
        pairs.push_back({line, s, meant->tcp, place_of(meant->at((static_cast<double>(k) + s) / n, &shop.chain)),
                         place_of(pieces[k].at(s, &shop.chain))});
      }
  }
  return pairs;
}

/// What the exact machine makes of a pair.
inline Miss missed(const Shop& shop, const PlayedPair& pair, bool corrected) {
  CorrectionSettings as = shop.settings;
  as.tcp = pair.tcp ? ToolCentrePoint::on : ToolCentrePoint::off;
  return miss(shop.both, pair.meant, corrected ? pair.sent : pair.meant, as);
}

}  // namespace trunnion
