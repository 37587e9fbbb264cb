#include "patinate/simulation/ledger.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "simulation/transport/cargo.h"
#include "simulation/transport/exchange.h"

namespace patinate::simulation {

namespace {

constexpr double kMassOne = static_cast<double>(kAmountOne) * SurfaceAtlas::kMedianWeight;

std::string quanta_text(const MassSum& sum) { return number_text(sum.value()) + " quanta"; }

std::int64_t original_mass(const MaterialAtlas& atlas, int material, const RunControl& control) {
  const SurfaceAtlas& surface = atlas.surface();
  return parallel_reduce(
      std::int64_t{surface.grid().num_texels()}, 1 << 16, control, std::int64_t{0},
      [&](std::int64_t begin, std::int64_t end) {
        std::int64_t sum = 0;
        for (auto t = static_cast<TexelIndex>(begin); t < end; ++t) {
          if (surface.is_covered(t)) sum += std::int64_t{atlas.original(material, t)} * surface.weight(t);
        }
        return sum;
      },
      [](std::int64_t a, std::int64_t b) { return a + b; });
}

}  // namespace

MassSum& MassSum::operator+=(std::int64_t quanta) {
  const std::int64_t low = static_cast<std::int64_t>(low_) + (quanta & 0xFFFFFFFF);
  high_ += (quanta >> 32) + (low >> 32);
  low_ = static_cast<std::uint32_t>(low);
  return *this;
}

MassSum& MassSum::operator+=(const MassSum& other) {
  *this += static_cast<std::int64_t>(other.low_);
  high_ += other.high_;
  return *this;
}

MassSum& MassSum::operator-=(const MassSum& other) {
  *this += -static_cast<std::int64_t>(other.low_);
  high_ -= other.high_;
  return *this;
}

double MassSum::value() const { return static_cast<double>(high_) * 0x1p32 + static_cast<double>(low_); }

MassSum MassSum::from_parts(std::int64_t high, std::uint32_t low) {
  MassSum sum;
  sum.high_ = high;
  sum.low_ = low;
  return sum;
}

MassSum MassAccount::imbalance() const {
  MassSum sum = emitted;
  sum += made;
  for (const MassSum& part : {on_surfaces, carried, left, absorbed, rested, used}) sum -= part;
  return sum;
}

std::array<std::uint32_t, kMaxMaterials> MassLedger::cargo_of(const MaterialValues& carries, double area) {
  std::array<std::uint32_t, kMaxMaterials> load{};
  for (std::size_t m = 0; m < kMaxMaterials; ++m)
    load[m] = static_cast<std::uint32_t>(std::min(4294967295.0, std::floor(carries[m] * area * kMassOne + 0.5)));
  return load;
}

void MassLedger::birth(std::uint32_t gammaton, const std::array<std::uint32_t, kMaxMaterials>& load, Cargo& cargo) {
  cargo.mass[gammaton] = load;
  for (std::size_t m = 0; m < kMaxMaterials; ++m) {
    accounts_[m].emitted += load[m];
    accounts_[m].carried += load[m];
  }
}

void MassLedger::end(std::uint32_t gammaton, CargoEnd how, Cargo& cargo) {
  for (std::size_t m = 0; m < kMaxMaterials; ++m) {
    const std::int64_t mass = std::exchange(cargo.mass[gammaton][m], 0);
    MassAccount& account = accounts_[m];
    account.carried += -mass;
    (how == CargoEnd::Left ? account.left : how == CargoEnd::Absorbed ? account.absorbed : account.rested) += mass;
  }
}

void MassLedger::add(const ExchangeReport& report) {
  for (std::size_t m = 0; m < kMaxMaterials; ++m) {
    accounts_[m].on_surfaces += report.dropped[m] - report.picked_up[m];
    accounts_[m].carried += report.picked_up[m] - report.dropped[m];
  }
}

void MassLedger::add_rules(const std::array<std::int64_t, kMaxMaterials>& made,
                           const std::array<std::int64_t, kMaxMaterials>& used) {
  for (std::size_t m = 0; m < kMaxMaterials; ++m) {
    accounts_[m].made += made[m];
    accounts_[m].used += used[m];
    accounts_[m].on_surfaces += made[m] - used[m];
  }
}

bool MassLedger::balances() const {
  return std::all_of(accounts_.begin(), accounts_.end(),
                     [](const MassAccount& a) { return a.imbalance() == MassSum{}; });
}

std::string audit(const MassLedger& ledger, const MaterialAtlas& atlas, const Cargo& cargo,
                  std::span<const std::string> materials, const RunControl& control,
                  std::span<const std::int64_t> at_interfaces) {
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const auto material = static_cast<int>(m);
    const MassAccount& account = ledger.account(material);
    MassSum surfaces;
    surfaces += atlas.mass(material, control) - original_mass(atlas, material, control);
    if (!at_interfaces.empty()) surfaces += at_interfaces[m];
    surfaces -= account.on_surfaces;
    MassSum carried;
    for (const auto& mass : cargo.mass) carried += static_cast<std::int64_t>(mass[m]);
    carried -= account.carried;
    const MassSum balance = account.imbalance();
    const auto complain = [&](const MassSum& rest, const std::string& what) {
      return "material '" + materials[m] + "': " + what + " differ from the ledger by " + quanta_text(rest);
    };
    if (surfaces != MassSum{}) return complain(surfaces, "the surfaces");
    if (carried != MassSum{}) return complain(carried, "the gammatons");
    if (balance != MassSum{}) return complain(balance, "the ledger's own sums");
  }
  return "";
}

}  // namespace patinate::simulation
