#include "postproc/program_correction.h"

#include <algorithm>
#include <cctype>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "error.h"
#include "postproc/block.h"
#include "postproc/dialect.h"
#include "postproc/program_state.h"

namespace trunnion {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 16;
constexpr std::size_t kHead = 512;  // the program's name and the like stand in its first chunk

/// What may stand in a comment of any dialect.
std::string harmless(const std::string& words) {
  std::string text;
  for (const char c : words) {
    const bool plain = c >= 0x20 && c < 0x7f;
    text += !plain ? '?' : c == '(' ? '[' : c == ')' ? ']' : c == '%' || c == ';' ? ' ' : c;
  }
  return text;
}

std::string header_comment(const DialectText& dialect, const std::string& header) {
  return std::string(dialect.comment_open) + std::string(kCorrectedMark) + ": " + harmless(header) +
         std::string(dialect.comment_close);
}

/// A piece of the program that ends with a line.
struct Chunk {
  std::string text;
  ScannedChunk scanned;
  std::size_t number = 0;
};

/// Cuts a program into chunks of whole lines.
class ChunkReader {
 public:
  ChunkReader(ReadBytes read, std::size_t size) : read_(std::move(read)), size_(std::max(size, std::size_t{16})) {}

  /// False at the end.
  bool next(std::string& text) {
    text.swap(rest_);
    rest_.clear();
    const std::size_t wanted = first_ ? std::max(size_, kHead) : size_;
    first_ = false;
    while (!at_end_) {
      const std::size_t had = text.size();
      text.resize(had + wanted);
      const std::size_t got = read_(text.data() + had, wanted);
      text.resize(had + got);
      at_end_ = got == 0;
      if (at_end_) break;
      // Two bytes more must be there to tell LF from LF CR CR.
      if (text.size() < wanted + 3) continue;
      const std::size_t newline = text.rfind('\n', text.size() - 4);
      if (newline == std::string::npos) {
        if (text.size() > kLongestLine + size_) break;  // the scan says so
        continue;
      }
      const std::size_t end = newline + line_length(std::string_view(text).substr(newline));
      rest_.assign(text, end);
      text.resize(end);
      break;
    }
    return !text.empty();
  }

 private:
  ReadBytes read_;
  std::size_t size_;
  std::string rest_;
  bool at_end_ = false, first_ = true;
};

/// The work of correct_program: each worker takes the next chunk and scans it while it alone may read, corrects it on
/// its own, and writes it when its turn has come.
class Pipeline {
 public:
  Pipeline(const OpenProgram& open, const WriteBytes& write, const ProgramCorrection& how)
      : open_(open),
        write_(write),
        how_(how),
        dialect_(dialect(how.dialect)),
        reader_(open(), how.chunk_bytes),
        scanner_(dialect_.scanner(how.scan)) {}

  ProgramCorrectionResult run(const Corrector& with_tcp, const Corrector& without_tcp) {
    const int workers = how_.scan.keep_going ? 1 : std::max(1, how_.threads);
    const auto work_through = [&] {
      try {
        ChunkWriter writer(with_tcp, without_tcp, how_.guard, how_.scan.letters, dialect_.text, how_.scan.keep_going);
        Chunk chunk;
        while (take(chunk)) {
          CorrectedChunk corrected;
          std::exception_ptr error;
          try {
            corrected = writer.write(chunk.text, chunk.scanned);
          } catch (...) {
            error = std::current_exception();
          }
          put(chunk, corrected, error);
        }
      } catch (...) {
        fail(std::current_exception());
      }
    };
    {
      std::vector<std::jthread> others;
      for (int i = 1; i < workers; ++i) others.emplace_back(work_through);
      work_through();
    }
    if (failure_) std::rethrow_exception(failure_);
    if (!header_written_) copy_input(~std::uint64_t{0});
    return result_;
  }

 private:
  bool take(Chunk& chunk) {
    const std::lock_guard lock(read_mutex_);
    if (stop_reading_ || !reader_.next(chunk.text)) return false;
    chunk.number = taken_++;
    chunk.scanned.blocks.clear();
    chunk.scanned.refusals.clear();
    chunk.scanned.lines = chunk.scanned.copied_moves = chunk.scanned.untimed_moves = 0;
    chunk.scanned.assumptions = 0;
    chunk.scanned.before = last_corrected_;
    const std::string_view text = chunk.text;
    const bool byte_order_mark = chunk.number == 0 && text.starts_with(kByteOrderMark);
    for (std::size_t at = byte_order_mark ? kByteOrderMark.size() : 0; at < text.size();) {
      const std::size_t length = line_length(text.substr(at));
      if (length > kLongestLine) {
        chunk.scanned.refusals.push_back(
            {lines_ + chunk.scanned.lines + 1, "a line of more than 65536 bytes", Refusal::Kind::bad_input});
        stop_reading_ = true;
        break;
      }
      if (!scanner_->scan(text.substr(at, length), static_cast<std::uint32_t>(at), chunk.scanned)) {
        stop_reading_ = true;
        break;
      }
      at += length;
    }
    lines_ += chunk.scanned.lines;
    for (auto block = chunk.scanned.blocks.rbegin(); block != chunk.scanned.blocks.rend(); ++block)
      if (block->kind != BlockKind::set_position) {
        last_corrected_ = *block;
        break;
      }
    return true;
  }

  /// Waits for the chunk's turn, so that of several failures the program's first is told.
  void put(const Chunk& chunk, const CorrectedChunk& corrected, const std::exception_ptr& error) {
    std::unique_lock lock(write_mutex_);
    turn_.wait(lock, [&] { return written_ == chunk.number || failure_; });
    if (failure_) return;
    if (error) std::rethrow_exception(error);
    for (const Refusal& refusal : corrected.refusals) {
      const std::string text = how_.name + ":" + std::to_string(refusal.line) + ": " + refusal.reason;
      if (refusal.kind == Refusal::Kind::bad_input) throw InputError(text);
      if (!how_.scan.keep_going && refusal.kind == Refusal::Kind::out_of_range) throw RangeError(text);
      if (!how_.scan.keep_going || refusal.kind == Refusal::Kind::for_good) throw RefusalError(text);
      if (result_.refusals.size() < kMostRefusals) result_.refusals.push_back(refusal);
    }
    result_.counts += corrected.counts;
    if (how_.keep_insertions)
      result_.inserted.insert(result_.inserted.end(), corrected.inserted.begin(), corrected.inserted.end());
    if (chunk.number == 0) find_header_place(chunk.text);
    if (!header_written_ && result_.counts.changed()) {
      if (chunk.number == 0) {
        // Nothing is changed before the header's place: % and names are never rewritten.
        write_(std::string_view(corrected.text).substr(0, header_place_));
        write_header();
        write_(std::string_view(corrected.text).substr(header_place_));
      } else {
        copy_input(unchanged_bytes_);
        write_(corrected.text);
      }
      header_written_ = true;
      result_.header_line = header_line_;
    } else if (header_written_) {
      write_(corrected.text);
    }
    unchanged_bytes_ += chunk.text.size();
    if (how_.progress) how_.progress(unchanged_bytes_);
    ++written_;
    turn_.notify_all();
  }

  void find_header_place(std::string_view text) {
    header_place_ = header_place(dialect_, text);
    const std::string_view before = text.substr(0, header_place_);
    header_line_ = 1 + static_cast<std::uint64_t>(std::count(before.begin(), before.end(), '\n'));
    const std::string_view end = line_end(text.substr(0, line_length(text)));
    header_end_ = end.empty() ? "\n" : end;
  }

  void write_header() { write_(header_comment(dialect_.text, how_.header) + header_end_); }

  /// The first `bytes` of the input, as they are, with the header unless it is the whole.
  void copy_input(std::uint64_t bytes) {
    const ReadBytes read = open_();
    std::string buffer(how_.chunk_bytes + header_place_, '\0');
    const bool whole = bytes == ~std::uint64_t{0};
    std::uint64_t place = whole ? bytes : header_place_;
    if (!whole && place == 0) write_header();
    for (std::uint64_t done = 0; done < bytes;) {
      const std::uint64_t limit = done < place ? place : bytes;
      const std::size_t got =
          read(buffer.data(), static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), limit - done)));
      if (got == 0) {
        if (whole) return;
        throw InputError(how_.name, "the file changed while it was read");
      }
      write_(std::string_view(buffer).substr(0, got));
      done += got;
      if (!whole && done == place) write_header();
    }
  }

  void fail(std::exception_ptr error) {
    {
      const std::lock_guard lock(write_mutex_);
      if (!failure_) failure_ = std::move(error);
      turn_.notify_all();
    }
    const std::lock_guard lock(read_mutex_);
    stop_reading_ = true;
  }

  const OpenProgram& open_;
  const WriteBytes& write_;
  const ProgramCorrection& how_;
  const Dialect& dialect_;

  std::mutex read_mutex_;
  ChunkReader reader_;
  std::unique_ptr<ProgramScanner> scanner_;
  bool stop_reading_ = false;
  std::size_t taken_ = 0;
  std::uint64_t lines_ = 0;
  std::optional<MotionBlock> last_corrected_;

  std::mutex write_mutex_;
  std::condition_variable turn_;
  std::size_t written_ = 0;
  std::exception_ptr failure_;
  ProgramCorrectionResult result_;
  std::uint64_t unchanged_bytes_ = 0;
  bool header_written_ = false;
  std::size_t header_place_ = 0;
  std::uint64_t header_line_ = 0;
  std::string header_end_ = "\n";
};

}  // namespace

OpenProgram opened(const std::string& text) {
  return [&text] {
    return [&text, at = std::size_t{0}](char* buffer, std::size_t size) mutable {
      const std::size_t taken = text.copy(buffer, size, at);
      at += taken;
      return taken;
    };
  };
}

void refuse_other_serial(std::string_view program, const std::string& serial, const std::string& name) {
  const std::size_t mark = find_mark(program);
  if (mark == std::string_view::npos) return;
  std::string header(program.substr(mark, program.find_first_of(")\r\n", mark) - mark)), wanted = harmless(serial);
  constexpr std::string_view kSerial = ", serial ";  // the last that a header says
  // A control may have made capitals of all letters.
  for (std::string* text : {&header, &wanted})
    for (char& letter : *text) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  const std::size_t at = header.rfind(kSerial);
  if (at == std::string::npos || header.substr(at + kSerial.size()) == wanted) return;
  const std::string_view before = program.substr(0, mark);
  throw RefusalError(name + ":" + std::to_string(1 + std::count(before.begin(), before.end(), '\n')) +
                     ": corrected for a machine with serial number \"" +
                     std::string(program.substr(mark + at + kSerial.size(), header.size() - at - kSerial.size())) +
                     "\", the machine file says \"" + serial + "\"");
}

ProgramCorrectionResult correct_program(const OpenProgram& open, const WriteBytes& write, const Corrector& with_tcp,
                                        const Corrector& without_tcp, const ProgramCorrection& how) {
  return Pipeline(open, write, how).run(with_tcp, without_tcp);
}

}  // namespace trunnion
