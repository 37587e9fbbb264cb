/// \file
/// One contact of a gammaton with a texel: how much material goes which way [Guenther et al. 2012, sec. 4.2].
///
/// The ODEs, with mass in place of density so that texels of unequal area conserve it (G carried, M = amount * w on the
/// texel, w its area weight, k = kMedianWeight / w the contact area over the texel's):
///     dG/dt = c (k (1 - r) M - r G),  dM/dt = -dG/dt.
/// Linear with G + M constant: with lambda = k (1 - r) + r and d = 1 - exp(-c lambda t), G grows by (k (1 - r) M - r G)
/// d / lambda.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "libcommon/core/portable_math.h"
#include "libcommon/core/random.h"
#include "patinate/simulation/material_atlas.h"

namespace patinate::simulation {

/// transfer_kernel.inl for C++; devices read the same text. What one contact moves is TransferShares: up * amount -
/// down * carried mass, in amount quanta of the texel.
namespace transfer_kernel {
using namespace kernel_types;
using namespace portable_kernel;
using random_kernel::philox4x32_10;
#include "simulation/transport/transfer_kernel.inl"
}  // namespace transfer_kernel
namespace transfer_kernel {  // Behind it.
#include "simulation/transport/spread_kernel.inl"
}  // namespace transfer_kernel
/// The texts of transfer_kernel.inl and spread_kernel.inl.
extern const std::string_view kTransferKernel, kSpreadKernel;

using transfer_kernel::TransferShares;

/// @param ratio       r, [0, 1].
/// @param rate        c, [0, 1].
/// @param contact     Duration t, >= 0.
/// @param weight      Area weight of the texel, [1, SurfaceAtlas::kMaxWeight].
/// @param area_share  Contact area that lies on this texel, in texels of median size, > 0; the mass that exchanges is
/// that part's.
[[nodiscard]] TransferShares transfer_shares(double ratio, double rate, double contact, std::uint32_t weight,
                                             double area_share = 1.0);

/// Whole amount quanta that leave the texel (negative: arrive there): the closed form rounded to floor(x + u), right in
/// the mean for uniform u, and bounded by what is there: the texel keeps [0, kMaxAmount], the gammaton [0, limit].
/// Where a gammaton carries less than one quantum of the texel is worth (its weight in mass), it keeps that.
/// @param mass    What is carried, at most `limit`.
/// @param random  u * 2^32.
[[nodiscard]] inline std::int32_t transfer_quanta(const TransferShares& shares, std::uint32_t amount,
                                                  std::uint32_t weight, std::uint32_t mass, std::uint32_t random,
                                                  std::uint32_t limit = 0xFFFFFFFFu) {
  return transfer_kernel::moved_quanta(shares, amount, weight, mass, random, limit);
}

/// The random numbers of one contact, by material. They belong to the gammaton and the iteration, never to a thread.
/// @param piece  Which part of its splat; 0 is the middle.
/// @param num_materials  How many of them are wanted; the others may be 0.
[[nodiscard]] std::array<std::uint32_t, kMaxMaterials> transfer_randoms(std::uint64_t seed, std::uint32_t gammaton,
                                                                        std::int64_t iteration, std::uint32_t piece,
                                                                        int num_materials);

}  // namespace patinate::simulation
