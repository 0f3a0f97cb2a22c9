#include <cmath>
#include <cstdio>

#include "geometric_errors/pose_error.h"
#include "model/catalogue.h"

// Exit status 0 if headers, libraries and their dependencies were all found and work.
int main() {
  trunnion::PoseError error;
  error.rotation_rad.z() = 1e-3;
  const Eigen::Vector3d moved_mm = trunnion::displacement_mm(error, {100, 0, 0});
  std::printf("%zu families of effects; 1 mrad about Z moves X 100 by %.3f mm\n", trunnion::catalogue().size(),
              moved_mm.y());
  return std::abs(moved_mm.y() - 0.1) < 1e-6 && !trunnion::catalogue().empty() ? 0 : 1;
}
