"""How materials age: histories of photographs, transfers to meshes, simulation, comparison.

    import patinate
    copper = patinate.read_history("copper")
    aged = patinate.transfer(copper, patinate.read_mesh("bust.glb"), "accessibility", resolution=512)
    texture = aged.texture(copper.times[-1])        # H x W x 3, linear

Images are numpy arrays of floats, H x W or H x W x channels, x right and y down; color is linear, Rec. 709, D65. Masks are bool or
integers, 0 outside. Lengths are in mm, times in the history's unit. Arrays that come back belong to the caller; attributes of objects are
views that cannot be written. Long calls release the interpreter's lock, take on_progress= and num_threads=, and end on Ctrl-C. Equal input
gives equal values on any number of threads, and those of the command line. Errors are patinate.Error and below, with one line each.
"""
from . import _objects, _native
from ._native import *  # noqa: F403
from ._native import __version__  # noqa: F401
from ._report import Report

_objects.install()

__all__ = [name for name in dir(_native) if not name.startswith("_")] + ["Report"]
