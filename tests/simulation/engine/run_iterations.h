/// \file
/// Many steps of a simulation.
#pragma once

#include "patinate/simulation/engine.h"

namespace patinate::testing_support {

inline void run_iterations(simulation::Simulation& simulation, int num_iterations, int num_threads = 0) {
  RunControl control;
  control.num_threads = num_threads;
  for (int i = 0; i < num_iterations; ++i) simulation.step(control);
}

}  // namespace patinate::testing_support
