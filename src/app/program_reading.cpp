#include "app/program_reading.h"

#include "postproc/chunk_writer.h"
#include "postproc/dialect.h"

namespace trunnion {
namespace {

/// What the machine file says of its control.
ControlFacts control_facts(const Machine& machine) {
  ControlFacts facts;
  const auto take = [&](const std::string& key, std::string& fact) {
    if (const auto found = machine.profile.find("control." + key); found != machine.profile.end())
      fact = std::get<std::string>(found->second);
  };
  take("tcp_frame", facts.tcp_frame);
  take("whole_numbers", facts.whole_numbers);
  take("turn_path", facts.turn_path);
  take("orientation_path", facts.orientation_path);
  return facts;
}

}  // namespace

std::string dialect_of(std::string_view head, const Machine& machine) {
  if (const std::string_view told = told_dialect(head); !told.empty()) return std::string(told);
  for (const std::string& name : dialect_names())
    if (!machine.controller.empty() && dialect(name).controller == machine.controller) return name;
  return "";
}

ScanSettings scan_settings(const std::string& dialect_name, const Machine& machine, const KinematicChain& chain,
                           const Job& job) {
  ScanSettings scan;
  scan.letters[kTilt] = machine.tilt_letter();
  scan.work_offsets_mm = job.work_offsets_mm;
  scan.tcp = !dialect(dialect_name).says_tcp && machine.tcp == "on";
  scan.control = control_facts(machine);
  scan.modulo_turn = machine.turn().modulo;
  scan.chain = &chain;
  scan.tilt_stroke_deg = guard_of(machine).stroke[kTilt];
  return scan;
}

}  // namespace trunnion
