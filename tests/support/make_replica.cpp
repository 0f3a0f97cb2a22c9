// make_replica DIR: writes DIR/replica.csv and DIR/truth.csv, the sample calibration and what it should find.

#include <cstdio>
#include <fstream>
#include <string>

#include "support/replica.h"

namespace {

constexpr int kMillimetreDecimals = 9;  // a picometre: above the last bit of any libm, far below any probe
constexpr int kErrorDecimals = 6;

bool write(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
  return static_cast<bool>(file);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace trunnion::testing;
  if (argc != 2) {
    std::fputs("usage: make_replica DIR\n", stderr);
    return 2;
  }
  const std::string folder = argv[1];
  const bool written = write(folder + "/replica.csv", csv(replica_observations(), kMillimetreDecimals)) &&
                       write(folder + "/truth.csv", truth_csv(replica_truth(), kErrorDecimals));
  return written ? 0 : 2;
}
