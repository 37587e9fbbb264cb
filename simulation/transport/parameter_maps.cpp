#include "simulation/transport/parameter_maps.h"

namespace patinate::simulation {

ParameterMaps::ParameterMaps(const TileGrid& grid, const ParameterMapChoice& choice) : choice_(choice) {
  const auto counts = [&] { return std::make_unique<PagedValues<std::uint32_t>>(grid.num_pages()); };
  if (choice.hits) hits_ = counts();
  if (choice.last_hit || choice.residence) last_hit_ = counts();
  if (choice.residence) residence_ = counts();
  for (std::size_t i = 0; i < kMaxMaterials; ++i) {
    if (choice.deposited[i]) deposited_[i] = std::make_unique<PagedValues<std::uint64_t>>(grid.num_pages());
  }
}

void ParameterMaps::record(TexelIndex texel, std::int64_t iteration, bool is_middle,
                           const std::array<std::uint32_t, kMaxMaterials>& dropped) {
  if (hits_ && is_middle) ++hits_->at(texel);
  if (last_hit_) {
    std::uint32_t& last = last_hit_->at(texel);
    const auto now = static_cast<std::uint32_t>(iteration + 1);
    if (residence_ && last != now) ++residence_->at(texel);
    last = now;
  }
  record_deposit(texel, dropped);
}

void ParameterMaps::record_deposit(TexelIndex texel, const std::array<std::uint32_t, kMaxMaterials>& dropped) {
  for (std::size_t i = 0; i < kMaxMaterials; ++i) {
    if (deposited_[i] && dropped[i] > 0) deposited_[i]->at(texel) += dropped[i];
  }
}

std::size_t ParameterMaps::memory() const {
  std::size_t bytes = 0;
  for (const auto* map : {hits_.get(), last_hit_.get(), residence_.get()}) bytes += map ? map->memory() : 0;
  for (const auto& map : deposited_) bytes += map ? map->memory() : 0;
  return bytes;
}

}  // namespace patinate::simulation
