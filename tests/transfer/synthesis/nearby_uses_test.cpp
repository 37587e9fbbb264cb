#include "transfer/synthesis/nearby_uses.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"
#include "transfer/synthesis/source_levels.h"

namespace patinate::transfer {
namespace {

constexpr int kSourceSide = 128, kAtlasSide = 256, kPieceSide = 16;

SourceLevel plain_source() {
  const Neighborhood neighborhood = Neighborhood::square(1);
  return make_source_level(AppearanceImage(kSourceSide, kSourceSide, kAppearanceSize, 0),
                           ControlImage(kSourceSide, kSourceSide, 1, 0), ImageU8(kSourceSide, kSourceSide, 1, 255),
                           10.0, neighborhood);
}

/// A piece of 16 x 16 pixels of the source, from (32, 32) on, at a place of the atlas.
void lay_piece(const SourceLevel& source, int left, int top, PlaceMap& places) {
  for (int y = 0; y < kPieceSide; ++y) {
    for (int x = 0; x < kPieceSide; ++x)
      places.set((top + y) * kAtlasSide + left + x, place_of(source, (32 + y) * kSourceSide + 32 + x));
  }
}

constexpr TexelId texel_at(int x, int y) { return y * kAtlasSide + x; }
constexpr int kShown = 40 * kSourceSide + 40, kNotShown = 80 * kSourceSide + 80;

TEST(NearbyUses, CountsWhatIsShownWithin64TexelsAndNotWhatIsFarAway) {
  const SourceLevel source = plain_source();
  const TexelMap map(testing_support::unit_plane(kAtlasSide), kAtlasSide, kAtlasSide);
  NearbyUses nearby(source, map);
  PlaceMap places(kAtlasSide * kAtlasSide, kSourceSide);
  EXPECT_EQ(nearby.copies(texel_at(5, 5), kShown), 0) << "not measured";
  lay_piece(source, 0, 0, places);
  lay_piece(source, 60, 40, places);  // 64 texels away at most, in another square.
  lay_piece(source, 240, 240, places);
  nearby.measure(places, {});
  EXPECT_EQ(nearby.copies(texel_at(5, 5), kShown), 2 * NearbyUses::kOneCopy);
  EXPECT_EQ(nearby.copies(texel_at(65, 45), kShown), 2 * NearbyUses::kOneCopy);
  EXPECT_EQ(nearby.copies(texel_at(245, 245), kShown), NearbyUses::kOneCopy);
  EXPECT_EQ(nearby.copies(texel_at(5, 5), kNotShown), 0);
}

}  // namespace
}  // namespace patinate::transfer
