#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "io/machine_file.h"
#include "kinematics/kinematic_chain.h"

// The machine files that come with Trunnion, each as its first lines say.

namespace trunnion {
namespace {

constexpr double kRounding_mm = 1e-12;  // of products of rotations over some 100 mm

const std::filesystem::path kSource = TRUNNION_SOURCE_DIR;

std::vector<std::filesystem::path> machine_files() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "machines"))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

std::string text_of(const std::filesystem::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

Machine shipped(const std::string& name) { return read_machine((kSource / "machines" / (name + ".toml")).string()); }

TEST(ShippedMachines, AreReadEachWithASerialNumberOfItsOwn) {
  std::set<std::string> serials;
  const auto files = machine_files();
  ASSERT_GE(files.size(), 10u);
  for (const auto& file : files) {
    const Machine machine = read_machine(file.string());
    EXPECT_FALSE(machine.name.empty()) << file;
    EXPECT_TRUE(serials.insert(machine.serial).second) << file << ": serial " << machine.serial << " occurs twice";
    EXPECT_TRUE(machine.tilt().range_angle) << file << ": the tilting axis has no stroke";
    const KinematicChain chain(machine);
    EXPECT_TRUE(chain.r_from_w({}).isApprox(Eigen::Isometry3d::Identity(), kRounding_mm)) << file;
  }
}

TEST(ShippedMachines, SayInTheirFirstLinesWhereTheirNumbersComeFrom) {
  for (const auto& file : machine_files()) {
    const std::string text = text_of(file);
    EXPECT_LT(text.find("Where the numbers come from:"), text.find("format =")) << file;
  }
}

TEST(ShippedMachines, ServeEveryController) {
  std::set<std::string> controllers;
  for (const auto& file : machine_files()) controllers.insert(read_machine(file.string()).controller);
  for (const char* controller : {"linuxcnc", "sinumerik-840d", "isg-twincat", "heidenhain", "fanuc-30i", "aerotech"})
    EXPECT_TRUE(controllers.contains(controller)) << controller;
}

TEST(ShippedMachines, AreListedInTheirReadme) {
  const std::string readme = text_of(kSource / "machines" / "README.md");
  for (const auto& file : machine_files())
    EXPECT_NE(readme.find("`" + file.filename().string() + "`"), std::string::npos) << file.filename();
}

TEST(ShippedMachines, TiltAndTurnTheTableAsTheySay) {
  const Eigen::Vector3d face = Eigen::Vector3d::UnitZ(), along_x = Eigen::Vector3d::UnitX();
  const auto turned = [](const Machine& machine, double a, double c, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return KinematicChain(machine).r_from_w({Angle::degrees(a), Angle::degrees(c)}).linear() * v;
  };
  // Right-handed as commanded: at A = -90 the face of the table looks along +Y; where A is reversed, at A = +90.
  EXPECT_TRUE(turned(shipped("seed-trunnion"), -90, 0, face).isApprox(Eigen::Vector3d::UnitY(), kRounding_mm));
  EXPECT_TRUE(turned(shipped("reversed-trunnion"), 90, 0, face).isApprox(Eigen::Vector3d::UnitY(), kRounding_mm));
  EXPECT_TRUE(turned(shipped("seed-trunnion"), 0, 90, along_x).isApprox(Eigen::Vector3d::UnitY(), kRounding_mm));
  EXPECT_TRUE(turned(shipped("reversed-trunnion"), 0, -90, along_x).isApprox(Eigen::Vector3d::UnitY(), kRounding_mm));
  EXPECT_TRUE(turned(shipped("bc-trunnion"), 90, 0, face).isApprox(along_x, kRounding_mm));
}

TEST(ShippedMachines, OffsetTrunnionMovesAsItsControlDoes) {
  // xyzac-trt-kins, y-offset 20, z-offset 10, rot-point 0: J = Rx(A) (Rz(C) P - D) + D.
  const Machine machine = shipped("offset-trunnion");
  const Eigen::Vector3d p(30, -50, 40), d(0, 20, 10);
  const double a = -0.7, c = 2.1;
  const Eigen::Vector3d q = Eigen::AngleAxisd(c, Eigen::Vector3d::UnitZ()) * p - d;
  const Eigen::Vector3d wanted = Eigen::AngleAxisd(a, Eigen::Vector3d::UnitX()) * q + d;
  const Eigen::Vector3d found = KinematicChain(machine).r_from_w({Angle::radians(a), Angle::radians(c)}) * p;
  EXPECT_LT((found - wanted).norm(), kRounding_mm);
}

}  // namespace
}  // namespace trunnion
