#pragma once

#include <string>
#include <vector>

#include "compensation/controller.h"

// The files of a FANUC 30i: parameters with pitch errors as a parameter file, and the same as a program of G10 blocks.

namespace trunnion::fanuc {

constexpr const char* kParameterFile = "PARAM.TXT";
constexpr const char* kProgramFile = "G10.NC";
constexpr const char* kUnroundedFile = "PARAM.FULL";  ///< no control's: tells what spacing and rounding cost
constexpr long kPitchBase = 10000;                    ///< number of pitch point 0 among the parameters

/// One parameter: number, axis (0: none), value.
struct Entry {
  long number = 0, axis = 0;
  double value = 0;
  bool real = false;  ///< written with decimals
};

double detection_unit_deg(const CompensationTask& task);

/// N…A…P…; blocks between two %.
TableFile parameter_file(const std::vector<Entry>& entries, Emission emission);
/// The same behind G10 L52, as program O9000 with a comment.
TableFile program_file(const std::vector<Entry>& entries, const std::string& comment);

/// Both readers refuse what the control would refuse, by an InputError with the line: line ends other than LF, % not
/// alone on the first and the last line, small letters, a missing or stray ;, numbers with exponents, fractions where
/// pulses are counted, pitch errors beyond +-7, a parameter that stands twice.
std::vector<Entry> read_parameters(const TableFile& file);
std::vector<Entry> read_program(const TableFile& file);

/// The control with these files in it. Throws InputError also where the two files do not say the same.
std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task);

}  // namespace trunnion::fanuc
