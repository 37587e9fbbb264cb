"""A small capture, mesh, history and transfer, made with the binary under test."""


def make_small_scene(run):
    """Makes `capture`, `urn`, `history` and `aged` in the folder where `run(*arguments)` runs patinate; raises what went wrong."""
    for arguments in (["synth", "crackle", "--width", "48", "--height", "40", "--num-frames", "4", "-o", "capture"],
                      ["synth", "sculpture", "--resolution", "24", "-o", "urn"], ["ingest", "capture", "-o", "history"],
                      ["transfer", "history", "urn/mesh.obj", "--control", "facing", "--resolution", "64", "-o", "aged"]):
        result = run(*arguments)
        if result.returncode != 0:
            raise RuntimeError(f"{arguments}: {result.stderr}")
