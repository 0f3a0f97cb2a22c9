#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>

#include "geometric_errors/pose_error.h"
#include "kinematics/kinematic_chain.h"
#include "model/situation.h"
#include "postproc/number.h"

namespace trunnion {

/// What a correction asks of a model: the pose error Delta of the workpiece relative to the tool, taken at R's origin,
///   p_actual = T(Delta) p_nominal   (CONTRACT, Frames and signs),
/// where the axes are commanded to situation.at and the nominal tip stands at situation.point_r_mm. To be called from
/// several threads at once.
class ErrorField {
 public:
  virtual ~ErrorField() = default;
  virtual PoseError at(const Situation& situation) const = 0;
  /// The same, never by a faster image of it: for judging.
  virtual PoseError exactly_at(const Situation& situation) const { return at(situation); }
  /// The same with its derivatives by A and C, per rad; here by differences.
  struct Slopes {
    PoseError error;
    PoseError by_a;
    PoseError by_c;
    bool smooth = false;  ///< so exact that the error half a milliradian off may be told by them
  };
  virtual Slopes with_slopes(const Situation& situation) const;
  /// Whether the error of one place may differ with the senses of motion.
  virtual bool knows_senses() const { return true; }
  /// The tilts that were measured. at() answers half a degree beyond them, for the correction's own step.
  virtual Range<Angle> tilt_range() const = 0;
};

/// What X Y Z of a program mean (CONTRACT, Job): workpiece coordinates that turn with the table, or machine
/// coordinates.
enum class ToolCentrePoint { on, off };
/// Whether the rotary axes are corrected as well, or the position alone.
enum class Orientation { corrected, as_programmed };

/// One commanded place: X Y Z of the program plus work offset, and the rotary axes.
struct Commanded {
  Eigen::Vector3d xyz_mm;
  IndexedPosition rotary;
  int tilt_sense = 1;  ///< sense of the last motion of either rotary axis
  int turn_sense = 1;
  std::array<std::int8_t, 3> linear_sense{};  ///< of the slides; 0: not known
  double time_s = 0;                          ///< since the program's begin
};

/// How the commands of a program are corrected.
struct CorrectionSettings {
  ToolCentrePoint tcp = ToolCentrePoint::on;
  Orientation orientation = Orientation::corrected;
  Angle largest_rotary_change = Angle::degrees(0.1);  ///< limits.correction_C_deg
  Angle damping = Angle::degrees(1);                  ///< lambda = sin(damping)
  double tool_length_mm = 0;                          ///< matters with a rotary axis on the tool side
};

/// The rotary axes to command, and what of the tilt error they leave.
struct RotaryCorrection {
  Angle da;        ///< to add to the tilting axis
  Angle dc;        ///< to add to the turning axis
  Angle residual;  ///< angle left between tool axis and wanted axis, before rounding
};

/// Commands that put the real tool where the nominal machine would have it (docs/math/correction.md). With
///   p the wanted tip and u the wanted tool axis in W, both from the nominal kinematics of the programmed place,
///   v(A,C) = R(Delta(A,C)) R~w(A,C) u   the wanted axis on the real machine, z(A,C) = R~t(A,C) e_z the tool's,
/// the rotary axes minimise |v - z|^2 + lambda^2 (C' - C)^2 near the programmed ones, the change of C kept below
/// `largest_rotary_change` by a smooth saturation. Then, at whatever angles are commanded,
///   tcp off: XYZ = T(Delta) r_from_w p - r_from_t (0, 0, -L)        tcp on: XYZ = r_from_w^-1 T(Delta) r_from_w p,
/// exact. Nothing depends on the blocks before.
class Corrector {
 public:
  /// `chain` and `field` must outlive it.
  Corrector(const KinematicChain& chain, const ErrorField& field, CorrectionSettings settings);

  const CorrectionSettings& settings() const { return settings_; }
  const KinematicChain& chain() const { return chain_; }
  const ErrorField& field() const { return field_; }
  /// The tilts that the field knows.
  Range<Angle> tilt_range() const { return field_.tilt_range(); }

  /// Where the nominal machine puts the tip: in W and in R, mm.
  Eigen::Vector3d nominal_tip_w(const Commanded& programmed) const;
  Eigen::Vector3d nominal_tip_r(const Commanded& programmed) const;

  /// The rotary part at a programmed place; all zero where the orientation is left as programmed.
  RotaryCorrection rotary(const Commanded& programmed) const;

  /// The change of X Y Z, mm, when the rotary axes are commanded to `rotary` instead of programmed.rotary. `error`: the
  /// pose error there, for the limits.
  struct Linear {
    Eigen::Vector3d change_mm;
    PoseError error;
    double deviation_mm;       ///< |d| at the tip
    Eigen::Vector3d tip_r_mm;  ///< where the nominal machine takes the tip with the changed commands
  };
  Linear linear(const Commanded& programmed, IndexedPosition rotary) const;

  /// Where the slides stand that hold the tip there, R.
  Eigen::Vector3d slides_mm(const Eigen::Vector3d& tip_r_mm, IndexedPosition rotary) const;

  /// Both for one place, the rotary axes rounded to the decimals of their words in deg: what writing a program asks for
  /// line by line. With `rotary_moves` false the rotary axes stay as they are programmed.
  struct Solved {
    RotaryCorrection turn;
    Decimal tilt_deg, turn_deg;  ///< to add to the words
    Angle tilt_by, turn_by;      ///< the same
    IndexedPosition rotary;      ///< where they then stand
    Linear linear;
  };
  Solved solve(const Commanded& programmed, int tilt_decimals, int turn_decimals, bool rotary_moves) const;

  /// The angle between the real tool axis at `rotary` and the one wanted at programmed.rotary.
  Angle tilt_error(const Commanded& programmed, IndexedPosition rotary) const;
  /// The distance in W between the real tip at `commanded` and the wanted one at `programmed`, mm.
  double tip_error_mm(const Commanded& programmed, const Commanded& commanded) const;

 private:
  /// Where the nominal rotary axes stand: the chain's transforms, written out for speed.
  struct Stand {
    Eigen::Matrix3d w_rotation, t_rotation;  // of r_from_w and r_from_t
    Eigen::Vector3d w_origin, t_origin;
    Eigen::Vector3d lines[2];   // the joints' directions in R
    Eigen::Vector3d pivots[2];  // and a point of each
  };
  struct Turns {
    double sine[2], cosine[2];  // of the joints' angles
  };
  Turns turns(IndexedPosition position) const;
  Stand stand(const Turns& turns) const;
  Stand stand(IndexedPosition position) const { return stand(turns(position)); }
  RotaryCorrection rotary(const Stand& here, const ErrorField::Slopes& slopes) const;
  Linear linear(const Commanded& programmed, IndexedPosition rotary, const Stand& meant, const Stand& there,
                const std::optional<PoseError>& known) const;
  Linear linear_on_table(const Commanded& programmed, const Stand& here, const Eigen::Vector3d& nominal,
                         IndexedPosition rotary, double tilt, double turn, const std::optional<PoseError>& known) const;
  Eigen::Vector3d tip_w(const Commanded& programmed, const Stand& at) const;
  Eigen::Vector3d tip_r(const Commanded& programmed, const Stand& at) const;
  Situation situation(const Commanded& programmed, IndexedPosition position, const Eigen::Vector3d& tip_r_mm) const;
  PoseError error_at(const Commanded& programmed, IndexedPosition position, const Eigen::Vector3d& tip_r_mm) const {
    return field_.at(situation(programmed, position, tip_r_mm));
  }

  const KinematicChain& chain_;
  const ErrorField& field_;
  CorrectionSettings settings_;
  bool tool_side_ = false;
  double damping2_ = 0;                   // lambda squared
  Eigen::Matrix3d cross_[2], cross2_[2];  // of the joints' directions at zero, and squared
  bool at_zero_[2];                       // the joint's line goes through R's origin
};

}  // namespace trunnion
