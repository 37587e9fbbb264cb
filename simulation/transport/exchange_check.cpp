// Whether a device exchanges as the CPU does.
#include <memory>
#include <optional>
#include <vector>

#include "libcommon/core/random.h"
#include "simulation/device/check_scene.h"
#include "simulation/transport/device_exchange.h"
#include "simulation/transport/exchange.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kGammatons = 700;
constexpr int kRounds = 4;

/// Drops anywhere on the surface, a quarter of them on a few texels, where many of an iteration meet.
std::vector<Contact> any_contacts(const std::vector<TexelIndex>& covered, RandomStream& random) {
  std::vector<Contact> contacts;
  for (std::uint32_t g = 0; g < kGammatons; ++g) {
    if (random.below(8) == 0) continue;
    const auto most = static_cast<std::uint32_t>(covered.size());
    contacts.push_back(
        {.texel = covered[random.below(4) == 0 ? random.below(5) * 37 : random.below(most)], .gammaton = g});
  }
  return contacts;
}

std::vector<Ending> any_endings(const std::vector<TexelIndex>& covered, RandomStream& random) {
  std::vector<Ending> endings;
  for (std::uint32_t g = 0; g < kGammatons; g += 9) {
    Ending& ending = endings.emplace_back(Ending{.gammaton = g, .trail = {}});
    const std::uint32_t num = 1 + random.below(20),
                        start = random.below(static_cast<std::uint32_t>(covered.size()) - 64);
    for (std::uint32_t k = 0; k < num; ++k) ending.trail.add(covered[start + k]);
  }
  return endings;
}

bool is_same(const ExchangeReport& a, const ExchangeReport& b) {
  return a.dropped == b.dropped && a.picked_up == b.picked_up &&
         std::equal(a.dirty_tiles.begin(), a.dirty_tiles.end(), b.dirty_tiles.begin(), b.dirty_tiles.end());
}

}  // namespace

device::CheckResult check_exchange(const device::Device& device) {
  const CheckSurface on(check_scene());
  std::vector<TexelIndex> covered;
  for (TexelIndex t = 0; t < on.surface.grid().num_texels(); ++t) {
    if (on.surface.is_covered(t)) covered.push_back(t);
  }
  std::optional<device::DeviceError> failure;
  const auto simulation_device =
      std::make_shared<const SimulationDevice>(device, [&](const device::DeviceError& problem) { failure = problem; });
  device::CheckResult check;
  // Contacts of one texel, of a few, and of hundreds, on either side of what a stencil has and what is cut.
  for (const double splat_mm : {0.0, 2.0, 7.0}) {
    Exchanger here(on.num_materials, 5), there(on.num_materials, 5);
    there.use(simulation_device);
    MaterialAtlas expected = on.any_amounts(), found = on.any_amounts();
    RandomStream random(6, static_cast<std::uint64_t>(splat_mm));
    Cargo cargo;
    cargo.mass.resize(kGammatons);
    for (auto& mass : cargo.mass) {
      for (std::uint32_t& m : mass) m = random.next_u32() >> random.below(24);
    }
    Cargo carried = cargo;
    for (int i = 0; i < kRounds; ++i) {
      const ExchangeOptions options{
          .ratio = 0.3 * i, .rates = {0.6, 1.0 / 4096.0, 1.0}, .contact = 0.5 + i, .splat_mm = splat_mm};
      const std::vector<Contact> contacts = any_contacts(covered, random);
      check.num_different += is_same(here.exchange(contacts, options, i, cargo, expected),
                                     there.exchange(contacts, options, i, carried, found))
                                 ? 0
                                 : 1;
      const std::vector<Ending> endings = any_endings(covered, random);
      check.num_different += is_same(here.deposit(endings, options, i, cargo, expected),
                                     there.deposit(endings, options, i, carried, found))
                                 ? 0
                                 : 1;
      check.num_items += static_cast<std::int64_t>(contacts.size() + endings.size());
      for (std::uint32_t g = 0; g < kGammatons; ++g) check.num_different += cargo.mass[g] == carried.mass[g] ? 0 : 1;
    }
    for (int m = 0; m < on.num_materials; ++m) {
      for (const TexelIndex t : covered) check.num_different += expected.amount(m, t) == found.amount(m, t) ? 0 : 1;
    }
  }
  if (failure) throw device::DeviceError(*failure);
  return check;
}

}  // namespace patinate::simulation
