#include "libcommon/controls/distance_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(curves) {
  const auto curves = read_curves(fuzz::fuzz_file("curves.csv", bytes));
  fuzz::require(!curves.empty(), "there is a curve");
  for (const std::vector<Vec3>& curve : curves) {
    fuzz::require(!curve.empty(), "a curve has a point");
    for (const Vec3& p : curve) fuzz::require(p.allFinite(), "points are finite");
  }
}
