#include "testpiece/colour_bar.h"

#include <charconv>
#include <cmath>
#include <string>

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr int kBands = 64;
constexpr Colour kInk = {40, 40, 40};

/// "+5", "0.2", "-100": a round number with its sign.
std::string signed_text(double value) {
  char text[32];
  const std::string digits(text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6).ptr);
  return value > 0 ? "+" + digits : digits;
}

/// Draws in a plane of W: x to the right, z up, seen from -Y.
class Pen {
 public:
  Pen(Mesh& mesh, const Vector3d& origin_w_mm) : mesh_(mesh), origin_(origin_w_mm) {}

  void rectangle(double x1, double y1, double x2, double y2, Colour c) {
    mesh_.quad({at(x1, y1), at(x2, y1), at(x2, y2), at(x1, y2)}, -Vector3d::UnitY(), c);
  }

  /// Text from its lower left corner on, letters `size` high.
  void write(const std::string& text, double x, double y, double size) {
    const double unit = size / 4, half = 0.2 * unit;
    for (const char letter : text) {
      for (const Stroke& s : strokes_of(letter)) {
        const Eigen::Vector2d from(x + unit * s.x1, y + unit * s.y1), to(x + unit * s.x2, y + unit * s.y2);
        const Eigen::Vector2d along = half * (to - from).normalized(), aside(-along.y(), along.x());
        const auto corner = [&](const Eigen::Vector2d& p) { return at(p.x(), p.y()); };
        mesh_.quad({corner(from - along - aside), corner(to + along - aside), corner(to + along + aside),
                    corner(from - along + aside)},
                   -Vector3d::UnitY(), kInk);
      }
      x += 3 * unit;
    }
  }

 private:
  Vector3d at(double x, double y) const { return origin_ + Vector3d(x, 0, y); }
  Mesh& mesh_;
  Vector3d origin_;
};

}  // namespace

std::vector<Stroke> strokes_of(char letter) {
  switch (letter) {
    case '0':
      return {{0, 0, 2, 0}, {2, 0, 2, 4}, {2, 4, 0, 4}, {0, 4, 0, 0}};
    case '1':
      return {{1, 0, 1, 4}};
    case '2':
      return {{0, 4, 2, 4}, {2, 4, 2, 2}, {2, 2, 0, 2}, {0, 2, 0, 0}, {0, 0, 2, 0}};
    case '3':
      return {{0, 4, 2, 4}, {2, 4, 2, 0}, {2, 0, 0, 0}, {0, 2, 2, 2}};
    case '4':
      return {{0, 4, 0, 2}, {0, 2, 2, 2}, {2, 4, 2, 0}};
    case '5':
      return {{2, 4, 0, 4}, {0, 4, 0, 2}, {0, 2, 2, 2}, {2, 2, 2, 0}, {2, 0, 0, 0}};
    case '6':
      return {{2, 4, 0, 4}, {0, 4, 0, 0}, {0, 0, 2, 0}, {2, 0, 2, 2}, {2, 2, 0, 2}};
    case '7':
      return {{0, 4, 2, 4}, {2, 4, 2, 0}};
    case '8':
      return {{0, 0, 2, 0}, {2, 0, 2, 4}, {2, 4, 0, 4}, {0, 4, 0, 0}, {0, 2, 2, 2}};
    case '9':
      return {{0, 0, 2, 0}, {2, 0, 2, 4}, {2, 4, 0, 4}, {0, 4, 0, 2}, {0, 2, 2, 2}};
    case '+':
      return {{0, 2, 2, 2}, {1, 1, 1, 3}};
    case '-':
      return {{0, 2, 2, 2}};
    case '.':
      return {{1, 0, 1, 0.3}};
    case 'e':
      return {{0, 1.2, 2, 1.2}, {2, 1.2, 2, 2.4}, {2, 2.4, 0, 2.4}, {0, 2.4, 0, 0}, {0, 0, 2, 0}};
    case 'm':
      return {{0, 0, 0, 2.4}, {0, 2.4, 2, 2.4}, {1, 2.4, 1, 0}, {2, 2.4, 2, 0}};
    case 'u':
      return {{0, 2.4, 0, 0}, {0, 0, 2, 0}, {2, 0, 2, 2.4}};
    case 'x':
      return {{0, 0, 2, 2.4}, {0, 2.4, 2, 0}};
    default:
      return {};
  }
}

Mesh colour_bar(double end_um, double magnification, const Vector3d& foot_w_mm, double height_mm) {
  Mesh mesh;
  Pen pen(mesh, foot_w_mm);
  const double width = height_mm / 12, letter = height_mm / 12;
  for (int k = 0; k < kBands; ++k)
    pen.rectangle(0, height_mm * k / kBands, width, height_mm * (k + 1) / kBands,
                  deviation_colour((2 * k + 1.0) / kBands - 1));
  for (const double share : {-1.0, 0.0, 1.0}) {
    const double y = height_mm * (share + 1) / 2;
    pen.rectangle(width, y - 0.05 * letter, 1.3 * width, y + 0.05 * letter, kInk);
    pen.write(signed_text(share * end_um) + " um", 1.6 * width, y - letter / 2, letter);
  }
  if (magnification > 0) pen.write("x " + signed_text(magnification).substr(1), 0, -2.5 * letter, letter);
  return mesh;
}

}  // namespace trunnion
