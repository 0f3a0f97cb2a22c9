#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "postproc/chunk_writer.h"

namespace trunnion {

/// Fills a buffer with the next bytes of a program; 0 at its end.
using ReadBytes = std::function<std::size_t(char* buffer, std::size_t size)>;
/// Opens a program at its beginning, as often as asked.
using OpenProgram = std::function<ReadBytes()>;

/// The bytes of a text, opened as often as asked; `text` must outlive it.
OpenProgram opened(const std::string& text);
/// Takes the next bytes of what is written.
using WriteBytes = std::function<void(std::string_view)>;
/// Told how many bytes of the input are done.
using ReportProgress = std::function<void(std::uint64_t)>;

/// How a program is corrected.
struct ProgramCorrection {
  std::string dialect = "linuxcnc";
  ScanSettings scan;
  CorrectionGuard guard;
  /// What the header comment says behind "corrected by trunnion: "; blanks, brackets and what is not ASCII are made
  /// harmless.
  std::string header;
  std::string name = "program";  ///< for messages
  int threads = 2;
  std::size_t chunk_bytes = std::size_t{1} << 18;
  bool keep_insertions = false;  ///< to play the result back
  ReportProgress progress;
};

inline constexpr std::size_t kMostRefusals = 100000;  ///< told one by one

/// What correct_program did.
struct ProgramCorrectionResult {
  CorrectionCounts counts;
  std::vector<Refusal> refusals;    ///< only where keep_going was asked for; ascending lines
  std::uint64_t header_line = 0;    ///< of the output, from 1; 0: none
  std::vector<Insertion> inserted;  ///< ascending; kept if `keep_insertions`
};

/// Throws RefusalError where `program` says, in the header comment of a correction, that it is for a machine of another
/// serial number than `serial`; `name` stands for the program in the message.
void refuse_other_serial(std::string_view program, const std::string& serial, const std::string& name);

/// Writes the corrected program: chunks are scanned one after another, corrected on several threads and written in
/// order, so that neither the result nor the memory depends on their number or the program's size. A program that needs
/// no change is written as it is. Throws for the first block that is refused (RefusalError), out of range (RangeError)
/// or no block at all (InputError), the message beginning "name:line: "; what was written so far is then worth nothing.
ProgramCorrectionResult correct_program(const OpenProgram& open, const WriteBytes& write, const Corrector& with_tcp,
                                        const Corrector& without_tcp, const ProgramCorrection& how);

}  // namespace trunnion
