"""What `patinate study` does: reads a study, makes its folder, runs its steps or writes them for Snakemake, and reports. Called by the program."""
