#include "simulation/transport/device_exchanger.h"

#include <algorithm>
#include <utility>

#include "libcommon/core/parallel.h"

namespace patinate::simulation {

namespace {
constexpr std::int64_t kChunk = 4096;                        // Contacts.
constexpr std::size_t kMostRecorded = std::size_t{1} << 20;  // Pieces that parameter maps are told of: 40 bytes each.
}  // namespace

void DeviceExchanger::use(std::shared_ptr<const SimulationDevice> device) {
  device_ = std::move(device);
  exchange_.reset();
  amounts_.reset();
}

void DeviceExchanger::note_changes(std::span<const TileIndex> tiles) {
  if (amounts_) amounts_->note_changes(tiles);
}

DeviceAmounts* DeviceExchanger::amounts(const MaterialAtlas& atlas) {
  if (!is_used()) return nullptr;
  try {
    if (!amounts_) amounts_ = std::make_unique<DeviceAmounts>(device_->device(), atlas);
    amounts_->update(atlas);
  } catch (const device::DeviceError& error) {
    fail(error);
  }
  return amounts_.get();
}

void DeviceExchanger::fail(const device::DeviceError& error) {
  device_->report_failure(error);
  exchange_.reset();
  amounts_.reset();
}

/// Stencils are laid out on the device; here what lies near a seam, and what endings leave.
void DeviceExchanger::find_cut(const WideContacts& of, double width, Pieces& pieces, const RunControl& control) {
  const TileGrid& grid = of.surface.grid();
  const bool is_deposit = !of.endings.empty();
  sizes_.assign(of.contacts.size(), 0);
  cut_.assign(of.contacts.size(), kNotCut);
  cut_contacts_.clear();
  if (is_deposit) {
    for (std::size_t i = 0; i < cut_.size(); ++i) cut_[i] = static_cast<std::uint32_t>(i);
    cut_contacts_.assign(of.contacts.begin(), of.contacts.end());
  } else if (width > 0.0) {
    const SplatShape& shape = pieces.shape_of(of.surface, width, 0);
    parallel_for(static_cast<std::int64_t>(of.contacts.size()), kChunk, control,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                     const TexelIndex texel = of.contacts[i].texel;
                     const int size = shape.size_at(texel);
                     sizes_[i] = static_cast<std::uint16_t>(size);
                     const int reach = size == 0 ? 0 : SplatShape::stencil_of(size).reach;
                     if (size > 0 && !shape.is_plain(grid.x(texel), grid.y(texel), reach)) cut_[i] = 0;
                   }
                 });
    for (std::size_t i = 0; i < cut_.size(); ++i) {
      if (cut_[i] == kNotCut) continue;
      cut_[i] = static_cast<std::uint32_t>(cut_contacts_.size());
      cut_contacts_.push_back(of.contacts[i]);
    }
  }
  const WideContacts those{.surface = of.surface,
                           .contacts = cut_contacts_,
                           .endings = of.endings,
                           .active = of.active,
                           .seed = of.seed,
                           .random_key = of.random_key};
  pieces.lay(those, width, control);
  cut_parts_.clear();
  for (std::size_t first = 0, chunk = 0; first < pieces.first_parts().back(); ++chunk) {
    const std::vector<SplatPart>& parts = pieces.parts()[chunk];
    cut_parts_.insert(cut_parts_.end(), parts.begin(), parts.end());
    first += parts.size();
  }
  cut_from_.assign(pieces.first_parts().begin(), pieces.first_parts().end());
}

std::size_t DeviceExchanger::num_pieces() const {
  std::size_t sum = cut_parts_.size();
  for (std::size_t i = 0; i < cut_.size(); ++i) {
    if (cut_[i] == kNotCut) sum += sizes_[i] == 0 ? 1 : SplatShape::stencil_of(sizes_[i]).parts.size();
  }
  return sum;
}

std::optional<ExchangeReport> DeviceExchanger::exchange(const WideContacts& of, const ExchangeOptions& options,
                                                        double width, std::int64_t iteration, Pieces& pieces,
                                                        Cargo& cargo, MaterialAtlas& atlas, ParameterMaps* maps,
                                                        const RunControl& control) {
  const bool is_deposit = !of.endings.empty();
  find_cut(of, width, pieces, control);
  if (maps != nullptr && num_pieces() > kMostRecorded) return std::nullopt;
  exchange_types::ExchangeCall call{};
  call.seed = of.seed;
  call.random_key = static_cast<std::uint64_t>(of.random_key);
  call.ratio = options.ratio;
  call.contact = options.contact;
  call.contact_area = contact_area(options, of.surface);
  call.random_piece = is_deposit ? kDepositPiece : 0;
  call.is_deposit = is_deposit ? 1 : 0;
  call.is_wide = width > 0.0 ? 1 : 0;
  for (std::size_t a = 0; a < of.active.size(); ++a)
    call.rates[a] = options.rates[static_cast<std::size_t>(of.active[a])];
  const DeviceContacts contacts{.call = call,
                                .active = of.active,
                                .contacts = of.contacts,
                                .sizes = sizes_,
                                .cut = cut_,
                                .cut_parts = cut_parts_,
                                .cut_from = cut_from_};
  try {
    const device::Device& device = device_->device();
    if (!exchange_) exchange_ = std::make_unique<DeviceExchange>(device, of.surface);
    if (!amounts_) amounts_ = std::make_unique<DeviceAmounts>(device, atlas);
    const DeviceExchangeReport done = exchange_->exchange(contacts, iteration, *amounts_, atlas, cargo, maps);
    return ExchangeReport{.dirty_tiles = done.dirty_tiles, .dropped = done.dropped, .picked_up = done.picked_up};
  } catch (const device::DeviceError& error) {
    fail(error);
    return std::nullopt;
  } catch (...) {  // Half of it may be done there, and nothing here.
    exchange_.reset();
    amounts_.reset();
    throw;
  }
}

}  // namespace patinate::simulation
