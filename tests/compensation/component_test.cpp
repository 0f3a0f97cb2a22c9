#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "compensation/controllers/linuxcnc.h"
#include "compensation/verification.h"
#include "sample_models.h"
#include "support/virtual_machine.h"
#include "units/angle.h"

// The component as LinuxCNC's own tool compiles it, loaded into this program: what it calls of HAL stands below, and
// what it computes is judged by a machine that knows nothing of it.

namespace {
std::map<std::string, void*> pins;  // where the component reads and writes
void* new_pin(const char* format, va_list arguments) {
  char name[64];
  std::vsnprintf(name, sizeof name, format, arguments);
  return pins[name] = std::calloc(1, 16);
}
}  // namespace

extern "C" {
struct EmcPose {
  double x, y, z, a, b, c, u, v, w;
};
int hal_init(const char*) { return 7; }
int hal_ready(int) { return 0; }
int hal_exit(int) { return 0; }
void* hal_malloc(long size) { return std::calloc(1, static_cast<std::size_t>(size)); }
int hal_pin_float_newf(int, void** data, int, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  *data = new_pin(format, arguments);
  va_end(arguments);
  return 0;
}
int hal_pin_bit_newf(int, void** data, int, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  *data = new_pin(format, arguments);
  va_end(arguments);
  return 0;
}
void rtapi_print_msg(int, const char*, ...) {}
int rtapi_snprintf(char* text, unsigned long size, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const int length = std::vsnprintf(text, size, format, arguments);
  va_end(arguments);
  return length;
}
}

namespace trunnion {
namespace {

using compensation_test::trunnion_machine;

class Component {
 public:
  explicit Component(const std::string& source) {
    const auto folder = std::filesystem::temp_directory_path() /
                        ("trunnion_component_" + std::to_string(counter_++) + "_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "trunnion_kins.comp") << source;
    const std::string command = "cd '" + folder.string() + "' && halcompile --compile trunnion_kins.comp >log 2>&1";
    if (std::system(command.c_str()) != 0) return;
    handle_ = dlopen((folder / "trunnion_kins.so").c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle_ == nullptr) std::fprintf(stderr, "%s\n", dlerror());
    std::filesystem::remove_all(folder);
    if (handle_ == nullptr) return;
    inverse_ = reinterpret_cast<int (*)(const EmcPose*, double*, const unsigned long*, unsigned long*)>(
        dlsym(handle_, "kinematicsInverse"));
    forward_ = reinterpret_cast<int (*)(const double*, EmcPose*, const unsigned long*, unsigned long*)>(
        dlsym(handle_, "kinematicsForward"));
    switch_ = reinterpret_cast<int (*)(int)>(dlsym(handle_, "kinematicsSwitch"));
    started_ = reinterpret_cast<int (*)()>(dlsym(handle_, "rtapi_app_main"))();
  }
  ~Component() {
    if (handle_ != nullptr) dlclose(handle_);
  }
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;

  bool usable() const { return handle_ != nullptr && started_ == 0 && inverse_ != nullptr && forward_ != nullptr; }
  std::array<double, 5> joints(const EmcPose& world) const {
    std::array<double, 5> joint{};
    inverse_(&world, joint.data(), nullptr, nullptr);
    return joint;
  }
  EmcPose world(const std::array<double, 5>& joint) const {
    EmcPose pose{};
    forward_(joint.data(), &pose, nullptr, nullptr);
    return pose;
  }
  int switch_to(int type) const { return switch_(type); }
  static double& number(const std::string& pin) { return *static_cast<double*>(pins.at("trunnion_kins." + pin)); }
  static unsigned char& bit(const std::string& pin) {
    return *static_cast<unsigned char*>(pins.at("trunnion_kins." + pin));
  }

 private:
  static inline int counter_ = 0;
  void* handle_ = nullptr;
  int started_ = -1;
  int (*inverse_)(const EmcPose*, double*, const unsigned long*, unsigned long*) = nullptr;
  int (*forward_)(const double*, EmcPose*, const unsigned long*, unsigned long*) = nullptr;
  int (*switch_)(int) = nullptr;
};

class TheComponent : public ::testing::Test {
 protected:
  Machine machine = trunnion_machine();
  testing::VirtualMachine real = testing::smooth_machine(21);
  Model model = compensation_test::model_of(real, machine, 15);
  CompensationTask task{machine, model, {}, {}};
  Component component{component_source(kinematics_data(task, Angle::degrees(5)), "tests")};
  std::vector<Situation> sample = pose_sample(task.volume, model, 400, 7);
  void SetUp() override { ASSERT_TRUE(component.usable()); }
};

TEST_F(TheComponent, PutsTheTipOfAnIndependentMachineWhereItWasProgrammed) {
  constexpr double kLeft_mm = 0.05e-3;  // the model itself is a spline through the machine's errors every 15 deg
  Component::number("tool-offset") = 80;
  for (const Situation& s : sample) {
    // Programmed: a point of the work, A and C. The joints then go to a real machine.
    const Eigen::Vector3d w = task.chain.r_from_w(s.at).inverse() * s.point_r_mm;
    const double a = s.at.a.in_degrees(), c = s.at.c.in_degrees();
    const auto joint = component.joints({w.x(), w.y(), w.z(), a, 0, c, 0, 0, 0});
    testing::MachineState state;
    state.rotary = testing::ac_degrees(joint[3], joint[4]);
    state.tip_r_mm = {joint[0], joint[1], joint[2] - 80};
    const testing::ToolInWorkpiece tool = real.tool_in_workpiece(state);
    EXPECT_LT((tool.tip_w_mm - w).norm(), kLeft_mm) << "A " << a << " C " << c;
    if (a < -10) {
      const Eigen::Vector3d wanted = task.chain.r_from_w(s.at).linear().transpose() * Eigen::Vector3d::UnitZ();
      EXPECT_LT(tool.axis_w.cross(wanted).norm(), 2e-6) << "A " << a << " C " << c;
    }
  }
}

TEST_F(TheComponent, GoesWhereItsEmulatorSaysAndComesBack) {
  constexpr double kTwins_mm = 1e-9, kTwins_rad = 1e-12, kBack = 1e-8;
  const auto played = play_linuxcnc(
      {{"kinematics/trunnion_kins.comp", component_source(kinematics_data(task, Angle::degrees(5)), "tests")}}, task);
  for (const Situation& s : sample) {
    const Eigen::Vector3d w = task.chain.r_from_w(s.at).inverse() * s.point_r_mm;
    const double a = s.at.a.in_degrees(), c = s.at.c.in_degrees();
    const auto joint = component.joints({w.x(), w.y(), w.z(), a, 0, c, 0, 0, 0});
    const AxisCorrection told = played->at(s);
    EXPECT_LT((Eigen::Vector3d(joint[0], joint[1], joint[2]) - s.point_r_mm - told.linear_mm).norm(), kTwins_mm);
    EXPECT_NEAR((joint[3] - a) * kDegree_rad, told.tilt_rad, kTwins_rad);
    EXPECT_NEAR((joint[4] - c) * kDegree_rad, told.turn_rad, kTwins_rad);
    const EmcPose back = component.world(joint);
    EXPECT_NEAR(back.x, w.x(), kBack);
    EXPECT_NEAR(back.y, w.y(), kBack);
    EXPECT_NEAR(back.z, w.z(), kBack);
    EXPECT_NEAR(back.a, a, kBack);
    EXPECT_NEAR(back.c, c, kBack);
  }
}

TEST_F(TheComponent, WithoutCompensationIsTheStockKinematics) {
  // Formulas of xyzac-trt-kins, with rot-points, offsets and a tool.
  Component::bit("compensate") = 0;
  const Eigen::Vector3d r(11, -7, 23), d(0, 3, -5);
  Component::number("x-rot-point") = r.x(), Component::number("y-rot-point") = r.y(),
  Component::number("z-rot-point") = r.z();
  Component::number("y-offset") = d.y(), Component::number("z-offset") = d.z(), Component::number("tool-offset") = 60;
  const double a = -37 * kDegree_rad, c = 123 * kDegree_rad;
  const Eigen::Vector3d p = Eigen::Vector3d(40, 50, 60) - r;
  const Eigen::Vector3d q(std::cos(c) * p.x() - std::sin(c) * p.y(), std::sin(c) * p.x() + std::cos(c) * p.y() - d.y(),
                          p.z() - d.z());
  const auto joint = component.joints({40, 50, 60, -37, 0, 123, 0, 0, 0});
  EXPECT_NEAR(joint[0], q.x() + r.x(), 1e-12);
  EXPECT_NEAR(joint[1], std::cos(a) * q.y() - std::sin(a) * q.z() + d.y() + r.y(), 1e-12);
  EXPECT_NEAR(joint[2], std::sin(a) * q.y() + std::cos(a) * q.z() + d.z() + r.z() + 60, 1e-12);
  EXPECT_EQ(joint[3], -37);
  EXPECT_EQ(joint[4], 123);
}

TEST_F(TheComponent, MovedRotPointsMoveTheMapAlong) {
  const EmcPose before{40, 50, 60, -37, 0, 123, 0, 0, 0};
  const auto here = component.joints(before);
  Component::number("x-rot-point") += 100, Component::number("y-rot-point") += 20,
      Component::number("z-rot-point") -= 300;
  const auto there = component.joints({140, 70, -240, -37, 0, 123, 0, 0, 0});
  EXPECT_NEAR(there[0], here[0] + 100, 1e-10);
  EXPECT_NEAR(there[1], here[1] + 20, 1e-10);
  EXPECT_NEAR(there[2], here[2] - 300, 1e-10);
}

TEST_F(TheComponent, SwitchesToIdentityAndSaysWhenTheTiltLeavesTheMap) {
  EXPECT_EQ(component.switch_to(2), -1);
  EXPECT_EQ(component.switch_to(1), 0);
  EXPECT_EQ(component.joints({1, 2, 3, -30, 0, 40, 0, 0, 0}), (std::array<double, 5>{1, 2, 3, -30, 40}));
  EXPECT_EQ(component.switch_to(0), 0);
  component.joints({1, 2, 3, -30, 0, 40, 0, 0, 0});
  EXPECT_FALSE(Component::bit("outside"));
  component.joints({1, 2, 3, 5, 0, 40, 0, 0, 0});
  EXPECT_TRUE(Component::bit("outside"));
}

}  // namespace
}  // namespace trunnion
