/// \file
/// A study for Snakemake, and through it for Slurm.
#pragma once

#include "tools/patinate/study/study_folder.h"

namespace patinate::cli {

/// Writes into a study's folder: `Snakefile`, and `profiles/local` and `profiles/slurm`. @throws CannotComplete
void write_snakefile(const StudyFolder& study);

}  // namespace patinate::cli
