"""What histories and aged meshes do as Python objects: pictures in notebooks, and pickles that open a folder again."""
import pathlib
import tempfile

from . import _native

FRAMES, SIDE = 5, 240


def png(picture):
    """The bytes of a PNG. picture: H x W x 3, linear."""
    import numpy as np
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "picture.png"
        _native.write_color(path, np.ascontiguousarray(picture, np.float32))
        return path.read_bytes()


def reduced(picture, side):
    """Means of whole blocks, so that neither side is longer than about `side`."""
    block = max(1, -(-max(picture.shape[:2]) // side))
    height, width = (n // block for n in picture.shape[:2])
    return picture[:height * block, :width * block].reshape(height, block, width, block, 3).mean(axis=(1, 3))


def of_history(history):
    """Frames at even times, side by side."""
    import numpy as np
    times = np.linspace(history.times[0], history.times[-1], min(FRAMES, len(history)))
    return png(np.concatenate([reduced(history.sample(time), SIDE) for time in times], axis=1))


def of_aged(aged):
    """Three times of it, as render() shows them."""
    return png(_native.render(aged, num_times=3, width=SIDE, height=SIDE, samples=4))


def read_history(folder):
    return _native.read_history(folder)


def read_transfer(folder):
    return _native.read_transfer(folder)


def reopened_by(function):
    """What pickles an object as the folder that it lies in."""
    def reduce(self):
        if self.folder is None:
            raise _native.InvalidInput(f"it is in memory only, and a pickle would hold all of it; save() it, and {function.__name__}() that folder")
        return function, (str(pathlib.Path(self.folder).resolve()),)
    return reduce


def install():
    _native.History._repr_png_ = of_history
    _native.AgedMesh._repr_png_ = of_aged
    _native.History.__reduce__ = reopened_by(read_history)
    _native.AgedMesh.__reduce__ = reopened_by(read_transfer)
