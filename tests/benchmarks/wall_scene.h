/// \file
/// What iterations are measured on.
#pragma once

#include "patinate/simulation/engine.h"

namespace patinate::benchmarks {

/// The wall with sills, 5,000 gammatons.
[[nodiscard]] simulation::Scene wall(int resolution);
/// Wall where water dries slowly: rules have work wherever it is wet, and it stays so.
[[nodiscard]] simulation::Scene slow_wall(int resolution);

/// Wets whole tiles of 8 x 8 texels, so many of them, some here, some there.
void make_wet(simulation::Simulation& simulation, double share);

/// Share of the covered texels.
[[nodiscard]] double wet_share(const simulation::Simulation& simulation);

}  // namespace patinate::benchmarks
