#include "io/piece_file.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "error.h"
#include "io/csv.h"
#include "io/text_file.h"
#include "io/toml_reader.h"

namespace trunnion {
namespace {

constexpr double kLargest_mm = 1e5;
constexpr std::size_t kLargestPiece_bytes = std::size_t{1} << 24;

/// A number of [low, high] (or above `low`, `above`), which must be there unless `otherwise` is given.
struct Wanted {
  double low = -kLargest_mm, high = kLargest_mm;
  bool above = false;
  std::optional<double> otherwise;
};

std::string plain(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

double number(TomlReader& table, const std::string& key, const Wanted& wanted) {
  const std::optional<double> value = table.number(key);
  if (!value && wanted.otherwise) return *wanted.otherwise;
  const std::string kind = wanted.above ? "a number above " + plain(wanted.low) + " up to " + plain(wanted.high)
                                        : "a number from " + plain(wanted.low) + " to " + plain(wanted.high);
  if (!value) table.fail(key, "missing; " + kind + " is wanted");
  if (*value < wanted.low || *value > wanted.high || (wanted.above && *value == wanted.low))
    table.fail(key, plain(*value) + " found, " + kind + " is wanted");
  return *value;
}

TomlReader required_table(TomlReader& top, const std::string& key) {
  std::optional<TomlReader> table = top.table(key);
  if (!table) top.fail(key, "the table [" + key + "] is missing");
  return *table;
}

ConeFrustum read_cone(TomlReader& top) {
  ConeFrustum cone;
  cone.half_angle = Angle::degrees(number(top, "half_angle_deg", {.low = 0, .high = 85}));
  cone.base_diameter = Length::millimetres(number(top, "base_diameter_mm", {.low = 0, .above = true}));
  cone.height = Length::millimetres(number(top, "height_mm", {.low = 0, .above = true}));
  const auto center = top.numbers("base_center_mm", 3);
  if (!center) top.fail("base_center_mm", "missing; [x, y, z] in W is wanted");
  cone.base_center_w_mm = {(*center)[0], (*center)[1], (*center)[2]};
  cone.tilt = Angle::degrees(number(top, "tilt_deg", {.low = 0, .high = 90}));
  cone.tilt_azimuth = Angle::degrees(number(top, "tilt_azimuth_deg", {.low = -360, .high = 360, .otherwise = 0}));
  if (radius_at(cone, cone.height) <= Length())
    top.fail("height_mm",
             plain(cone.height.in_millimetres()) + " found; the cone ends in its apex at " +
                 plain(0.5 * cone.base_diameter.in_millimetres() / std::tan(cone.half_angle.in_radians())) +
                 ", a lower frustum is wanted");
  return cone;
}

FlankTool read_tool(TomlReader table) {
  FlankTool tool;
  tool.diameter = Length::millimetres(number(table, "diameter_mm", {.low = 0, .above = true}));
  tool.overhang = Length::millimetres(number(table, "overhang_mm", {.otherwise = 0}));
  tool.corner_radius = Length::millimetres(
      number(table, "corner_radius_mm", {.low = 0, .high = tool.diameter.in_millimetres() / 2, .otherwise = 0}));
  tool.length = Length::millimetres(number(table, "length_mm", {.low = 0, .otherwise = 0}));
  table.finish();
  return tool;
}

void read_path(TomlReader table, TestPiece& piece) {
  const double sense = number(table, "sense", {.otherwise = 1});
  if (sense != 1 && sense != -1) table.fail("sense", plain(sense) + " found, 1 or -1 is wanted");
  piece.sense = sense < 0 ? -1 : 1;
  if (const auto feed = table.number("feed_mm_per_min")) {
    if (*feed <= 0) table.fail("feed_mm_per_min", plain(*feed) + " found, a number above 0 is wanted");
    piece.feed_mm_per_min = *feed;
  }
  table.finish();
}

void read_evaluation(TomlReader table, TestPiece& piece) {
  const double height = piece.cone.height.in_millimetres();
  if (const toml::node* node = table.node("heights_mm")) {
    const std::size_t count = node->is_array() ? node->as_array()->size() : 0;
    if (count == 0) table.fail("heights_mm", "a list of one or more heights is wanted");
    const std::vector<double> heights = table.numbers("heights_mm", count).value();
    for (const double h : heights) {
      if (h < 0 || h > height)
        table.fail("heights_mm", plain(h) + " found, heights from 0 to height_mm = " + plain(height) + " are wanted");
      if (std::ranges::find(piece.heights, Length::millimetres(h)) != piece.heights.end())
        table.fail("heights_mm", plain(h) + " found twice");
      piece.heights.push_back(Length::millimetres(h));
    }
  }
  const double points = number(table, "points", {.low = 8, .high = 36000, .otherwise = 360});
  if (points != std::floor(points)) table.fail("points", plain(points) + " found, a whole number is wanted");
  piece.points = static_cast<int>(points);
  table.finish();
}

/// The rounded end of the tool must stand below the lowest circle that is evaluated: it does not cut to the flank.
void check_reach(TomlReader& top, const TestPiece& piece) {
  const Length lowest = *std::ranges::min_element(piece.heights);
  const double above_tip =
      lowest.in_millimetres() / std::cos(piece.cone.half_angle.in_radians()) + piece.tool.overhang.in_millimetres();
  if (above_tip < piece.tool.corner_radius.in_millimetres())
    top.fail("tool",
             "at h = " + plain(lowest.in_millimetres()) + " mm the flank lies " + plain(above_tip) +
                 " mm above the tip, beside the tool's rounded end; an overhang_mm of " +
                 plain(piece.tool.overhang.in_millimetres() + piece.tool.corner_radius.in_millimetres() - above_tip) +
                 " or more is wanted");
}

}  // namespace

TestPiece parse_piece(std::string_view text, const std::string& name) {
  const toml::table document = TomlReader::parse(text, name);
  TomlReader top(document, name, "");
  top.check_format("trunnion-piece");
  const std::string kind = top.required_text("kind");
  if (kind != "cone_frustum") top.fail("kind", "\"" + kind + "\" found, \"cone_frustum\" is wanted");
  TestPiece piece;
  piece.cone = read_cone(top);
  piece.tool = read_tool(required_table(top, "tool"));
  if (const auto path = top.table("path")) read_path(*path, piece);
  if (const auto evaluation = top.table("evaluate")) read_evaluation(*evaluation, piece);
  if (piece.heights.empty()) {
    const Length end = std::min(Length::millimetres(2), 0.25 * piece.cone.height);
    piece.heights = {end, 0.5 * piece.cone.height, piece.cone.height - end};
  }
  check_reach(top, piece);
  top.finish();
  try {
    w_from_cone(piece.cone);
  } catch (const ModelError& e) {
    top.fail("tilt_azimuth_deg", e.what());
  }
  return piece;
}

TestPiece read_piece(const std::string& path) { return parse_piece(read_text(path, kLargestPiece_bytes), path); }

std::string piece_text(const TestPiece& piece) {
  // Angles that came from whole millionths of a degree go back to them.
  const auto degrees = [](Angle a) { return plain(std::round(a.in_degrees() * 1e9) / 1e9); };
  const auto mm = [](Length l) { return plain(l.in_millimetres()); };
  const Eigen::Vector3d& c = piece.cone.base_center_w_mm;
  std::string heights;
  for (const Length h : piece.heights) heights += (heights.empty() ? "" : ", ") + mm(h);
  std::string text = "format = \"trunnion-piece\"\nversion = 1\nkind = \"cone_frustum\"\nhalf_angle_deg = " +
                     degrees(piece.cone.half_angle) + "\nbase_diameter_mm = " + mm(piece.cone.base_diameter) +
                     "\nheight_mm = " + mm(piece.cone.height) + "\nbase_center_mm = [" + plain(c.x()) + ", " +
                     plain(c.y()) + ", " + plain(c.z()) + "]\ntilt_deg = " + degrees(piece.cone.tilt) +
                     "\ntilt_azimuth_deg = " + degrees(piece.cone.tilt_azimuth) +
                     "\n[tool]\ndiameter_mm = " + mm(piece.tool.diameter) +
                     "\noverhang_mm = " + mm(piece.tool.overhang) +
                     "\ncorner_radius_mm = " + mm(piece.tool.corner_radius) + "\nlength_mm = " + mm(piece.tool.length) +
                     "\n[path]\nsense = " + std::to_string(piece.sense) + "\n";
  if (piece.feed_mm_per_min) text += "feed_mm_per_min = " + plain(*piece.feed_mm_per_min) + "\n";
  return text + "[evaluate]\nheights_mm = [" + heights + "]\npoints = " + std::to_string(piece.points) + "\n";
}

MeasuredPiece parse_measured_piece(std::string_view text, const std::string& name, const TestPiece& piece) {
  CsvReader csv(text, name);
  const auto column = [&](const char* wanted) {
    const auto found = csv.find(wanted);
    if (!found) throw InputError(name, std::string("no column ") + wanted + "; phi_deg,h_mm,deviation_um are wanted");
    return *found;
  };
  const std::size_t phi = column("phi_deg"), h = column("h_mm"), deviation = column("deviation_um");
  const std::optional<std::size_t> sigma = csv.find("sigma_um");
  MeasuredPiece measured{.file = name};
  std::vector<std::size_t> further;
  for (std::size_t k = 0; k < csv.header().size(); ++k) {
    if (k == phi || k == h || k == deviation || k == sigma) continue;
    further.push_back(k);
    measured.columns.push_back(csv.header()[k]);
  }
  std::vector<std::string_view> fields;
  while (csv.next(fields)) {
    MeasuredPoint point{.line = static_cast<std::uint32_t>(csv.line()),
                        .phi = Angle::degrees(csv.number(fields[phi], phi)),
                        .h = Length::millimetres(csv.number(fields[h], h)),
                        .deviation_mm = Length::micrometres(csv.number(fields[deviation], deviation)).in_millimetres()};
    if (point.h < Length() || point.h > piece.cone.height)
      throw InputError(name, csv.line(),
                       "h_mm: " + plain(point.h.in_millimetres()) + " found, 0 to the piece's height of " +
                           plain(piece.cone.height.in_millimetres()) + " mm is wanted");
    if (sigma) {
      point.sigma_mm = Length::micrometres(csv.number(fields[*sigma], *sigma)).in_millimetres();
      if (point.sigma_mm <= 0)
        throw InputError(name, csv.line(),
                         "sigma_um: " + std::string(fields[*sigma]) + " found, a number above 0 is wanted");
    }
    for (const std::size_t k : further) measured.values.push_back(csv.number(fields[k], k));
    measured.points.push_back(point);
  }
  if (measured.points.empty()) throw InputError(name, "no measured points");
  for (const ConeTrace& trace : traces_of(measured, piece)) {
    try {
      least_squares_circle(radial_trace(trace, piece.cone.half_angle));
    } catch (const InputError& e) {
      throw InputError(name, "h_mm = " + plain(trace.h_mm) + ": " + e.what());
    }
  }
  return measured;
}

MeasuredPiece read_measured_piece(const std::string& path, const TestPiece& piece) {
  return parse_measured_piece(read_text(path), path, piece);
}

}  // namespace trunnion
