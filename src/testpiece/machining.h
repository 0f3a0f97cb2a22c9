#pragma once

#include <span>
#include <vector>

#include "model/model.h"
#include "testpiece/cone_evaluation.h"
#include "testpiece/cut_envelope.h"
#include "testpiece/tool_path.h"

namespace trunnion {

/// The evaluated points of a piece: height by height, within each phi = 360 k / points from 0.
struct SurfaceGrid {
  std::vector<double> phi_rad;
  std::vector<double> h_mm;
  std::vector<ConePoint> points;  ///< [i_height * phi_rad.size() + k]
};
/// Those that the piece's file asks for.
SurfaceGrid evaluated_surface(const TestPiece& piece);

/// The moment of a commanded position, as the machine's effects see it. `known` carries what the path does not know:
/// temperature and extra columns.
Situation situation_at(const ToolPosition& position, Length tool_length, const Situation& known = {});

/// Where the commanded positions really bring the tool in the workpiece: the workpiece stands displaced by T(e) against
/// the tool, e the machine's relative error, so that the tool appears at  r_from_w^-1 T(e)^-1 (tip, axis).  Exact.
std::vector<ToolInWorkpiece> actual_tools(std::span<const ToolPosition> path, const KinematicChain& chain,
                                          const Model& model, Length tool_length, const Situation& known = {},
                                          unsigned threads = 0);

/// The deviation along the outward normal at every evaluated point, mm, positive: excess material; in the order of
/// `surface.points`.
///
/// - first order: by the position that is meant to cut there, dev = (distance of the point from the tool's axis in the
///   plane of its normal) - radius, to first order -n . d; several positions at the same phi: the smallest.
/// - envelope: the first entry along the normal over all positions.
/// Throws RangeError where nothing cuts.
std::vector<double> first_order_deviation_mm(const TestPiece& piece, const SurfaceGrid& surface,
                                             std::span<const ToolPosition> path,
                                             std::span<const ToolInWorkpiece> tools);
std::vector<double> envelope_deviation_mm(const TestPiece& piece, const SurfaceGrid& surface,
                                          std::vector<ToolInWorkpiece> tools, unsigned threads = 0);

/// A point of the nominal surface at the moment when it is meant to be cut, and what a small error e of the workpiece
/// against the tool does to it then, to first order:
///   deviation = commanded + by_error . e,   by_error = -[n, p x n]      (e = (D, theta) at R's origin, p and n in R).
struct CutPoint {
  std::size_t position = 0;  ///< of the path that cuts it, as commanded
  double commanded_mm = 0;   ///< what the commands alone leave there; nothing on a path of the piece's own
  Eigen::Vector3d point_r_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_r = Eigen::Vector3d::Zero();
  Vector6d by_error = Vector6d::Zero();
};
/// In the order of `points`. Throws RangeError where nothing cuts.
std::vector<CutPoint> cut_points(const TestPiece& piece, std::span<const ConePoint> points,
                                 std::span<const ToolPosition> path, const KinematicChain& chain, unsigned threads = 0);

/// The deviations as traces to evaluate.
std::vector<ConeTrace> traces_of(const TestPiece& piece, const SurfaceGrid& surface,
                                 std::span<const double> deviation_mm);

}  // namespace trunnion
