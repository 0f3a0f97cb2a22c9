#pragma once

#include <memory>
#include <optional>
#include <string>

#include "postproc/motion.h"

namespace trunnion {

/// One move of a played program: all five axes, and how it runs between.
struct PlayedMove {
  AxisValues from{}, to{};  ///< the program's zero included, mm and deg; NaN where the program has not said
  bool feed = false;
  bool tcp = true;                                      ///< X Y Z are of W
  bool straight_on_part = false;                        ///< they are of R, but the tip goes straight in W
  Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();  ///< of X Y Z in W, where a plane is tilted
  Eigen::Vector3d frame_origin_mm = Eigen::Vector3d::Zero();
  bool great_circle = false;  ///< the tool axis goes from one direction to the other in one plane
  bool arc = false;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), along = Eigen::Vector3d::Zero(), across = Eigen::Vector3d::Zero();
  double sweep_rad = 0;
  double seconds = 0;                         ///< at feed, 0 where it is not known
  int tilt_sense = 1, turn_sense = 1;         ///< of the last motion of either rotary axis
  std::array<std::int8_t, 3> linear_sense{};  ///< of the slides, 0 where not known

  bool begins_known() const;
  /// X Y Z of W or R, A and C after the part `s` of the way.
  AxisValues at(double s, const KinematicChain* chain) const;
  /// Millimetres, or degrees where X Y Z stand still.
  double way() const;

 private:
  void turn_in_one_plane(AxisValues& place, double s, const KinematicChain& chain) const;
};

/// A plain reader of one dialect, an if per code, that shares no code with the scans. Enough for programs that a scan
/// has let through.
class PlainPlayer {
 public:
  virtual ~PlainPlayer() = default;
  /// The move that a line makes with all axes known behind it.
  virtual std::optional<PlayedMove> play(const std::string& line) = 0;
  /// Where the axes stand is not known until they are programmed again.
  virtual void forget() = 0;
};

/// The whole part of a number that tells a code or a choice; -1 where it is beyond all of them.
int code_number(double value);

/// A player of the dialect of that name; of the dialects of DIN 66025; of HEIDENHAIN's Klartext.
std::unique_ptr<PlainPlayer> plain_player(const std::string& dialect, const ScanSettings& settings);
std::unique_ptr<PlainPlayer> plain_iso_player(const std::string& dialect, const ScanSettings& settings);
std::unique_ptr<PlainPlayer> plain_klartext_player(const ScanSettings& settings);

/// The rotary position that holds the tool along `axis_w`, found by descent from many starts: the one nearest to
/// `tilt_deg` and `turn_deg` (NaN: not known), within the stroke. Tilt and turn in deg.
std::array<double, 2> descended_to_axis(const ScanSettings& settings, const Eigen::Vector3d& axis_w, double tilt_deg,
                                        double turn_deg);

}  // namespace trunnion
