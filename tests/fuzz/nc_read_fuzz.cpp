#include <cstdlib>

#include "error.h"
#include "nc_input.h"
#include "postproc/block.h"
#include "postproc/block_text.h"
#include "postproc/plain_player.h"

// Any bytes as an NC program of any dialect, read only: no crash, no hang, refusals or blocks. Every word of a block
// stands in its own line, and the program put together again from its blocks is the program, byte for byte. The second
// reader, which the report is played by, follows whatever the first has let through.

namespace {

using namespace trunnion;

bool stands_in(const WordPlace& word, const MotionBlock& block) {
  return block.begin <= word.text && word.text <= word.number && word.number < word.number_end &&
         word.number_end <= word.end && word.end <= block.end;
}

ScannedChunk scanned(const NcInput& in, const ScanSettings& settings) {
  ScannedChunk chunk;
  const std::unique_ptr<ProgramScanner> scanner = in.dialect->scanner(settings);
  const std::string_view text = in.program;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = line_length(text.substr(at));
    if (!scanner->scan(text.substr(at, length), static_cast<std::uint32_t>(at), chunk)) break;
    at += length;
  }
  return chunk;
}

std::string put_together(const NcInput& in, const ScanSettings& settings, const ScannedChunk& chunk) {
  BlockText text(settings.letters, in.dialect->text);
  text.begin(in.program);
  for (const MotionBlock& block : chunk.blocks) {
    NewWords words;
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (!holds(block.programmed, i)) continue;
      if (!stands_in(block.word[i], block)) std::abort();
      words[i] = block.word[i].value;
    }
    if (block.extras && block.extras->direction)
      for (std::size_t i = 0; i < 3; ++i) {
        if (!stands_in((*block.extras->direction)[i], block)) std::abort();
        words[kAxes + i] = (*block.extras->direction)[i].value;
      }
    text.rewrite_numbers(block, words);
  }
  return text.finish().text;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const NcInput in = nc_input(data, size);
  const ScanSettings settings = nc_scan(in);
  const ScannedChunk chunk = scanned(in, settings);
  if (put_together(in, settings, chunk) != in.program) std::abort();
  if (!chunk.refusals.empty()) return 0;
  try {
    const std::unique_ptr<PlainPlayer> player = plain_player(std::string(in.dialect->name), settings);
    for (std::size_t at = 0; at < in.program.size();) {
      const std::size_t end = in.program.find('\n', at);
      const std::size_t next = end == std::string::npos ? in.program.size() : end + 1;
      player->play(in.program.substr(at, next - at));
      at = next;
    }
  } catch (const Error&) {
  }
  return 0;
}
