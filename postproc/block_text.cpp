#include "postproc/block_text.h"

#include <algorithm>
#include <cmath>

#include "postproc/block.h"

namespace trunnion {

Decimal feed_decimal(double value) {
  value = std::clamp(value, 1e-6, 1e9);
  const int whole = static_cast<int>(std::floor(std::log10(value))) + 1;
  return rounded(value, std::clamp(7 - whole, 0, kMostDecimals));
}

CorrectionCounts& CorrectionCounts::operator+=(const CorrectionCounts& other) {
  lines += other.lines;
  corrected_blocks += other.corrected_blocks;
  copied_moves += other.copied_moves;
  changed_words += other.changed_words;
  added_words += other.added_words;
  inserted_blocks += other.inserted_blocks;
  beyond_tolerance += other.beyond_tolerance;
  largest_deviation_mm = std::max(largest_deviation_mm, other.largest_deviation_mm);
  largest_tilt_rad = std::max(largest_tilt_rad, other.largest_tilt_rad);
  largest_residual_rad = std::max(largest_residual_rad, other.largest_residual_rad);
  largest_position_change_mm = std::max(largest_position_change_mm, other.largest_position_change_mm);
  largest_rotary_change_rad = std::max(largest_rotary_change_rad, other.largest_rotary_change_rad);
  largest_c_correction_rad = std::max(largest_c_correction_rad, other.largest_c_correction_rad);
  reversals_left += other.reversals_left;
  if (other.largest_reversal_left_mm > largest_reversal_left_mm) {
    largest_reversal_left_mm = other.largest_reversal_left_mm;
    largest_reversal_left_line = other.largest_reversal_left_line;
  }
  if (untimed_moves == 0) first_untimed_line = other.first_untimed_line;
  untimed_moves += other.untimed_moves;
  assumptions |= other.assumptions;
  return *this;
}

void BlockText::begin(std::string_view source) {
  source_ = source;
  copied_ = 0;
  out_ = {};
  out_.text.reserve(source.size() + source.size() / 8);
}

CorrectedChunk BlockText::finish() {
  copy_to(static_cast<std::uint32_t>(source_.size()));
  return std::move(out_);
}

void BlockText::copy_to(std::uint32_t place) {
  out_.text.append(source_.substr(copied_, place - copied_));
  copied_ = place;
}

const WordPlace* BlockText::word_of(const MotionBlock& block, std::size_t slot) const {
  if (slot < kAxes) return holds(block.programmed, slot) ? &block.word[slot] : nullptr;
  return block.extras->direction ? &(*block.extras->direction)[slot - kAxes] : nullptr;
}

void BlockText::append_number_in(Decimal number, NumberStyle style) {
  style.plus |= text_.sign_always;
  style.point |= text_.point_always;
  append_number(out_.text, number, style);
}

void BlockText::replace_number(const WordPlace& word, Decimal value) {
  copy_to(word.number);
  append_number_in(value, word.style);
  copied_ = word.number_end;
  ++out_.counts.changed_words;
}

/// A word of axis or vector, dressed as the block's own word is: its letter, its =IC( ), its I.
void BlockText::append_word(const MotionBlock& block, std::size_t slot, Decimal value, bool blank) {
  if (blank) out_.text += ' ';
  if (const WordPlace* own = word_of(block, slot)) {
    out_.text.append(source_.substr(own->text, own->number - own->text));
    append_number_in(value, own->style);
    out_.text.append(source_.substr(own->number_end, own->end - own->number_end));
    return;
  }
  if (slot < kAxes) {
    const bool small = block.words > 0 && source_[block.word[block.order[0]].text] >= 'a';
    out_.text += static_cast<char>(small ? letters_[slot] - 'A' + 'a' : letters_[slot]);
    append_number_in(value, block.style[slot]);
  } else {
    out_.text.append(text_.direction[slot - kAxes]);
    append_number_in(value, {});
  }
}

void BlockText::append_feed(const MotionBlock& block, const NewFeed& feed, bool blank) {
  if (blank && block.blank_before_words) out_.text += ' ';
  out_.text += feed.timed && text_.time_in_seconds ? "FT" : "F";
  NumberStyle style = block.has_feed_word() ? block.feed_word.style : NumberStyle{};
  style.plus = false;
  append_number(out_.text, *feed.word, style);
}

bool BlockText::rewrite_plainly(const MotionBlock& block, const Ticks& by, const Ticks& before) {
  constexpr std::size_t kRoom = 512;
  if (block.extras || block.words == 0 || (block.incremental | block.in_turn) != 0 ||
      block.end - copied_ + kAxes * kLongestNumber > kRoom)
    return false;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (!holds(block.programmed, i) && !same_value(by[i], before[i])) return false;
  std::array<char, kRoom> line;
  char* to = line.data();
  const char* const source = source_.data();
  for (std::size_t i = 0; i < block.words; ++i) {
    const std::size_t axis = block.order[i];
    if (by[axis].mantissa == 0) continue;
    const WordPlace& word = block.word[axis];
    to = std::copy(source + copied_, source + word.number, to);
    NumberStyle style = word.style;
    style.plus |= text_.sign_always;
    style.point |= text_.point_always;
    to = write_number(to, word.value + by[axis], style);
    copied_ = word.number_end;
    ++out_.counts.changed_words;
  }
  out_.text.append(line.data(), to);
  return true;
}

void BlockText::rewrite_numbers(const MotionBlock& block, const NewWords& words) {
  // Vectors stand before or behind the axes; the general way puts them in order.
  if (block.words == 0 || (block.extras && block.extras->direction)) return rewrite(block, words, {});
  std::uint32_t last_word = block.begin;
  for (std::size_t i = 0; i < block.words; ++i) {
    const std::size_t axis = block.order[i];
    const WordPlace& word = block.word[axis];
    last_word = word.end;
    if (words[axis] && !same_value(*words[axis], word.value)) replace_number(word, *words[axis]);
  }
  bool add = false;
  for (std::size_t i = 0; i < kWords; ++i) add |= words[i] && (i >= kAxes || !holds(block.programmed, i));
  if (!add) return;
  copy_to(last_word);
  add_words(block, words, {}, false);
}

/// Words that the block has not, or all.
void BlockText::add_words(const MotionBlock& block, const NewWords& words, const NewFeed& feed, bool all) {
  bool blank = all ? text_.function_in_every_block : block.blank_before_words;
  for (std::size_t i = 0; i < kWords; ++i) {
    if (!words[i] || (!all && word_of(block, i) != nullptr)) continue;
    append_word(block, i, *words[i], blank);
    if (!all) ++out_.counts.added_words;
    blank = block.blank_before_words;
  }
  if (feed.word && (all || !block.has_feed_word())) append_feed(block, feed, true);
}

/// The code of a straight move or an arc, written as the block writes its own: G1, G01, g1.
std::string BlockText::arc_code(const MotionBlock& block, char digit) const {
  if (text_.function_in_every_block && digit == '1') return std::string(text_.line_code);
  if (digit != '1' && !block.extras->arc_name.empty()) return std::string(block.extras->arc_name);
  const std::string_view own = source_.substr(block.motion_word.text, block.motion_word.end - block.motion_word.text);
  const bool plain = own.size() >= 2 && own[1] >= '0' && own[1] <= '9';
  const char letter = plain ? own[0] : 'G';
  return std::string(1, letter) + (plain && own.size() == 3 && own[1] == '0' ? "0" : "") + digit;
}

void BlockText::rewrite(const MotionBlock& block, const NewWords& words, const NewFeed& feed) {
  struct Edit {
    std::uint32_t text, number, number_end, end;  // of the word
    std::optional<Decimal> value;                 // its new number; none: `whole` stands in its place
    NumberStyle style;
    std::string whole;  // empty: the word goes
    bool axis = true;   // its number is a coordinate
  };
  std::vector<Edit> edits;
  std::uint32_t first_word = block.end, last_word = block.begin;
  const auto number = [&](const WordPlace& word, Decimal value, NumberStyle style) {
    edits.push_back({word.text, word.number, word.number_end, word.end, value, style, {}});
  };
  const auto replace = [&](std::uint32_t text, std::uint32_t end, std::string whole) {
    edits.push_back({text, text, end, end, std::nullopt, {}, std::move(whole)});
  };
  const auto anchor = [&](const WordPlace& word) {
    first_word = std::min(first_word, word.text);
    last_word = std::max(last_word, word.end);
  };
  for (std::size_t i = 0; i < kWords; ++i) {
    if (i >= kAxes && !block.extras) break;
    const WordPlace* word = word_of(block, i);
    if (word == nullptr) continue;
    anchor(*word);
    if (words[i] && !same_value(*words[i], word->value)) {
      number(*word, *words[i], word->style);
      ++out_.counts.changed_words;
    }
  }
  if (block.extras)
    for (const ArcWord& own : block.extras->arc_word) {
      anchor(own.word);
      if (feed.lines_for_arc) {
        replace(own.word.text, own.word.end, {});
        ++out_.counts.changed_words;
      } else if (own.tells != ArcWord::Tells::nothing_moved) {
        Decimal by = rounded(feed.centre_mm[own.axis] / block.unit_mm, block.decimals[own.axis]);
        if (own.tells == ArcWord::Tells::centre_from_begin) by = by - feed.begin[own.axis];
        if (by.mantissa == 0) continue;
        number(own.word, own.word.value + by, own.word.style);
        ++out_.counts.changed_words;
      }
    }
  if (feed.word && block.has_feed_word()) {
    if (feed.timed && text_.time_in_seconds) {
      std::string time = "FT";
      append_number(time, *feed.word, {});
      replace(block.feed_word.text, block.feed_word.end, time);
    } else {
      number(block.feed_word, *feed.word, block.feed_word.style);
      edits.back().axis = false;
    }
  }
  const bool mode_word = block.extras && block.extras->feed_mode_word.stands();
  const bool reciprocal = feed.timed && !text_.time_in_seconds;
  if (reciprocal && mode_word) replace(block.extras->feed_mode_word.text, block.extras->feed_mode_word.end, "G93");
  const std::string code = feed.arc_code == 0 ? "" : arc_code(block, feed.arc_code);
  if (!code.empty() && block.motion_word.stands()) replace(block.motion_word.text, block.motion_word.end, code);

  // Words to be added stand behind the last word of the move, codes before the first.
  const bool add_mode = reciprocal && !mode_word;
  const bool add_code = !code.empty() && !block.motion_word.stands();
  bool add = feed.word && !block.has_feed_word();
  for (std::size_t i = 0; i < kWords; ++i) add |= words[i] && word_of(block, i) == nullptr;
  std::ranges::sort(edits, {}, &Edit::text);
  if (last_word == block.begin) first_word = last_word = std::max(block.motion_word.end, block.begin);

  std::size_t next = 0;
  const auto edit_before = [&](std::uint32_t place) {
    for (; next < edits.size() && edits[next].text < place; ++next) {
      const Edit& edit = edits[next];
      if (edit.value) {
        copy_to(edit.number);
        edit.axis ? append_number_in(*edit.value, edit.style) : append_number(out_.text, *edit.value, edit.style);
        copied_ = edit.number_end;
        continue;
      }
      copy_to(edit.text);
      if (edit.whole.empty())
        while (out_.text.ends_with(' ') || out_.text.ends_with('\t')) out_.text.pop_back();
      out_.text += edit.whole;
      copied_ = edit.end;
    }
  };
  if (add_mode || add_code) {
    edit_before(first_word);
    copy_to(first_word);
    const std::string_view apart = block.blank_before_words ? " " : "";
    if (add_mode) out_.text.append("G93").append(apart);
    if (add_code) out_.text.append(code).append(apart);
    out_.counts.added_words += add_code;
  }
  if (add) {
    edit_before(last_word);
    copy_to(std::max(last_word, copied_));
    add_words(block, words, feed, false);
  }
  edit_before(block.end);
}

void BlockText::end_line(const MotionBlock& block) {
  copy_to(block.end);
  if (line_end(source_.substr(block.begin, block.end - block.begin)).empty()) out_.text += '\n';
}

/// Where every block names its function: the number of the block and the function.
void BlockText::append_block_begin(const MotionBlock& block) {
  if (!text_.function_in_every_block) return;
  const std::uint32_t function = block.motion_word.text;
  out_.text.append(source_.substr(block.begin, function - block.begin));
  const std::string_view own = source_.substr(function, block.motion_word.end - function);
  out_.text.append(block.arc() != nullptr ? text_.line_code : own);
}

void BlockText::insert(const MotionBlock& block, const NewWords& words, const NewFeed& feed) {
  append_block_begin(block);
  add_words(block, words, feed, true);
  insert_line_end(block);
}

void BlockText::restore_feed(const MotionBlock& block) {
  if (text_.time_in_seconds) {
    // FT holds for its block; an F that the block said is said again for those that follow.
    if (!block.has_feed_word()) return;
    append_block_begin(block);
    out_.text += ' ';
    append_feed(block, {.word = feed_decimal(block.feed)}, false);
    return insert_line_end(block);
  }
  // F counts in the units of the block that says it, as mm for X Y Z and as degrees for the rotary axes.
  const bool other_unit = block.feed_unit_mm != block.unit_mm;
  if (other_unit) {
    out_.text += block.feed_unit_mm == 1 ? "G21" : "G20";
    insert_line_end(block);
  }
  out_.text += "G94";
  append_feed(block, {.word = feed_decimal(block.feed)}, true);
  insert_line_end(block);
  if (other_unit) {
    out_.text += block.unit_mm == 1 ? "G21" : "G20";
    insert_line_end(block);
  }
}

void BlockText::insert_line_end(const MotionBlock& block) {
  const std::string_view end = line_end(source_.substr(block.begin, block.end - block.begin));
  if (text_.semicolon_ends_block && source_.substr(block.begin, block.end - block.begin).find(';') != std::string::npos)
    out_.text += ';';
  out_.text += end.empty() ? "\n" : end;
  ++out_.counts.inserted_blocks;
  if (out_.inserted.empty() || out_.inserted.back().line != block.line) out_.inserted.push_back({block.line, 0});
  ++out_.inserted.back().count;
}

}  // namespace trunnion
