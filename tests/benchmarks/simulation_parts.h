/// \file
/// Parts of simulation_benchmark: one function each, listed in its main().
#pragma once

namespace patinate::benchmarks {

/// Rays/s against Embree, incoherent, one thread.
void rays();
/// Segments/s of trace() and respond() alone.
void gammatons();
/// Material between gammatons and texels, by atlas size and number of contacts.
void exchange();
/// Three rules over an atlas, by its size, its wet part and the instruction set.
void rules();
/// Everything composed again after a post-control moved, and a tenth of the tiles, by atlas size and instruction set.
void composition();
/// Whole iterations by atlas size and wetness; segments/s all in.
void iteration();
/// Measures iterations on every device.
void iteration_on_devices();
/// Each part of an iteration on the chest of several objects, by atlas size and number of gammatons.
void chest();
/// The mass ledger after a million iterations.
void mass_balance();

}  // namespace patinate::benchmarks
