#pragma once

#include <cstddef>

// What trunnion_brep.so offers, in C, so that OpenCASCADE is loaded only by who asks for a solid.
extern "C" {

/// A cone frustum on a square block, in W: mm and rad. The block stands below the base, within it.
struct TrunnionBrepFrustum {
  double half_angle_rad;
  double base_diameter_mm;
  double height_mm;
  double base_center_mm[3];
  double axis[3];  ///< unit vectors: the cone's axis, and where phi is zero
  double zero[3];
  double block_side_mm;
  double block_height_mm;
};

/// A ruling of the flank: where it meets the base's circle, mm, the outward normal there, and its direction away from
/// the base; unit vectors.
struct TrunnionBrepRuling {
  double point_mm[3];
  double normal[3];
  double along[3];
};

using TrunnionBrepWrite = void (*)(void* target, const char* text, std::size_t size);

/// Hands the solid as STEP AP242 text to `write`, the same bytes every time. Returns 0, or 1 with a line in `problem`.
using TrunnionBrepStep = int (*)(const TrunnionBrepFrustum* frustum, TrunnionBrepWrite write, void* target,
                                 char* problem, std::size_t problem_size);
/// Reads STEP text back: volume in mm^3, number of faces, semi-angle of its first conical face (0: none). Returns
/// alike.
using TrunnionBrepMeasure = int (*)(const char* text, std::size_t size, double* volume_mm3, int* faces,
                                    double* semi_angle_rad, char* problem, std::size_t problem_size);
/// The solid's flank, to be asked for its rulings and closed; null, with a line in `problem`, if it cannot be made.
using TrunnionBrepFlankOpen = void* (*)(const TrunnionBrepFrustum* frustum, char* problem, std::size_t problem_size);
/// The ruling at `phi_rad` about the axis, from the parametrisation of the face.
using TrunnionBrepFlankAt = void (*)(const void* flank, double phi_rad, TrunnionBrepRuling* ruling);
using TrunnionBrepFlankClose = void (*)(void* flank);
}

inline constexpr const char* kTrunnionBrepStep = "trunnion_brep_step";
inline constexpr const char* kTrunnionBrepMeasure = "trunnion_brep_measure";
inline constexpr const char* kTrunnionBrepFlankOpen = "trunnion_brep_flank_open";
inline constexpr const char* kTrunnionBrepFlankAt = "trunnion_brep_flank_at";
inline constexpr const char* kTrunnionBrepFlankClose = "trunnion_brep_flank_close";
