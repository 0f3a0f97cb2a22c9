#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "shop.h"

// LinuxCNC's own interpreter reads what we write. Needs the package linuxcnc-uspace.

namespace trunnion {
namespace {

constexpr double kPrinted = 5.1e-5;  // rs274 prints four decimals of mm and deg

bool have_rs274() { return std::system("command -v rs274 >/dev/null 2>&1") == 0; }

/// What rs274 makes of a program: the end of each straight move, once all five axes were programmed. Empty, and the
/// message in `error`, if it refuses.
std::vector<testing::PlayedMove> read_by_rs274(const std::string& program, std::string& error) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("trunnion_rs274_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "part.ngc") << program;
  std::ofstream(folder / "vars.var");
  std::ofstream(folder / "tool.tbl") << "T1 P1 D10 Z0\nT2 P2 D10 Z0\nT3 P3 D10 Z0\n";
  const std::string command = "cd '" + folder.string() +
                              "' && HOME=. timeout 20 rs274 -t tool.tbl -v vars.var -g part.ngc out 2>err >/dev/null";
  const bool well = std::system(command.c_str()) == 0;
  std::stringstream told;
  told << std::ifstream(folder / "err").rdbuf();
  error = well ? "" : "rs274: " + told.str();
  std::vector<testing::PlayedMove> moves;
  std::ifstream out(folder / "out");
  std::size_t first = 0;  // axis of the plane
  for (std::string line; std::getline(out, line);) {
    for (const char* plane : {"XY", "ZX", "XZ", "YZ"})
      if (line.find(std::string("SELECT_PLANE(CANON_PLANE::") + plane) != std::string::npos ||
          line.find(std::string("SELECT_PLANE(CANON_PLANE_") + plane) != std::string::npos)
        first = plane[0] == 'X' && plane[1] == 'Y' ? 0 : plane[0] == 'Y' ? 1 : 2;
    double c1 = 0, c2 = 0, turns = 0, b_axis = 0;
    testing::PlayedMove arc;
    if (line.find("ARC_FEED(") != std::string::npos &&
        std::sscanf(line.c_str() + line.find('('), "(%lf, %lf, %lf, %lf, %lf, %lf, %lf, %lf, %lf)", &arc.at[first],
                    &arc.at[(first + 1) % 3], &c1, &c2, &turns, &arc.at[(first + 2) % 3], &arc.at[3], &b_axis,
                    &arc.at[4]) == 9)
      moves.push_back(arc);
    const bool feed = line.find("STRAIGHT_FEED(") != std::string::npos;
    if (!feed && line.find("STRAIGHT_TRAVERSE(") == std::string::npos) continue;
    double b = 0;
    testing::PlayedMove move;
    if (std::sscanf(line.c_str() + line.find('('), "(%lf, %lf, %lf, %lf, %lf, %lf)", &move.at[0], &move.at[1],
                    &move.at[2], &move.at[3], &b, &move.at[4]) == 6)
      moves.push_back(move);
  }
  std::filesystem::remove_all(folder);
  return moves;
}

std::string impeller(int lines) {
  std::string text = "%\n(IMPELLER)\nG21 G90 G94 G17 G40 G49\nT1 M6\nS9000 M3\nG0 X0 Y0 Z90 A-15 C0\n";
  char line[160];
  for (int i = 1; i <= lines; ++i) {
    const double t = i * 0.05;
    std::snprintf(line, sizeof line, "N%d G1 X%.3f Y%.3f Z%.3f A%.3f C%.3f%s\n", i, 50 * std::cos(t), 50 * std::sin(t),
                  80 + 5 * std::sin(3 * t), -30 - 25 * std::sin(2 * t), t * 180 / 3.14159265, i == 1 ? " F900" : "");
    text += line;
  }
  return text + "M5\nM30\n%\n";
}

class Rs274 : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!have_rs274()) GTEST_SKIP() << "rs274 of linuxcnc-uspace is not installed";
  }
};

TEST_F(Rs274, ReadsEveryCorrectedProgramAsWeMeantIt) {
  const std::string programs[] = {
      impeller(400),
      "g21g90\ng0x1y2z3a-4c5\ng1 x 1 . 5 f100\n g1 y+7.25 a-5.5\nm2\n",
      "G21 G90 G0 X10 Y20 Z30 A-40 C0\nG1 C90 F300\nX11\nA-80\nG93 X20 Y0 C120 F3\nG94 G1 X21 F100\nM2\n",
      "G21 G90 G0 X10 Y20 Z30 A-30 C60\nG91\nG1 X5. Y1. F500\nX5. A-2.\nX-.5 Y.25 Z1. C3\nG90 X40 A-70 C-100\nM30\n",
      "G21 G0 X10 Y20 Z30 A-40 C50\nG1 X10 F500\nG3 X0 Y30 I-10\nX-10 Y20 J-10\nG18 G2 X0 Z40 R10 A-41 F300\nG17 G1 "
      "X5\nG02 I5 P2 Z35\nM2\n",
      "G21 G0 X1 Y1 Z50 A0 C0\nG1 Z5 F100\nX20 C350\nT2 M6\nG0 X0 Y0 Z100\nA-90 C720\nG1 X30 Y30 Z-20 F1000\nG53 G0 "
      "Z0\nM2\n",
  };
  for (const bool tcp : {true, false})
    for (const std::string& program : programs) {
      Shop shop;
      shop.how.scan.tcp = tcp;
      std::string error;
      const std::string corrected = shop.correct(program);
      EXPECT_NE(corrected, program);
      const auto theirs = read_by_rs274(corrected, error);
      EXPECT_EQ(error, "") << corrected;
      const auto ours = testing::play_rs274(corrected, {});
      // Ours leaves out what comes before the axes are known.
      ASSERT_GE(theirs.size(), ours.size());
      std::size_t at = 0;
      for (const testing::PlayedMove& move : ours) {
        const auto same = [&](const testing::PlayedMove& other) {
          for (std::size_t i = 0; i < 5; ++i)
            if (std::abs(other.at[i] - move.at[i]) > kPrinted) return false;
          return true;
        };
        while (at < theirs.size() && !same(theirs[at])) ++at;
        ASSERT_LT(at, theirs.size()) << "not found: X" << move.at[0] << "\n" << corrected;
        ++at;
      }
    }
}

TEST_F(Rs274, ReadsTheGoldenCases) {
  int read = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(TRUNNION_SOURCE_DIR) / "tests" / "golden")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("nc_") && !name.ends_with("_linuxcnc")) continue;  // other dialects
    const std::filesystem::path file = entry.path() / "expected" / "out.nc";
    if (!std::filesystem::exists(file)) continue;
    std::stringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    // The interpreter itself does not know the line ends of a tape.
    if (text.str().find("\n\r\r") != std::string::npos) continue;
    std::string error;
    EXPECT_FALSE(read_by_rs274(text.str(), error).empty()) << file;
    EXPECT_EQ(error, "") << file;
    ++read;
  }
  EXPECT_GT(read, 12);
}

}  // namespace
}  // namespace trunnion
