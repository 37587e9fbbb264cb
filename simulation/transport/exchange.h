/// \file
/// Material goes from gammatons to texels and back, for all contacts of an iteration at once. One contact is
/// transfer.h's.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "libcommon/core/instruction_set.h"
#include "patinate/core/run_control.h"
#include "patinate/simulation/material_atlas.h"
#include "patinate/simulation/scene.h"
#include "simulation/transport/cargo.h"
#include "simulation/transport/parameter_maps.h"
#include "simulation/transport/splat.h"
#include "simulation/transport/trail.h"

namespace patinate::simulation {

/// When an exchange happens. Steps of a brush alone (Simulation::paint) share their iteration, and have random numbers
/// of their own.
struct ExchangeTime {
  ExchangeTime(std::int64_t given) : iteration(given), random_key(given) {}  // NOLINT: an iteration is one
  ExchangeTime(std::int64_t given, std::int64_t key) : iteration(given), random_key(key) {}
  std::int64_t iteration;   ///< Iteration that maps remember.
  std::int64_t random_key;  ///< In place of the iteration, for random numbers.
};

/// How large a contact is, in texels of median size: what gammatons carry are amounts over that.
[[nodiscard]] double contact_area(const ExchangeOptions& options, const SurfaceAtlas& surface);

/// Widths of splats, in texels of median size.
struct SplatWidths {
  double contact = 0.0;  ///< 0: contacts are of one texel.
  double deposit = 0.0;  ///< Before trails widen it.
};
[[nodiscard]] SplatWidths splat_widths(const ExchangeOptions& options, const SurfaceAtlas& surface);

/// How contacts lie on the surface; nullopt: on one texel each.
[[nodiscard]] std::optional<SplatShape> splat_shape(const ExchangeOptions& options, const SurfaceAtlas& surface);

/// From how much of the surface a contact reaches a texel of an area weight, in texels of the median size: the texel,
/// and with splats all those whose splats have a part of it.
[[nodiscard]] double reached_from(const ExchangeOptions& options, const SurfaceAtlas& surface, std::uint32_t weight);

/// Changes by an exchange.
struct ExchangeReport {
  std::span<const TileIndex> dirty_tiles;  ///< With texels whose amounts changed; rising. Good until the next exchange.
  std::array<std::int64_t, kMaxMaterials> dropped{};    ///< Mass from gammatons to the surface.
  std::array<std::int64_t, kMaxMaterials> picked_up{};  ///< Mass from the surface to gammatons.
};

/// Exchanges material, keeping its working memory from call to call.
class Exchanger {
 public:
  /// @param seed  Of the scene.
  /// @throws InvalidInput if this machine lacks the instruction set.
  Exchanger(int num_materials, std::uint64_t seed, InstructionSet set = instruction_set());
  ~Exchanger();
  Exchanger(Exchanger&&) noexcept;
  Exchanger& operator=(Exchanger&&) noexcept;

  /// Every contact moves whole quanta between its gammaton's cargo and its texel: transfer_quanta() with
  /// transfer_randoms() of (seed, gammaton, time.random_key). Contacts of one texel follow each other by gammaton. A
  /// splat wider than one texel is cut into parts (splat.h) that exchange on their own; the cargo is dealt out to them
  /// in whole quanta, in the mean by their shares. Mass is conserved exactly: what the cargo loses is what the texels
  /// win. Same bits for any number of threads, order of contacts and instruction set.
  /// @param contacts  Each gammaton at most once; covered texels of `atlas`; in the order of gammatons if it is to be
  /// fast.
  /// @param options   Taken as checked (check_scene()).
  /// @param maps      Recorded too, unless null.
  /// @param control   Threads; an exchange that has begun is finished whatever `stop` says.
  ExchangeReport exchange(std::span<const Contact> contacts, const ExchangeOptions& options, ExchangeTime time,
                          Cargo& cargo, MaterialAtlas& atlas, ParameterMaps* maps = nullptr,
                          const RunControl& control = {});

  /// Gammatons that end on the surface leave their cargo along the way that they came, most of it at its end: of
  /// every material with a rate all of it, in whole quanta of texels, as much as fits. A texel that several end on is
  /// filled in the order of gammatons. No contact: parameter maps know of the mass alone.
  /// @param endings  Each gammaton at most once, in their order.
  ExchangeReport deposit(std::span<const Ending> endings, const ExchangeOptions& options, ExchangeTime time,
                         Cargo& cargo, MaterialAtlas& atlas, ParameterMaps* maps = nullptr,
                         const RunControl& control = {});

 private:
  ExchangeReport run(std::span<const Contact> contacts, std::span<const Ending> endings, const ExchangeOptions& options,
                     ExchangeTime time, Cargo& cargo, MaterialAtlas& atlas, ParameterMaps* maps,
                     const RunControl& control);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace patinate::simulation
