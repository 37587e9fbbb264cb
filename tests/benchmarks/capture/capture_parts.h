/// \file
/// What capture_benchmark measures; each prints a few lines.
#pragma once

namespace patinate::benchmarks {

void measure_pair();        ///< Registration of two scans: time and accuracy, PCL in the same run.
void measure_joint();       ///< Measures all ten scans.
void measure_basin();       ///< From how far off, and by search alone.
void measure_unlighting();  ///< Albedo and normals of a relief under near lamps.
void measure_unlighting_time();
void measure_materials();  ///< Left-out lamps of metal that patinates, and the truth of its materials.
void measure_relit();      ///< Histories of the synthetic mold, disturbance by disturbance.

}  // namespace patinate::benchmarks
