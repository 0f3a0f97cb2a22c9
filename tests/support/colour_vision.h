#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

/// What colours look like to those who see fewer of them, and how far apart two colours are.
namespace trunnion::testing {

using Srgb = std::array<double, 3>;       ///< 0 … 255
using LinearRgb = std::array<double, 3>;  ///< light, 0 … 1
using Lab = std::array<double, 3>;        ///< CIE 1976 L*, a*, b*, white D65

enum class Vision { normal, protanopia, deuteranopia, tritanopia };
constexpr Vision kVisions[] = {Vision::normal, Vision::protanopia, Vision::deuteranopia, Vision::tritanopia};

using Matrix3 = std::array<std::array<double, 3>, 3>;

inline std::array<double, 3> product(const Matrix3& m, const std::array<double, 3>& v) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}

/// IEC 61966-2-1.
inline LinearRgb linear_light(const Srgb& colour) {
  LinearRgb light{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double c = colour[i] / 255;
    light[i] = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  }
  return light;
}

/// Machado, Oliveira & Fernandes (2009), A physiologically-based model for simulation of color vision deficiency, IEEE
/// Trans. Vis. Comput. Graph. 15(6): the matrices for linear RGB at severity 1.
inline Matrix3 as_seen(Vision vision) {
  switch (vision) {
    case Vision::protanopia:
      return {{{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}};
    case Vision::deuteranopia:
      return {{{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}};
    case Vision::tritanopia:
      return {{{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}}};
    case Vision::normal:
      break;
  }
  return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

inline Lab lab_of(const LinearRgb& light) {
  constexpr Matrix3 kXyz = {
      {{0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.0721750}, {0.0193339, 0.1191920, 0.9503041}}};
  constexpr std::array<double, 3> kWhite = {0.95047, 1, 1.08883};
  std::array<double, 3> f = product(kXyz, light);
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = f[i] / kWhite[i];
    f[i] = t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
  }
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

inline Lab seen(const Srgb& colour, Vision vision) {
  LinearRgb light = product(as_seen(vision), linear_light(colour));
  for (double& c : light) c = std::clamp(c, 0.0, 1.0);
  return lab_of(light);
}

/// CIEDE2000: Sharma, Wu & Dalal (2005), The CIEDE2000 color-difference formula, Color Res. Appl. 30(1), Eqs. (2)-(22).
inline double ciede2000(const Lab& one, const Lab& two) {
  constexpr double kDeg = std::numbers::pi / 180;
  const auto power7 = [](double c) { return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25.0, 7))); };
  const double g = 0.5 * (1 - power7((std::hypot(one[1], one[2]) + std::hypot(two[1], two[2])) / 2));
  const double a1 = (1 + g) * one[1], a2 = (1 + g) * two[1];
  const double c1 = std::hypot(a1, one[2]), c2 = std::hypot(a2, two[2]);
  const auto hue = [](double a, double b) {
    const double h = a == 0 && b == 0 ? 0 : std::atan2(b, a) / kDeg;
    return h < 0 ? h + 360 : h;
  };
  const double h1 = hue(a1, one[2]), h2 = hue(a2, two[2]);
  const bool grey = c1 * c2 == 0;
  double dh = grey ? 0 : h2 - h1, h = grey ? h1 + h2 : (h1 + h2) / 2;
  if (!grey && std::abs(h1 - h2) > 180) {
    dh += dh > 0 ? -360 : 360;
    h += h1 + h2 < 360 ? 180 : -180;
  }
  const double dl = two[0] - one[0], dc = c2 - c1, dhue = 2 * std::sqrt(c1 * c2) * std::sin(dh / 2 * kDeg);
  const double l = (one[0] + two[0]) / 2, c = (c1 + c2) / 2;
  const double t = 1 - 0.17 * std::cos((h - 30) * kDeg) + 0.24 * std::cos(2 * h * kDeg) +
                   0.32 * std::cos((3 * h + 6) * kDeg) - 0.20 * std::cos((4 * h - 63) * kDeg);
  const double sl = 1 + 0.015 * (l - 50) * (l - 50) / std::sqrt(20 + (l - 50) * (l - 50));
  const double sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
  const double turn_deg = 30 * std::exp(-std::pow((h - 275) / 25, 2));
  const double rt = -2 * power7(c) * std::sin(2 * turn_deg * kDeg);
  return std::sqrt(std::pow(dl / sl, 2) + std::pow(dc / sc, 2) + std::pow(dhue / sh, 2) + rt * dc / sc * dhue / sh);
}

/// How far apart two colours are to whoever tells them apart worst.
inline double least_difference(const Srgb& one, const Srgb& two) {
  double least = 1e3;
  for (const Vision vision : kVisions) least = std::min(least, ciede2000(seen(one, vision), seen(two, vision)));
  return least;
}

/// Contrast ratio of WCAG 2.2, 1 … 21.
inline double contrast(const Srgb& one, const Srgb& two) {
  const auto luminance = [](const Srgb& colour) {
    const LinearRgb light = linear_light(colour);
    return 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
  };
  const auto [dark, bright] = std::minmax({luminance(one), luminance(two)});
  return (bright + 0.05) / (dark + 0.05);
}

}  // namespace trunnion::testing
